use std::fmt;

use maud::Render;

/// A number of a picture with as many digits as are visible; zeros at the end are omitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Digits(pub f64, pub usize);

/// A number to a tenth: pixels.
pub fn px(number: f64) -> Digits {
    Digits(number, 1)
}

/// A number to a hundredth: metres, scales.
pub fn fine(number: f64) -> Digits {
    Digits(number, 2)
}

impl fmt::Display for Digits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.*}", self.1, self.0);
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

impl Render for Digits {
    fn render_to(&self, buffer: &mut String) {
        buffer.push_str(&self.to_string());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_are_exact() {
        let text: Vec<String> = [12.0, -0.04, 0.25, 100.0, -3.46].map(|number| px(number).to_string()).into();
        assert_eq!(text, ["12", "0", "0.2", "100", "-3.5"]);
        assert_eq!(fine(0.125).to_string(), "0.12");
        assert_eq!(Digits(120.0, 0).to_string(), "120");
    }
}
