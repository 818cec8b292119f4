use super::jobs::BLOCKS;
use super::{
    Catalog, adversary, campaign, controller, external_world, falsifier, policy, published, requirement, reward, role,
    sensors, spawn, town, training, vehicle, walker,
};
use base::signature::{Form, Keys};
use episode::EpisodeRule;

const DIFFER: &str = "the built-in kinds have different names";

impl Catalog {
    /// The catalogue of this program; scenarios may not start programs.
    pub fn builtin() -> Self {
        let forms = vec![
            town::form(),
            policy::form(),
            sensors::form(),
            vehicle::form(),
            adversary::form(),
            spawn::form(),
            reward::form(),
            requirement::form(),
            Form::plain(EpisodeRule::signature()),
            training::form(),
            controller::form(),
            falsifier::form(),
            role::form(),
            external_world::form(),
            published::form(),
            campaign::form(BLOCKS.iter().map(|block| (block.signature)())),
        ];
        let bare = Self {
            forms,
            vocabulary: episode::vocabulary(),
            policies: Vec::new(),
            towns: vec![town::drawn()],
            walkers: Vec::new(),
            falsifiers: Vec::new(),
            opener: None,
            looks_up: false,
            network_trial: None,
            map_writer: None,
        };
        let with_towns = town::kinds().into_iter().try_fold(bare, Self::with_town);
        let with_policies = policy::kinds().into_iter().try_fold(with_towns.expect(DIFFER), Self::with_policy);
        let with_walkers = walker::kinds().into_iter().try_fold(with_policies.expect(DIFFER), Self::with_walker);
        falsifier::kinds().into_iter().try_fold(with_walkers.expect(DIFFER), Self::with_falsifier).expect(DIFFER)
    }
}
