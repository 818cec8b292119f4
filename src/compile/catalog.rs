use std::sync::Arc;

use super::falsifier::FalsifierKind;
use super::policy_kind::{PolicyKind, with_common_keys};
use super::town::{TownKind, with_objects};
use super::walker::{STOCHASTIC, TRAINED, UNTRAINED, WalkerKind};
use base::signature::{Form, Signature, Type, Vocabulary};
use episode::MapWriter;
use lang::hir::Declaration;
use world::av::external::Opener;

/// Tries a network where it can do no harm, before it is loaded into this process. Returns the time of a decision (s) if that is long; the error is the reason,
/// as a part of a sentence.
pub type NetworkTrial = dyn Fn(&[u8]) -> Result<Option<f64>, String> + Send + Sync;

/// A kind whose name another kind of the same form has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is a {form} of kind `{kind}` already")]
pub struct TakenKind {
    pub form: &'static str,
    pub kind: &'static str,
}

/// Everything the language offers: forms, their kinds, and the names that formulas may use.
#[derive(Clone)]
pub struct Catalog {
    /// The forms, in the order of the reference.
    pub forms: Vec<Form>,
    /// Variables and events.
    pub vocabulary: Vocabulary,
    pub(super) policies: Vec<PolicyKind>,
    pub(super) towns: Vec<TownKind>,
    pub(super) walkers: Vec<WalkerKind>,
    pub(super) falsifiers: Vec<FalsifierKind>,
    pub(super) opener: Option<Arc<dyn Opener>>,
    /// Whether a program is a warning, since none is started.
    pub(super) looks_up: bool,
    pub(super) network_trial: Option<Arc<NetworkTrial>>,
    pub(super) map_writer: Option<Arc<MapWriter>>,
}

impl Catalog {
    /// The same; scenarios may start programs through this opener.
    pub fn with_opener(self, opener: Arc<dyn Opener>) -> Self {
        Self { opener: Some(opener), ..self }
    }

    /// The same; programs are looked up through this opener, and a warning says that none is started.
    pub fn looking_up(self, opener: Arc<dyn Opener>) -> Self {
        Self { looks_up: true, ..self.with_opener(opener) }
    }

    /// The same; networks in ONNX files are tried in this way first. Without a trial a network may take any memory and time.
    pub fn with_network_trial(self, trial: Arc<NetworkTrial>) -> Self {
        Self { network_trial: Some(trial), ..self }
    }

    /// The same; maps of towns for other worlds are written in this way. Without it no world but ours can be used.
    pub fn with_map_writer(self, writer: Arc<MapWriter>) -> Self {
        Self { map_writer: Some(writer), ..self }
    }

    /// How scenarios start programs; `None` if they may not.
    pub fn opener(&self) -> Option<&Arc<dyn Opener>> {
        self.opener.as_ref()
    }

    /// Whether scenarios may start programs.
    pub fn starts_programs(&self) -> bool {
        self.opener.is_some()
    }

    /// The same with one more kind of driver, which scenarios name like the built-in ones.
    ///
    /// # Errors
    /// A kind of this name exists.
    pub fn with_policy(mut self, kind: PolicyKind) -> Result<Self, TakenKind> {
        self.add("driver", with_common_keys(kind.signature.clone()))?;
        self.policies.push(kind);
        Ok(self)
    }

    /// The same with one more kind of town. Obstacles may stand in it as in any town.
    ///
    /// # Errors
    /// A kind of this name exists.
    pub fn with_town(mut self, kind: TownKind) -> Result<Self, TakenKind> {
        self.add("town", with_objects(kind.signature.clone()))?;
        self.towns.push(kind);
        Ok(self)
    }

    /// The same with one more kind of pedestrian that walks: a word for the `pedestrians` of an evaluation or an estimate, and a kind of falsifier.
    ///
    /// # Errors
    /// A pedestrian or a falsifier of this name exists.
    pub fn with_walker(mut self, kind: WalkerKind) -> Result<Self, TakenKind> {
        if self.has_pedestrian(kind.word()) {
            return Err(TakenKind { form: "pedestrian", kind: kind.word() });
        }
        self = self.with_falsifier(kind.falsifier.clone())?;
        let blocks = self.forms.iter_mut().filter(|form| ["campaign", "role"].contains(&form.name)).flat_map(|form| {
            form.kinds.iter_mut().chain(form.plain.iter_mut().flat_map(|campaign| &mut campaign.children))
        });
        for param in blocks.flat_map(|block| &mut block.params) {
            let single = if let Type::List(item) = &mut param.ty { &mut **item } else { &mut param.ty };
            if let Type::WordOrReference(words, "pedestrian") = single {
                words.push(kind.word());
            }
        }
        self.walkers.push(kind);
        Ok(self)
    }

    /// The same with one more kind of falsifier.
    ///
    /// # Errors
    /// A kind of this name exists.
    pub fn with_falsifier(mut self, kind: FalsifierKind) -> Result<Self, TakenKind> {
        self.add("method", kind.signature.clone())?;
        self.falsifiers.push(kind);
        Ok(self)
    }

    /// Whether a built-in pedestrian has this name.
    pub(super) fn has_pedestrian(&self, name: &str) -> bool {
        [TRAINED, STOCHASTIC, UNTRAINED].contains(&name) || self.walkers.iter().any(|kind| kind.word() == name)
    }

    /// The signature of a driver's kind.
    pub(super) fn signature_of(&self, driver: &Declaration) -> Option<&Signature> {
        let drivers = self.forms.iter().filter(|form| form.name == driver.form);
        drivers.flat_map(|form| &form.kinds).find(|kind| kind.name == driver.kind)
    }

    fn add(&mut self, form: &'static str, signature: Signature) -> Result<(), TakenKind> {
        let found = self.forms.iter_mut().find(|known| known.name == form);
        let Form { kinds, plain, .. } = found.expect("the form is built in");
        if kinds.iter().chain(&*plain).any(|known| known.name == signature.name) {
            return Err(TakenKind { form, kind: signature.name });
        }
        kinds.push(signature);
        Ok(())
    }
}
