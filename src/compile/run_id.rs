use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use super::Campaign;

/// The short name of a run or of a search: 32 bits of BLAKE3 over its names, in tables eight hexadecimal digits.
///
/// It is the same in every report of the same campaign, whatever else the campaign holds. Episode 17 of run `1a2b3c4d` is called
/// `1a2b3c4d:17`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct RunId(u32);

impl RunId {
    /// Names something; `again` counts up where others have had the same name by chance.
    fn new(names: &str, again: u32) -> Self {
        let counted = &again.to_le_bytes()[..usize::from(again > 0) * 4];
        let [a, b, c, d, ..] = *blake3::hash(&[names.as_bytes(), counted].concat()).as_bytes();
        Self(u32::from_be_bytes([a, b, c, d]))
    }
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08x}", self.0)
    }
}

impl FromStr for RunId {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let right = text.len() == 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        if right { u32::from_str_radix(text, 16).map(Self).map_err(|_| ()) } else { Err(()) }
    }
}

/// Names that are given out, each to one owner.
#[derive(Default)]
struct Register {
    owners: BTreeMap<RunId, String>,
}

impl Register {
    fn name(&mut self, names: &[&str]) -> RunId {
        let names = joined(names);
        let free = |id: &RunId| self.owners.get(id).is_none_or(|owner| *owner == names);
        let id = (0..).map(|again| RunId::new(&names, again)).find(free).expect("there are billions of names");
        self.owners.insert(id, names);
        id
    }
}

/// Names in one text, each with its end.
fn joined(names: &[&str]) -> String {
    let mut text = String::with_capacity(names.iter().map(|name| name.len() + 1).sum());
    for name in names {
        text.push_str(name);
        text.push('\0');
    }
    text
}

impl Campaign {
    /// Names the evaluations and the searches.
    pub(super) fn name_runs(&mut self) {
        let mut register = Register::default();
        for evaluation in &mut self.evaluations {
            let key = &evaluation.trained;
            let (block, run) = (evaluation.block.to_string(), key.run.to_string());
            let pedestrian = evaluation.pedestrian.name();
            let trained = [&key.reward, &key.town, &key.policy, &run].map(String::as_str);
            let tried = [&evaluation.town, &evaluation.policy, &evaluation.vehicle, &evaluation.adversary];
            let names = [&[self.name.as_str(), &block, pedestrian], &trained[..], &tried.map(String::as_str)].concat();
            evaluation.id = register.name(&names);
        }
        for search in &mut self.searches {
            let key = &search.key;
            let (block, run) = (key.block.to_string(), key.run.to_string());
            search.key.id =
                register.name(&[&self.name, "search", &block, &key.falsifier, &key.town, &key.policy, &run]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_that_of_blake3_and_returns_from_its_text() {
        let id = RunId::new(&joined(&["a", "b"]), 0);
        assert_eq!(id.to_string().parse(), Ok(id));
        assert_ne!(id, RunId::new(&joined(&["ab", ""]), 0));
        for text in ["", "1234567", "123456789", "1234567g", "+1234567", "é23456"] {
            assert_eq!(text.parse::<RunId>(), Err(()), "{text}");
        }
    }

    #[test]
    fn two_owners_never_share_a_name() {
        let mut register = Register::default();
        let first = register.name(&["a"]);
        register.owners.insert(first, "somebody else".into());
        let second = register.name(&["a"]);
        assert!(first != second && second == RunId::new(&joined(&["a"]), 1) && second == register.name(&["a"]));
    }
}
