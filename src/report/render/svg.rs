/// Colours that stay apart for colour-blind readers.
///
/// # Source
/// Okabe and Ito, *Color universal design*, 2008.
pub const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];

/// Text as it stands in an SVG picture.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
