/// A cubic polynomial in the distance from its start: `a + b·ds + c·ds² + d·ds³`.
///
/// # Source
/// OpenDRIVE: lane widths, lane offsets, borders.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cubic {
    /// Where it starts to apply (m).
    pub start: f64,
    /// Value at `start`.
    pub a: f64,
    /// Slope at `start`.
    pub b: f64,
    /// Coefficient of the square.
    pub c: f64,
    /// Coefficient of the cube.
    pub d: f64,
}

impl Cubic {
    /// A value that stays the same.
    pub fn constant(value: f64) -> Self {
        Self { a: value, ..Self::default() }
    }

    /// The value at `s` (m).
    pub fn value(&self, s: f64) -> f64 {
        let ds = s - self.start;
        self.a + ds * (self.b + ds * (self.c + ds * self.d))
    }

    /// The places at which the slope is 0 (m); no numbers where there are none.
    fn turning_points(&self) -> [f64; 2] {
        let root = (self.c * self.c - 3.0 * self.d * self.b).sqrt();
        // Where one denominator is 0 or nearly so, the other formula is exact.
        let q = if self.c >= 0.0 { -self.c - root } else { -self.c + root };
        [self.start + q / (3.0 * self.d), self.start + self.b / q]
    }

    /// The slope at `s` (m).
    pub fn slope(&self, s: f64) -> f64 {
        let ds = s - self.start;
        self.b + ds * (2.0 * self.c + ds * 3.0 * self.d)
    }
}

/// Starts of cubics that are nearer to each other are one place (m).
const SAME_PLACE: f64 = 1e-6;

/// Consecutive cubics, sorted by their starts; the first one also applies before its start.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile(Vec<Cubic>);

impl Profile {
    /// Puts cubics in order. Of two at one place the later one applies, also if it begins a rounding error before the other.
    pub fn new(mut cubics: Vec<Cubic>) -> Self {
        cubics.iter_mut().fold(f64::NEG_INFINITY, |last, cubic| {
            let rounded = (last - SAME_PLACE..last).contains(&cubic.start);
            cubic.start = if rounded { last } else { cubic.start };
            cubic.start
        });
        cubics.sort_by(|a, b| a.start.total_cmp(&b.start));
        Self(cubics)
    }

    /// A value that stays the same.
    pub fn constant(value: f64) -> Self {
        Self(vec![Cubic::constant(value)])
    }

    pub fn cubics(&self) -> &[Cubic] {
        &self.0
    }

    /// The cubic that applies at `s` (m); `None` in an empty profile.
    pub fn at(&self, s: f64) -> Option<&Cubic> {
        let after = self.0.partition_point(|cubic| cubic.start <= s);
        self.0.get(after.saturating_sub(1))
    }

    /// The value at `s` (m); 0 in an empty profile.
    pub fn value(&self, s: f64) -> f64 {
        self.at(s).map_or(0.0, |cubic| cubic.value(s))
    }

    /// The slope at `s` (m); 0 in an empty profile.
    pub fn slope(&self, s: f64) -> f64 {
        self.at(s).map_or(0.0, |cubic| cubic.slope(s))
    }

    /// A number that no value exceeds up to `end` (m); 0 for an empty profile.
    pub fn bound(&self, end: f64) -> f64 {
        let each = self.0.iter().map(|cubic| {
            let u = (end - cubic.start).max(0.0);
            cubic.a.abs() + u * (cubic.b.abs() + u * (cubic.c.abs() + u * cubic.d.abs()))
        });
        each.fold(0.0, f64::max)
    }

    /// The places from `start` to `end` (m) at which a value may be the least or the greatest one, with the values; none of an empty profile.
    pub fn extremes(&self, start: f64, end: f64) -> impl Iterator<Item = (f64, f64)> {
        let ends = self.0.iter().skip(1).map(|next| next.start).chain([f64::INFINITY]);
        let pieces = self.0.iter().zip(ends).enumerate().filter_map(move |(index, (cubic, until))| {
            let from = if index == 0 { start } else { cubic.start.max(start) };
            (from <= end && until > start).then_some((cubic, from, until.min(end)))
        });
        pieces.flat_map(|(cubic, from, to)| {
            let inside = cubic.turning_points().map(move |s| if s > from && s < to { s } else { from });
            [from, to].into_iter().chain(inside).map(|s| (s, cubic.value(s)))
        })
    }

    /// The sum of profiles, each multiplied by a factor, from `start` to `end` (m); exact, since sums of cubics are cubics.
    pub fn sum(terms: &[(&Self, f64)], start: f64, end: f64) -> Self {
        let begins = terms.iter().flat_map(|(profile, _)| &profile.0).map(|cubic| cubic.start);
        let mut begins: Vec<f64> = begins.filter(|s| *s > start && *s < end).collect();
        begins.push(start);
        begins.sort_by(f64::total_cmp);
        begins.dedup();
        let at = |s: f64| {
            let mut sum = Cubic { start: s, ..Cubic::default() };
            for (cubic, factor) in terms.iter().filter_map(|(profile, factor)| Some((profile.at(s)?, factor))) {
                sum.a += factor * cubic.value(s);
                sum.b += factor * cubic.slope(s);
                sum.c += factor * (cubic.c + 3.0 * cubic.d * (s - cubic.start));
                sum.d += factor * cubic.d;
            }
            sum
        };
        Self(begins.into_iter().map(at).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_cubics_at_one_place_the_later_one_applies() {
        let second = Cubic { start: 137.699_999_990_024_25, a: -3.7, b: 0.068_9, ..Cubic::default() };
        let first = Cubic { start: 137.700_000_000_016_44, b: 0.0, ..second };
        assert!((Profile::new(vec![first, second]).value(190.1) + 0.09).abs() < 0.01);
    }
}
