use super::PedestrianEnv;

/// Copies of an environment: as it is, and for a batch.
impl PedestrianEnv {
    /// A copy in its present state, if all drivers can be copied.
    pub fn snapshot(&self) -> Option<Self> {
        let policies = self.policies.iter().map(|policy| policy.snapshot()).collect::<Option<_>>()?;
        Some(Self {
            policies,
            scenario: self.scenario.clone(),
            world: self.world.clone(),
            sensors: self.sensors.clone(),
            starts: self.starts.clone(),
            run_up: self.run_up.clone(),
            path: self.path.clone(),
            controls: self.controls.clone(),
            walks: self.walks.clone(),
            bounds: self.bounds.clone(),
            decisions: self.decisions.clone(),
            near: self.near.clone(),
            bank: self.bank.clone(),
            trace: self.trace.clone(),
            signals: self.signals.clone(),
            monitor: self.monitor.clone(),
            paid: self.paid.clone(),
            robustness: self.robustness.clone(),
            moments: self.moments.clone(),
            motions: self.motions.clone(),
            ..*self
        })
    }

    /// Another environment of the same scenario and seed, if the ego's driver is faster in a batch.
    pub fn clone_for_batch(&self) -> Option<Self> {
        let ego = self.policies[0].clone_for_batch()?;
        let traffic = self.policies.iter().zip(self.scenario.cast.vehicles()).skip(1);
        let traffic = traffic.map(|(policy, role)| policy.clone_for_batch().unwrap_or_else(|| (role.policy)()));
        let policies = std::iter::once(ego).chain(traffic).collect();
        Some(Self::with_policies(self.scenario.clone(), self.seed, policies))
    }

    /// The number of environments in a batch.
    pub fn batch_size(&self) -> usize {
        self.policies[0].batch_size()
    }
}
