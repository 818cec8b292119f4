/// Writes past the capture of test output, so that a skipped test is visible.
macro_rules! loud {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}
