//! Trainings that stop and go on.

use base::seed::{Seed, Stream};
use learn::{ActorCritic, Agent, CheckpointError, Env, PpoConfig, Schedule, Step, Trained, Trainer, UpdateLog};
use rand::Rng;
use std::collections::BTreeMap;

fn bytes(trainer: &Trainer, envs: &[Walk]) -> Vec<u8> {
    trainer.state(envs, &BTreeMap::new())
}

/// A walk that ends at random; its whole state is a stream, a place and whether it can be saved.
struct Walk {
    stream: Stream,
    place: [f64; 2],
    saves: bool,
}

impl Walk {
    fn new(number: u64) -> Self {
        Self { stream: Seed::root(50).index(number).stream(), place: [0.0; 2], saves: true }
    }

    fn uniform(&mut self) -> f64 {
        self.stream.next_u64() as f64 / u64::MAX as f64
    }
}

impl Env for Walk {
    fn obs_dim(&self) -> usize {
        2
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        vec![(-1.0, 1.0), (-0.5, 2.0)]
    }

    fn reset(&mut self, obs: &mut [f64]) {
        self.place = [self.uniform(), self.uniform()];
        obs.copy_from_slice(&self.place);
    }

    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
        let luck = self.uniform();
        for (place, action) in self.place.iter_mut().zip(action) {
            *place = 0.9 * *place + action * luck;
        }
        obs.copy_from_slice(&self.place);
        let luck = self.uniform();
        Step { reward: -self.place[0].abs() + self.place[1], terminated: luck < 0.05, truncated: luck > 0.9 }
    }

    fn potential(&self) -> f64 {
        self.place[0]
    }

    fn save(&self) -> Option<Vec<u8>> {
        let at = self.stream.word() as u64;
        let numbers = [at, self.place[0].to_bits(), self.place[1].to_bits()];
        let bytes = numbers.into_iter().flat_map(u64::to_le_bytes);
        self.saves.then(|| bytes.chain(self.stream.seed()).collect())
    }

    fn load(&mut self, state: &[u8]) -> bool {
        let (numbers, seed) = state.split_at(24);
        let (numbers, _) = numbers.as_chunks::<8>();
        self.stream = Stream::at(seed.try_into().unwrap(), u128::from(u64::from_le_bytes(numbers[0])));
        self.place = [1, 2].map(|i| f64::from_bits(u64::from_le_bytes(numbers[i])));
        true
    }
}

fn configs() -> [PpoConfig; 2] {
    let paper = PpoConfig { steps_per_update: 50, steps: 900, epochs: 3, hidden: vec![16], ..PpoConfig::paper() };
    let all = PpoConfig {
        learning_rate_schedule: Schedule::Linear,
        target_kl: Some(0.02),
        normalize_observations: true,
        normalize_rewards: true,
        frame_stack: 3,
        portable_bits: true,
        ..paper.clone()
    };
    [paper, all]
}

fn walks() -> [Walk; 3] {
    [0, 1, 2].map(Walk::new)
}

#[test]
fn a_training_continues_as_if_it_had_not_been_interrupted() {
    for config in configs() {
        let mut envs = walks();
        let mut whole = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
        let logs: Vec<UpdateLog> = (0..6).map(|_| whole.update(&mut envs).unwrap().clone()).collect();
        assert!(whole.is_done());
        let end = bytes(&whole, &envs);
        for interruption in [0, 1, 4] {
            let mut envs = walks();
            let mut trainer = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
            for _ in 0..interruption {
                trainer.update(&mut envs).unwrap();
            }
            let state = bytes(&trainer, &envs);
            assert_eq!(state, bytes(&trainer, &envs));
            let mut others = [7, 8, 9].map(Walk::new);
            let mut resumed = Trainer::from_state(&state, &mut others, &config).unwrap();
            assert_eq!(bytes(&resumed, &others), state);
            for log in &logs[interruption..] {
                assert_eq!(resumed.update(&mut others).unwrap(), log);
            }
            assert_eq!((resumed.updates(), resumed.steps()), (6, 900));
            assert_eq!(resumed.learning_curve(), logs);
            assert_eq!(bytes(&resumed, &others), end);
        }
    }
}

/// Two walks side by side, each of an agent with a policy of its own; episodes are those of the first. The second sees and moves one of its numbers.
struct Pair([Walk; 2], f64);

impl Env for Pair {
    fn agents(&self) -> Vec<Agent> {
        let agent = |policy, obs_dim| Agent {
            policy,
            obs_dim,
            action_bounds: vec![(-1.0, 1.0), (-0.5, 2.0)][..obs_dim].into(),
        };
        vec![agent(0, 2), agent(1, 1)]
    }

    fn obs_dim(&self) -> usize {
        3
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.agents().into_iter().flat_map(|agent| agent.action_bounds).collect()
    }

    fn reset(&mut self, obs: &mut [f64]) {
        self.0[0].reset(&mut obs[..2]);
        let mut both = [0.0; 2];
        self.0[1].reset(&mut both);
        obs[2] = both[0];
    }

    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
        let mut both = [0.0; 2];
        self.1 = self.0[1].step(&[action[2], 0.0], &mut both).reward;
        obs[2] = both[0];
        self.0[0].step(&action[..2], &mut obs[..2])
    }

    fn credit(&self, agent: usize, reward: f64) -> f64 {
        if agent == 0 { reward } else { self.1 }
    }

    fn potential(&self) -> f64 {
        self.0[0].potential()
    }

    fn save(&self) -> Option<Vec<u8>> {
        Some([self.0[0].save()?, self.0[1].save()?].concat())
    }

    fn load(&mut self, state: &[u8]) -> bool {
        let (first, second) = state.split_at(state.len() / 2);
        self.0[0].load(first) && self.0[1].load(second)
    }
}

