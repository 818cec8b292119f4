use super::setting::rounded;
use super::{Cause, TurnedBy};
use crate::av::Weakness;

impl Cause {
    /// The cause in a few sentences, without the name of the driver: `drives off after a red light, sees her for 2.4 s and does not brake: …`, then the setting
    /// that avoids it.
    pub fn sentence(&self) -> String {
        let cut = match self.is_cut {
            true => format!(" The limit of {} runs was reached, so not all was tried.", self.runs),
            false => String::new(),
        };
        if self.is_cut && self.weakness == Weakness::NotFound {
            return format!("A cause was not found.{cut}");
        }
        let drove_off = match self.drove_off {
            Some(true) => "drives off after a red light, ",
            Some(false) => "drives off, ",
            None => "",
        };
        let act = match (self.reacted, self.braked) {
            (None, _) => "does not react".to_string(),
            (Some(reacted), None) => format!("reacts {reacted:.1} s before {}, but does not brake", self.end),
            (Some(_), Some(braked)) => format!("brakes {braked:.1} s before {}", self.end),
        };
        let why = self.why();
        let without = self.without.as_ref().map(|what| format!("without {what} it avoids it"));
        let without = without.map(|without| format!("; {without}")).unwrap_or_default();
        let enough = self.repairs();
        let setting = self.setting.as_ref().map_or(String::new(), |setting| format!(" {}", setting.text()));
        format!(
            "The driver {drove_off}has the pedestrian in sight for {:.1} s and {act}: {why}{enough}{without}.{setting}{cut}",
            self.seen
        )
    }

    /// Which of two repairs are enough, each alone; empty of one that the cause already says. A repair of what is named that was tried and is not enough is
    /// said, too.
    fn repairs(&self) -> String {
        let on_side = format!("a reaction to people on its {}", self.side.unwrap_or("blind side"));
        let repair = |weakness: &Weakness| match weakness {
            Weakness::Hidden => "sight through the obstacle",
            Weakness::BlindSide => on_side.as_str(),
            Weakness::Range => "a longer range",
            Weakness::Errors | Weakness::Dropouts => "exact sensors",
            Weakness::Delay => "a prompt response",
            Weakness::WeakBrake => "full braking once it brakes",
            Weakness::LetsGo => "to keep the brake",
            Weakness::Distance => "to brake farther ahead",
            Weakness::Anticipation => "a true forecast of the pedestrian",
            Weakness::Corridor => "a wider corridor",
            Weakness::Ignores | Weakness::NotFound => "to brake for people",
        };
        // From the other side a pedestrian often misses the way of the car, so that run shows nothing if it fails.
        let is_tried =
            matches!(self.weakness, Weakness::Range | Weakness::Distance | Weakness::Delay | Weakness::Anticipation);
        let own = repair(&self.weakness);
        match self.enough.as_slice() {
            [one, other] => format!("; either of these alone avoids it: {}, or {}", repair(one), repair(other)),
            [one] if *one == self.weakness => String::new(),
            [one] if is_tried => format!("; {} alone avoids it, {own} alone does not", repair(one)),
            [one] => format!("; {} alone avoids it", repair(one)),
            [] if is_tried => format!("; {own} alone does not avoid it"),
            _ => String::new(),
        }
    }

    /// What it lacks, as a part of a sentence.
    pub fn why(&self) -> String {
        let amount = self.amount;
        // A run without errors of declared sensors; else it may be the driver that does not look.
        let of_sensors = self.tried.iter().any(|(what, turns)| *turns && what == "exact sensors");
        let side = self.side.unwrap_or("blind side");
        let by = |unit: &str| amount.map_or(String::new(), |amount| format!(" {amount:.1} {unit}"));
        match self.weakness {
            Weakness::Ignores => match self.reacted {
                None => "it ignores pedestrians, its commands are those of an empty road, bit for bit".into(),
                Some(_) => "it ignores pedestrians who are near, it neither brakes for them nor leaves its way".into(),
            },
            Weakness::Hidden => {
                "an obstacle hides the pedestrian for too long, with sight through it the driver avoids it".into()
            }
            Weakness::BlindSide if of_sensors => format!("its sensors do not see pedestrians on its {side}"),
            Weakness::BlindSide => {
                let aside = amount.map_or("less".into(), |aside| format!("only up to {aside:.1} m beside its axis"));
                let is_shown = self.enough.contains(&Weakness::BlindSide);
                let other = if is_shown { ", and avoids the same one from the other side" } else { "" };
                format!("on its {side} it reacts to people {aside}{other}")
            }
            Weakness::Range => match amount {
                Some(range) => format!("it notices somebody in its way only {range:.1} m ahead, at any speed"),
                None => "its sensors do not reach far enough".into(),
            },
            Weakness::Dropouts if of_sensors => "its sensors lose the pedestrian".into(),
            Weakness::Dropouts => "it loses pedestrians: to somebody near it reacts at once at some moments, and late or not at all at others".into(),
            Weakness::Errors => "its sensors mistake the pedestrian, with exact ones it avoids it".into(),
            Weakness::Delay => match amount {
                Some(time) => format!("it responds {time:.2} s late"),
                None => "it responds late".into(),
            },
            Weakness::WeakBrake => format!(
                "it brakes too weakly{}, full braking from the same moment on avoids it",
                amount.map_or(String::new(), |hardest| format!(", at most {hardest:.1} m/s²"))
            ),
            Weakness::LetsGo => "it lets go of the brake, and avoids it if it keeps it".into(),
            Weakness::Distance => {
                format!("it brakes too late for its speed, for somebody in its way only{} ahead", by("m"))
            }
            Weakness::Anticipation => "it does not expect where the pedestrian will be".into(),
            Weakness::Corridor => {
                format!("the pedestrian is outside the corridor that it watches; with{} more it avoids it", by("m"))
            }
            Weakness::NotFound => "a cause was not found".into(),
        }
    }

