use base::units::Dimension;
use episode::requirement::{Degree, NamedRequirement};

/// The unit of a requirement's robustness, in SI; empty if it is scaled, and of plain numbers.
pub fn unit_of(named: &NamedRequirement) -> &'static str {
    match named.requirement.dimension() {
        Some(Dimension::ANGLE) => "rad",
        Some(dimension) => dimension.usual_units().first().copied().unwrap_or_default(),
        None => "",
    }
}

/// The comparison that decides a degree of a requirement, as the scenario writes it.
pub fn part_of<'a>(named: &'a NamedRequirement, degree: &Degree) -> Option<&'a str> {
    Some(&named.requirement.parts.get(usize::from(degree.part?))?.text)
}

/// By how much a requirement is violated, and which comparison decides: ` by 0.31 m/s; `ego_speed < 3 m/s` decides`. Empty if neither is known.
pub fn violated_part(named: &NamedRequirement, degree: &Degree) -> String {
    let known = Some(-degree.robustness).filter(|by| by.is_finite() && *by != 0.0);
    let by = known.map_or(String::new(), |by| format!(" by {by:.2} {}", unit_of(named)).trim_end().to_string());
    let scaled = if named.requirement.is_scaled() && !by.is_empty() { " (scaled)" } else { "" };
    let part = part_of(named, degree).map_or(String::new(), |part| format!("; `{part}` decides"));
    format!("{by}{scaled}{part}")
}
