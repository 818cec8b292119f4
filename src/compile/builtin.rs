use super::{
    Catalog, adversary, campaign, controller, episode, falsifier, outside, policy, published, reward, sensors, spawn,
    town, training, vehicle,
};

impl Catalog {
    /// The catalogue of this program; scenarios may not start programs.
    pub fn builtin() -> Self {
        let (policies, falsifiers) = (policy::kinds(), falsifier::kinds());
        let forms = vec![
            town::form(),
            policy::form(&policies, &outside::kinds()),
            sensors::form(),
            vehicle::form(),
            adversary::form(),
            spawn::form(),
            reward::form(),
            episode::form(),
            training::form(),
            controller::form(),
            falsifier::form(&falsifiers),
            published::form(),
            campaign::form(),
        ];
        let vocabulary = world::env::vocabulary();
        Self { forms, vocabulary, policies, opener: None, network_trial: None, falsifiers }
    }
}
