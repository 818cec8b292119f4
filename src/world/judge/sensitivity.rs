use crate::av::reference_drivers::Gate;

/// Whether a collision would count as a fault with other figures of the careful humans: how much a number of faults depends on choices that no
/// regulation makes for pedestrians.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Sensitivity {
    /// If both reacted a quarter of a second sooner.
    pub sooner: bool,
    /// If both reacted a quarter of a second later.
    pub later: bool,
    /// If the gate opened at 2 s at any speed.
    pub short_gate: bool,
    /// If the gate opened half a second earlier.
    pub long_gate: bool,
}

/// The change of the reaction (s) and of the gate (s).
const REACTION: f64 = 0.25;
const GATE: f64 = 0.5;

impl Sensitivity {
    /// The names of the four, in tables and in their order.
    pub const NAMES: [&'static str; 4] = ["sooner", "later", "short_gate", "long_gate"];

    /// Asks whether it is a fault with a change of the reaction (s) and a gate.
    pub(super) fn of(mut is_fault: impl FnMut(f64, Gate) -> bool) -> Self {
        let gate = Gate::CAREFUL;
        Self {
            sooner: is_fault(-REACTION, gate),
            later: is_fault(REACTION, gate),
            short_gate: is_fault(0.0, Gate { in_time: false, ..gate }),
            long_gate: is_fault(0.0, Gate { longer: GATE, ..gate }),
        }
    }

    /// The four, in the order of [`Sensitivity::NAMES`].
    pub const fn values(&self) -> [bool; 4] {
        [self.sooner, self.later, self.short_gate, self.long_gate]
    }
}