#[test]
fn each_policy_learns_from_its_own_agents_as_if_it_were_alone() {
    let pair = |number| [Pair([Walk::new(number), Walk::new(number + 5)], 0.0)];
    for config in configs() {
        let mut alone = [Walk::new(0)];
        let mut one = Trainer::new(&mut alone, &config, &Seed::root(1)).unwrap();
        let mut envs = pair(0);
        let mut both = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
        let begun = both.policies().to_vec();
        for update in 0..4 {
            one.update(&mut alone).unwrap();
            both.update(&mut envs).unwrap();
            assert_eq!(both.policies()[0], one.policies()[0], "update {update}");
        }
        let [_, second] = both.policies() else { panic!("there are two policies") };
        let frames = config.frame_stack;
        assert_eq!((second.obs_dim(), second.action_dim()), (frames, 1));
        assert!(second.parameters() != begun[1].parameters(), "the second learns, too");
        assert_eq!(both.steps(), one.steps());
        // It goes on after an interruption, and its curve and its policies can be read.
        let state = both.state(&envs, &BTreeMap::new());
        let mut others = pair(7);
        let mut resumed = Trainer::from_state(&state, &mut others, &config).unwrap();
        assert_eq!(both.update(&mut envs).unwrap(), resumed.update(&mut others).unwrap());
        let state = both.state(&envs, &BTreeMap::new());
        assert_eq!(resumed.state(&others, &BTreeMap::new()), state);
        let read = Trained::from_safetensors(&state).unwrap();
        assert_eq!(
            (read.policies.as_slice(), read.learning_curve.as_slice()),
            (both.policies(), both.learning_curve())
        );
        let trained = both.finish();
        assert_eq!(Trained::from_safetensors(&trained.to_safetensors()).unwrap(), trained);
        let lone = Trainer::from_state(&one.state(&alone, &BTreeMap::new()), &mut pair(0), &config);
        assert!(matches!(lone, Err(CheckpointError::Policies { found: 1, expected: 2 })));
    }
}

#[test]
fn an_environment_that_cannot_be_saved_begins_anew() {
    for config in configs() {
        let mut envs = walks();
        envs[1].saves = false;
        let mut trainer = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
        trainer.update(&mut envs).unwrap();
        let state = bytes(&trainer, &envs);
        let mut others = walks();
        let mut resumed = Trainer::from_state(&state, &mut others, &config).unwrap();
        assert_eq!(others[0].place, envs[0].place);
        assert_eq!(others[1].place, {
            let mut place = [0.0; 2];
            Walk::new(1).reset(&mut place);
            place
        });
        resumed.update(&mut others).unwrap();
    }
}

#[test]
fn the_policy_can_be_read_from_a_state() {
    for config in configs() {
        let mut envs = walks();
        let mut trainer = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
        trainer.update(&mut envs).unwrap();
        let (policy, _) = ActorCritic::from_safetensors(&bytes(&trainer, &envs)).unwrap();
        assert_eq!(policy, trainer.policies()[0]);
    }
}

#[test]
fn states_that_do_not_fit_are_errors_and_never_panics() {
    let [config, _] = configs();
    let mut envs = walks();
    let trainer = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
    let state = bytes(&trainer, &envs);
    for (name, other) in [
        ("epochs", &PpoConfig { epochs: 7, ..config.clone() }),
        ("hidden", &PpoConfig { hidden: vec![16, 16], ..config.clone() }),
        ("frame_stack", &PpoConfig { frame_stack: 2, ..config.clone() }),
        ("gamma", &PpoConfig { gamma: 0.9, ..config.clone() }),
    ] {
        let read = Trainer::from_state(&state, &mut walks(), other);
        assert!(matches!(read, Err(CheckpointError::Settings { name: found }) if found == name), "{name}");
    }
    // A training can be prolonged, and threads change nothing.
    let longer = PpoConfig { steps: 2_000, threads: Some(2), ..config.clone() };
    assert!(Trainer::from_state(&state, &mut walks(), &longer).is_ok());
    let read = Trainer::from_state(&state, &mut walks()[..2], &config);
    assert!(matches!(read, Err(CheckpointError::Env { env: 2 })));
    let mut four = [0, 1, 2, 3].map(Walk::new);
    let read = Trainer::from_state(&state, &mut four, &config);
    assert!(matches!(read, Err(CheckpointError::Missing { name }) if name == "env.3.noise"));
    for end in (0..state.len()).step_by(17) {
        assert!(Trainer::from_state(&state[..end], &mut walks(), &config).is_err());
    }
}

#[test]
fn any_part_of_a_damaged_state_may_be_refused_but_never_panics() {
    let [config, _] = configs();
    let mut envs = walks();
    let mut trainer = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
    trainer.update(&mut envs).unwrap();
    let state = bytes(&trainer, &envs);
    for at in (0..state.len()).step_by(13) {
        let mut broken = state.clone();
        broken[at] ^= 0x90;
        let _ = Trainer::from_state(&broken, &mut walks(), &config);
    }
}

#[test]
fn the_header_tells_how_far_a_training_has_come() {
    let [config, _] = configs();
    let mut envs = walks();
    let mut trainer = Trainer::new(&mut envs, &config, &Seed::root(1)).unwrap();
    trainer.update(&mut envs).unwrap();
    let named = BTreeMap::from([("town".to_owned(), "harbour".to_owned())]);
    let (_, header) = ActorCritic::from_safetensors(&trainer.state(&envs, &named)).unwrap();
    assert_eq!((header["update"].as_str(), header["steps"].as_str()), ("1", "150"));
    assert_eq!(header["town"], "harbour");
    assert!(header["settings"].contains("\"gamma\":0.98"), "{}", header["settings"]);
}
