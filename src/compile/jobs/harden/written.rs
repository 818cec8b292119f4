use base::signature::short;

/// A policy as the files write it.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenPolicy {
    pub name: String,
    pub kind: &'static str,
    /// Its keys with their values as written.
    pub keys: Vec<(&'static str, String)>,
    /// What each varied number is, in their order.
    pub varied: Vec<VariedKey>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum VariedKey {
    /// The value of a key, in this unit of SI.
    Key { key: &'static str, unit: &'static str },
    /// A parameter of a program, which its greeting tells it.
    Parameter { name: String },
}

/// The key with the parameters of a program.
pub(crate) const PARAMETERS: &str = "parameters";

impl VariedKey {
    pub(crate) fn is_key(&self, name: &str) -> bool {
        matches!(self, Self::Key { key, .. } if *key == name)
    }

    pub fn unit(&self) -> &'static str {
        match self {
            Self::Key { unit, .. } => unit,
            Self::Parameter { .. } => "",
        }
    }
}

impl WrittenPolicy {
    /// The policy with these values (SI) for what is varied, as a line of a file.
    pub fn line(&self, values: &[f64]) -> String {
        let mut keys = self.keys.clone();
        for (varied, value) in self.varied.iter().zip(values) {
            match varied {
                VariedKey::Key { key, unit } => {
                    let text = format!("{} {unit}", short(*value)).trim_end().to_string();
                    match keys.iter_mut().find(|(name, _)| name == key) {
                        Some((_, written)) => *written = text,
                        None => keys.push((key, text)),
                    }
                }
                VariedKey::Parameter { name } => {
                    if let Some((_, written)) = keys.iter_mut().find(|(key, _)| *key == PARAMETERS) {
                        *written = with_parameter(written, name, *value);
                    }
                }
            }
        }
        let keys: Vec<String> = keys.iter().map(|(key, value)| format!("{key}: {value}")).collect();
        format!("driver {}_hardened = {}({})", self.name, self.kind, keys.join(", "))
    }
}

/// A list of parameters as a file writes it, with another value of one.
fn with_parameter(list: &str, name: &str, value: f64) -> String {
    let start = format!("\"{name}=");
    let Some((before, (_, after))) =
        list.split_once(&start).and_then(|(before, rest)| Some((before, rest.split_once('"')?)))
    else {
        return list.into();
    };
    format!("{before}{start}{}\"{after}", short(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hardened_policy_is_a_line_of_a_file() {
        let written = WrittenPolicy {
            name: "mine".into(),
            kind: "external",
            keys: vec![
                ("command", "\"python my_av.py\"".into()),
                ("parameters", "[\"gap=1\", \"width=2\"]".into()),
                ("sensors", "poor".into()),
            ],
            varied: vec![
                VariedKey::Parameter { name: "gap".into() },
                VariedKey::Key { key: "actuation_delay", unit: "s" },
            ],
        };
        assert_eq!(
            written.line(&[2.5, 0.1]),
            "driver mine_hardened = external(command: \"python my_av.py\", parameters: [\"gap=2.5\", \"width=2\"], \
             sensors: poor, actuation_delay: 0.1 s)"
        );
    }
}
