use super::falsifier::FalsifierKind;
use base::signature::Keys;
use episode::walker::{
    Controller, Homing, HomingKeys, Intercept, InterceptKeys, Natural, Random, RandomKeys, Scripted, ScriptedKeys,
    WalkPolicy,
};
use search::Controlled;

/// The words of trained pedestrians.
pub(crate) const TRAINED: &str = "trained";
pub(crate) const STOCHASTIC: &str = "stochastic";
/// The word of the networks with which trainings begin.
pub const UNTRAINED: &str = "untrained";

/// A kind of pedestrian that walks without having learnt. `pedestrians` of an `evaluate` block name it by its word, and it is a kind of
/// falsifier, which runs one episode from every start.
#[derive(Clone)]
pub struct WalkerKind {
    /// Makes one with its defaults for an evaluation.
    pub(super) controller: Controller,
    /// The same as a falsifier.
    pub(super) falsifier: FalsifierKind,
    /// Whether it draws, so that every run of an evaluation is another.
    pub(super) draws: bool,
    /// Whether it walks as the spawn rule states, which must state a walk.
    pub(super) is_scripted: bool,
}

impl WalkerKind {
    /// A kind with these keys as a falsifier; an evaluation takes its default. Evaluations are the same in all runs.
    pub fn new<K, W>(make: impl Fn(K) -> W + Send + Sync + 'static) -> Self
    where
        K: Keys,
        W: WalkPolicy + Clone + Default + Sync + 'static,
    {
        Self {
            controller: Controller::new(K::KIND, || Box::new(W::default())),
            falsifier: FalsifierKind::new(move |keys| {
                let walker = make(keys);
                Controlled(Controller::new(K::KIND, move || Box::new(walker.clone())))
            }),
            draws: false,
            is_scripted: false,
        }
    }

    /// The same for a pedestrian that draws: evaluations differ from run to run.
    pub fn drawing(self) -> Self {
        Self { draws: true, ..self }
    }

    pub(super) fn word(&self) -> &'static str {
        self.falsifier.signature.name
    }
}

/// All kinds of pedestrians that walk without having learnt; a new one is a line here.
pub fn kinds() -> Vec<WalkerKind> {
    vec![
        WalkerKind::new(|_: RandomKeys| Random::default()).drawing(),
        WalkerKind::new(|_: HomingKeys| Homing),
        WalkerKind::new(|_: InterceptKeys| Intercept),
        WalkerKind::new(Natural::from_keys).drawing(),
        WalkerKind { is_scripted: true, ..WalkerKind::new(|_: ScriptedKeys| Scripted) },
    ]
}
