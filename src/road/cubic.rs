/// A cubic polynomial in the distance from where it begins to hold: `a + b·ds + c·ds² + d·ds³`.
///
/// # Source
/// OpenDRIVE: lane widths, lane offsets, borders.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cubic {
    /// Where it begins to hold [m].
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

    /// The value at `s` [m].
    pub fn value(&self, s: f64) -> f64 {
        let ds = s - self.start;
        self.a + ds * (self.b + ds * (self.c + ds * self.d))
    }

    /// The slope at `s` [m].
    pub fn slope(&self, s: f64) -> f64 {
        let ds = s - self.start;
        self.b + ds * (2.0 * self.c + ds * 3.0 * self.d)
    }
}

/// Consecutive cubics, sorted by where they begin; the first one also holds before its beginning.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile(Vec<Cubic>);

impl Profile {
    /// Puts cubics in order.
    pub fn new(mut cubics: Vec<Cubic>) -> Self {
        cubics.sort_by(|a, b| a.start.total_cmp(&b.start));
        Self(cubics)
    }

    /// A value that stays the same.
    pub fn constant(value: f64) -> Self {
        Self(vec![Cubic::constant(value)])
    }

    /// The cubics.
    pub fn cubics(&self) -> &[Cubic] {
        &self.0
    }

    /// The cubic that holds at `s` [m]; none in an empty profile.
    pub fn at(&self, s: f64) -> Option<&Cubic> {
        let after = self.0.partition_point(|cubic| cubic.start <= s);
        self.0.get(after.saturating_sub(1))
    }

    /// The value at `s` [m]; 0 in an empty profile.
    pub fn value(&self, s: f64) -> f64 {
        self.at(s).map_or(0.0, |cubic| cubic.value(s))
    }

    /// The slope at `s` [m]; 0 in an empty profile.
    pub fn slope(&self, s: f64) -> f64 {
        self.at(s).map_or(0.0, |cubic| cubic.slope(s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cubic_holds_from_its_beginning() {
        let profile = Profile::new(vec![
            Cubic { start: 10.0, a: 5.0, b: 1.0, c: 0.5, d: 0.25 },
            Cubic { start: 0.0, a: 3.0, ..Cubic::default() },
        ]);
        assert_eq!((profile.value(-1.0), profile.value(9.0)), (3.0, 3.0));
        assert_eq!(profile.value(12.0), 5.0 + 2.0 + 2.0 + 2.0);
        assert_eq!(profile.slope(12.0), 1.0 + 2.0 + 3.0);
        assert_eq!(Profile::default().value(1.0), 0.0);
    }
}
