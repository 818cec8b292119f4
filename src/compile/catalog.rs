use std::sync::Arc;

use super::falsifier::FalsifierKind;
use super::policy_kind::{PolicyKind, with_common_keys};
use base::signature::{Form, Vocabulary};
use world::av::external::Opener;

/// Tries a network where it can do no harm, before it is loaded into this process; the error is the reason, as a part of a sentence.
pub type NetworkTrial = dyn Fn(&[u8]) -> Result<(), String> + Send + Sync;

/// A kind whose name another kind of the same form has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is a {form} of kind `{kind}` already")]
pub struct TakenKind {
    pub form: &'static str,
    pub kind: &'static str,
}

/// Everything the language offers: forms, their kinds, and the names that formulas may use.
pub struct Catalog {
    /// The forms, in the order of the reference.
    pub forms: Vec<Form>,
    /// Variables and events.
    pub vocabulary: Vocabulary,
    pub(super) policies: Vec<PolicyKind>,
    pub(super) opener: Option<Arc<dyn Opener>>,
    pub(super) network_trial: Option<Arc<NetworkTrial>>,
    pub(super) falsifiers: Vec<FalsifierKind>,
}

impl Catalog {
    /// The same; scenarios may start programs through this opener.
    pub fn with_opener(self, opener: Arc<dyn Opener>) -> Self {
        Self { opener: Some(opener), ..self }
    }

    /// The same; networks in ONNX files are tried in this way first. Without a trial a network may take any memory and time.
    pub fn with_network_trial(self, trial: Arc<NetworkTrial>) -> Self {
        Self { network_trial: Some(trial), ..self }
    }

    /// Whether scenarios may start programs.
    pub fn starts_programs(&self) -> bool {
        self.opener.is_some()
    }

    /// The same with one more kind of driving policy, which scenarios name like the built-in ones.
    ///
    /// # Errors
    /// A kind of this name exists.
    pub fn with_policy(mut self, kind: PolicyKind) -> Result<Self, TakenKind> {
        let form = self.forms.iter_mut().find(|form| form.name == "policy").expect("the form is built in");
        let name = kind.signature.name;
        if form.kinds.iter().any(|known| known.name == name) {
            return Err(TakenKind { form: "policy", kind: name });
        }
        form.kinds.push(with_common_keys(kind.signature.clone()));
        self.policies.push(kind);
        Ok(self)
    }
}
