use std::fmt::Write;

/// The rules by which figures are coloured, in names of [`PALETTE`].
pub const FIGURE_CSS: &str = include_str!("figure.css");

/// Every colour of page and figures: name, light, dark.
///
/// The series `c…` are distinct for colour-blind readers. `v…` are the verdicts, from those that the driver is responsible for to those
/// that it is not. `h…` follow a rate, in luminance too.
///
/// # Source
/// Okabe and Ito, *Color universal design*, 2008, lightened for dark ground.
const PALETTE: [(&str, &str, &str); 36] = [
    ("paper", "#ffffff", "#14171a"),
    ("raised", "#f6f7f8", "#1c2024"),
    ("ink", "#1b1f23", "#e6e9ec"),
    ("muted", "#626a73", "#98a1aa"),
    ("grid", "#e3e6e9", "#2d3339"),
    ("accent", "#0b62a8", "#6bb3ee"),
    ("warn", "#a33b00", "#f59a63"),
    ("c0", "#0072b2", "#56aee8"),
    ("c1", "#d55e00", "#f58b45"),
    ("c2", "#009e73", "#35c79d"),
    ("c3", "#b3579a", "#e29bcb"),
    ("c4", "#b98300", "#edb944"),
    ("c5", "#3aa0d8", "#a5d8f7"),
    ("c6", "#7b838b", "#99a2ab"),
    ("v0", "#c8460c", "#e8703a"),
    ("v1", "#eda23b", "#d99a3d"),
    ("v2", "#f3d58c", "#a38a4e"),
    ("v3", "#5a9bc8", "#4f8cb8"),
    ("v4", "#cfd4d9", "#444c54"),
    ("h0", "#d9dee3", "#353c43"),
    ("h1", "#fbd0a0", "#6b4526"),
    ("h2", "#f6a663", "#a15d26"),
    ("h3", "#e56f2c", "#dd7a35"),
    ("h4", "#bb3a0d", "#f7a56c"),
    ("h5", "#6f1703", "#ffdcc4"),
    ("ground", "#edf0ea", "#1a1e1b"),
    ("walk", "#d9dbdc", "#2c3033"),
    ("lane", "#b9bec3", "#3b4147"),
    ("marking", "#f7f7f4", "#6d747b"),
    ("zebra", "#f7f7f4", "#6d747b"),
    ("house", "#cdbfa9", "#4d4436"),
    ("car", "#0b62a8", "#6bb3ee"),
    ("person", "#c0271a", "#ff8374"),
    ("seen", "#12855a", "#35c79d"),
    ("brake", "#e0201b", "#ff5a50"),
    ("edge", "#ffffff", "#14171a"),
];

/// The colours as custom properties of a page: by the reader's system setting, or by `data-theme` of the root.
pub fn properties() -> String {
    let list = |dark: bool| {
        let pick = |light, night| if dark { night } else { light };
        PALETTE.iter().fold(String::new(), |mut text, (name, light, night)| {
            let _ = write!(text, "--{name}:{};", pick(*light, *night));
            text
        })
    };
    format!(
        ":root{{color-scheme:light;{light}}}\n:root[data-theme=dark]{{color-scheme:dark;{dark}}}\n\
         @media screen and (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{dark}}}}}\n\
         @media print{{:root,:root[data-theme=dark]{{color-scheme:light;{light}}}}}\n",
        light = list(false),
        dark = list(true),
    )
}

/// Rules with the light colours in place of their names, for files.
pub fn fixed(css: &str) -> String {
    PALETTE.iter().fold(css.to_string(), |css, (name, light, _)| css.replace(&format!("var(--{name})"), light))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_figure_names_a_colour_that_there_is_not() {
        let css = fixed(FIGURE_CSS);
        assert!(!css.contains("var("), "{css}");
    }
}
