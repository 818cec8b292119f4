use base::keys;
use base::signature::{DeclarationId, Form, Keys, Signature};

keys! {
    /// What is run: which pedestrians are trained, where they are evaluated, and which searches are compared.
    pub struct CampaignKeys = "campaign" {
        /// The model of car under test.
        vehicle: DeclarationId as Reference("vehicle"),
        /// The pedestrian's body.
        body: DeclarationId as Reference("body"),
        /// Further pedestrians and cars, and the first pedestrian with a name; without the key there is the car under test and one pedestrian. A block
        /// `cast { child: pedestrian(…)  van: vehicle(…) }` declares them in place.
        cast: Option<Vec<DeclarationId>> as Reference("role"),
        /// Where episodes begin.
        spawn: DeclarationId as Reference("spawn"),
        /// How long they last.
        episode: DeclarationId as Reference("episode"),
        /// What is required of episodes beside no collision: each has a rate, and its violations are failures. Without the key a collision is the only
        /// failure.
        requirements: Option<Vec<DeclarationId>> as Reference("requirement"),
        /// How pedestrians are trained, where any are.
        training: Option<DeclarationId> as Reference("training"),
        /// Natural encounters of each driver in each town, which show its price: progress and needless braking; 0 for none. Without the key 200, or a tenth of the
        /// episodes there of the driver with most of them if that is less.
        price: Option<u32> as whole(0, 1_000_000),
        /// Published figures to stand beside those of this campaign.
        beside: Option<Vec<DeclarationId>> as Reference("published"),
    }
}

keys! {
    /// Where the episodes of a block happen, and against which drivers.
    pub struct PlaceKeys {
        /// Towns.
        towns: Vec<DeclarationId> as Reference("town"),
        /// Drivers.
        drivers: Vec<DeclarationId> as Reference("driver"),
    }
}

keys! {
    /// How the episodes of a block begin.
    pub struct StartKeys {
        /// Where these episodes begin, instead of the campaign's `spawn`.
        spawn: Option<DeclarationId> as Reference("spawn"),
    }
}

keys! {
    /// Runs the campaign once for every combination of values: `name: [value, …]`, each the name of a `param`.
    struct MatrixKeys = "matrix" {}
}

/// The form `campaign`, with the blocks of jobs that it may hold.
pub fn form(jobs: impl Iterator<Item = Signature>) -> Form {
    let blocks = std::iter::once(MatrixKeys::signature()).chain(jobs).collect();
    Form { multiplies: true, ..Form::plain(CampaignKeys::signature().holding(blocks)) }
}
