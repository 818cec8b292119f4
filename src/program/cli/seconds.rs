/// Reads a time from 0.001 s to an hour (s).
///
/// # Errors
/// Another text, as clap shows it to the user.
pub fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.001..=3600.0).contains(&seconds) { Ok(seconds) } else { Err("must be from 0.001 to 3600".into()) }
}