    /// What was tried, and what of it shows something.
    pub fn trials(&self) -> String {
        let words = |turns: bool| {
            let words = self.tried.iter().filter(|(_, does)| *does == turns).map(|(what, _)| what.as_str());
            Some(words.collect::<Vec<_>>().join(", ")).filter(|words| !words.is_empty())
        };
        let [does, not] = [true, false].map(|turns| words(turns).unwrap_or_else(|| "nothing".into()));
        format!("Tried, and it helps or shows a weakness: {does}. Tried without effect: {not}.")
    }

    /// When braking and swerving help for the last time.
    pub fn last_chances(&self) -> String {
        let text = |(what, last): (&str, Option<f64>)| match last {
            Some(time) => format!("{what} helps up to {time:.2} s before {}", self.end),
            None => format!("{what} never helps"),
        };
        let all = ["Full braking", "comfortable braking", "swerving"].into_iter().zip(self.last).map(text);
        all.collect::<Vec<_>>().join(", ") + "."
    }

    /// What of the driver must be perfect: `Perfect prediction or a perfect brake avoids it; no delay does not avoid it.`
    pub fn perfected(&self) -> String {
        let list = |turns: bool| {
            let words = self.faculties.iter().filter(|(_, does)| *does == turns).map(|(what, _)| *what);
            Some(words.collect::<Vec<_>>().join(" or ")).filter(|words| !words.is_empty())
        };
        let does = list(true).map(|words| format!("{words} avoids it"));
        let not = list(false).map(|words| format!("{words} does not avoid it"));
        let text = does.into_iter().chain(not).collect::<Vec<_>>().join("; ") + ".";
        text[..1].to_uppercase() + &text[1..]
    }
}

impl TurnedBy {
    /// As ``With `margin` of at least 0.7 m instead of 0.3 m it avoids it.``, with the faults that it adds in natural episodes.
    pub fn text(&self) -> String {
        let Self { name, from, to, natural: [before, now], .. } = self;
        let bound = if to > from { "least" } else { "most" };
        let more = match now.faults > before.faults {
            true => format!(
                ", but has {} faults instead of {} in {} natural episodes",
                now.faults, before.faults, now.episodes
            ),
            false => String::new(),
        };
        format!("With `{name}` of at {bound} {} instead of {} it avoids it{more}.", self.value(*to), self.value(*from))
    }

    fn value(&self, value: f64) -> String {
        format!("{} {}", base::signature::short(rounded(value, value.abs())), self.unit).trim_end().to_string()
    }

    /// What it costs in natural episodes.
    pub fn cost(&self) -> String {
        let [before, now] = &self.natural;
        let speed = |of: fn(&crate::hardening::Traffic) -> Option<f64>, traffic| of(traffic).unwrap_or(0.0);
        let (a, b) = (speed(|t| t.speed(), before), speed(|t| t.speed(), now));
        let (c, d) = (speed(|t| t.braking_rate(), before), speed(|t| t.braking_rate(), now));
        format!(
            "With `{}` {}, in {} natural episodes it drives {b:.2} m/s on average instead of {a:.2} m/s, brakes hard in {:.0} % instead of {:.0} %, \
             and has {} faults instead of {}.",
            self.name,
            self.value(self.to),
            now.episodes,
            100.0 * d,
            100.0 * c,
            now.faults,
            before.faults
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_are_blamed_only_if_exact_ones_avoid_it() {
        for weakness in [Weakness::BlindSide, Weakness::Dropouts] {
            let said =
                |turns| Cause { weakness, tried: vec![("exact sensors".into(), turns)], ..Cause::default() }.sentence();
            assert!(said(true).contains("its sensors") && !said(false).contains("sensors"), "{}", said(false));
        }
    }

    #[test]
    fn a_repair_that_was_tried_and_is_not_enough_is_said() {
        let said =
            |weakness, enough: &[Weakness]| Cause { weakness, enough: enough.into(), ..Cause::default() }.repairs();
        let forecast = "a true forecast of the pedestrian alone avoids it";
        let only = said(Weakness::Range, &[Weakness::Anticipation]);
        assert_eq!(only, format!("; {forecast}, a longer range alone does not"));
        assert_eq!(said(Weakness::BlindSide, &[Weakness::Anticipation]), format!("; {forecast}"));
        assert_eq!(said(Weakness::Range, &[]), "; a longer range alone does not avoid it");
        assert_eq!(said(Weakness::Range, &[Weakness::Range]), "", "the cause says it");
    }
}
