use super::setting::rounded;
use super::{Cause, FACULTIES, TurnedBy};
use world::av::Weakness;

/// What of a driver is perfect if a weakness is repaired; `None` if that is none of the faculties.
pub(super) fn faculty(weakness: Weakness) -> Option<&'static str> {
    let place = match weakness {
        Weakness::Hidden | Weakness::BlindSide | Weakness::Range | Weakness::Errors | Weakness::Dropouts => 0,
        Weakness::Anticipation => 1,
        Weakness::WeakBrake | Weakness::LetsGo => 2,
        Weakness::Delay => 3,
        Weakness::Distance
        | Weakness::Corridor
        | Weakness::Speed
        | Weakness::Reaction
        | Weakness::Ignores
        | Weakness::NotFound => return None,
    };
    Some(FACULTIES[place])
}

impl Cause {
    /// The cause in a few sentences, without the name of the driver: the violation of a requirement, `The driver drives off after a red light, has the pedestrian
    /// in sight for 2.4 s and does not react: …`, then the setting that avoids it.
    pub fn sentence(&self) -> String {
        let cut = match self.fault {
            Some(fault) => {
                format!(" With one thing changed, the driver {fault} in run {}: not all was tried.", self.runs)
            }
            None if self.is_cut => format!(" The limit of {} runs was reached, so not all was tried.", self.runs),
            None => String::new(),
        };
        let (who, violated) = match &self.violated {
            Some(violated) => ("It", format!("The driver violates {violated}. ")),
            None => ("The driver", String::new()),
        };
        if self.is_cut && self.weakness == Weakness::NotFound {
            return format!("{violated}A cause was not found.{cut}");
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
        let setting = self.setting.as_ref().map_or(String::new(), |setting| format!(" {}", setting.text()));
        let draws =
            |[avoided, all]: [u32; 2]| format!(" With other draws of the driver it avoids it in {avoided} of {all}.");
        let setting = setting + &self.draws.map(draws).unwrap_or_default();
        format!(
            "{violated}{who} {drove_off}has the pedestrian in sight for {:.1} s and {act}: {why}{without}.{setting}{cut}",
            self.seen
        )
    }

    /// What it lacks and what avoids it, as a part of a sentence.
    pub fn why(&self) -> String {
        let is_enough = self.enough.contains(&self.weakness);
        let lack = self.lack();
        match self.repairs().as_slice() {
            [one, other] if is_enough => format!("{lack}; either of these alone avoids it: {one}, or {other}"),
            [one, ..] if !is_enough => format!("{lack}; {one} alone avoids it"),
            _ => lack,
        }
    }

    /// At most two repairs that avoid it, each alone: of weaknesses, the named one first, then what else is enough if it is perfect.
    fn repairs(&self) -> Vec<String> {
        let is_said = |what| self.enough.iter().any(|weakness| faculty(*weakness) == Some(what));
        let perfect = self.faculties.iter().filter(|(what, turns)| *turns && !is_said(*what));
        let enough = self.enough.iter().map(|weakness| self.repair(*weakness));
        enough.chain(perfect.map(|(what, _)| (*what).to_string())).take(2).collect()
    }

    /// What repairs a weakness.
    fn repair(&self, weakness: Weakness) -> String {
        match weakness {
            Weakness::Hidden => "sight through the obstacle",
            Weakness::BlindSide => return format!("a reaction to people on its {}", self.side.unwrap_or("blind side")),
            Weakness::Range => "a longer range",
            Weakness::Errors | Weakness::Dropouts => "exact sensors",
            Weakness::Delay => "a prompt response",
            Weakness::WeakBrake => "full braking once it brakes",
            Weakness::LetsGo => "to keep the brake",
            Weakness::Distance => "to brake farther ahead",
            Weakness::Anticipation => "a forecast of the pedestrian's way",
            Weakness::Corridor => "a wider corridor",
            Weakness::Speed => "to read its speed right",
            Weakness::Reaction => "no reaction to the pedestrian",
            Weakness::Ignores | Weakness::NotFound => "to brake for people",
        }
        .into()
    }

    /// What it lacks. Amounts are those of this encounter.
    fn lack(&self) -> String {
        let amount = self.amount;
        // A run without errors of declared sensors; else it may be the driver that does not look.
        let of_sensors = self.tried.iter().any(|(what, turns)| *turns && what == "exact sensors");
        let side = self.side.unwrap_or("blind side");
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
                Some(range) => {
                    format!("it notices people in its way only {range:.1} m ahead, at any speed")
                }
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
                let at = amount.map(|gap| format!(", only {gap:.1} m ahead of somebody in its way"));
                format!("it brakes too late for its speed{}", at.unwrap_or_default())
            }
            Weakness::Anticipation => "it does not expect where the pedestrian will be, its commands are the same as if they stood".into(),
            Weakness::Corridor => {
                let aside = amount.map_or(String::new(), |aside| format!(" {aside:.1} m"));
                format!("the pedestrian is outside the corridor that it watches; with{aside} more it avoids it")
            }
            Weakness::Speed => format!(
                "on an empty road it drives {:.1} m/s above the limit, as if it read its speed so much too low",
                amount.unwrap_or(0.0)
            ),
            Weakness::Reaction => "its reaction leads into the pedestrian, whom it misses if it does not see them".into(),
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
        let speed = |of: fn(&crate::Traffic) -> Option<f64>, traffic| of(traffic).unwrap_or(0.0);
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
    fn another_repair_that_is_enough_is_said() {
        let said = |weakness, enough: &[Weakness], perfect| {
            let cause = Cause { weakness, enough: enough.into(), faculties: vec![(perfect, true)], ..Cause::default() };
            cause.why().replace(&cause.lack(), "LACK")
        };
        let forecast = "a forecast of the pedestrian's way alone avoids it";
        assert_eq!(
            said(Weakness::BlindSide, &[Weakness::Anticipation], "perfect prediction"),
            format!("LACK; {forecast}")
        );
        let both = said(Weakness::Range, &[Weakness::Range], "a perfect brake");
        assert_eq!(both, "LACK; either of these alone avoids it: a longer range, or a perfect brake");
        assert_eq!(said(Weakness::Delay, &[Weakness::Delay], "no delay"), "LACK", "the cause says it");
    }

    #[test]
    fn a_violated_requirement_comes_first() {
        let violated = Some("`slow_pass` 3.2 s after the start by 0.31 m/s".into());
        let said = Cause { violated, end: "the end of the episode", ..Cause::default() }.sentence();
        let first = "The driver violates `slow_pass` 3.2 s after the start by 0.31 m/s. It has the pedestrian in sight";
        assert!(said.starts_with(first), "{said}");
    }
}
