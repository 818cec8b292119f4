//! Networks, and how they are stored.

use base::seed::Seed;
use learn::{ActorCritic, CheckpointError, RunningMoments};
use safetensors::SafeTensors;
use std::collections::BTreeMap;

fn policy() -> ActorCritic {
    ActorCritic::new(4, 2, &[6, 5], -0.25, &mut Seed::root(8).stream())
}

fn metadata() -> BTreeMap<String, String> {
    [("scenario", "a \"quoted\" name\n"), ("a", "1"), ("b", "2")].map(|(k, v)| (k.to_owned(), v.to_owned())).into()
}

#[test]
fn a_round_trip_preserves_every_bit() {
    let bytes = policy().to_safetensors(&metadata());
    assert_eq!(bytes, policy().to_safetensors(&metadata()));
    let (read, read_metadata) = ActorCritic::from_safetensors(&bytes).unwrap();
    assert_eq!(read, policy());
    assert_eq!(read_metadata, metadata());
    assert_eq!(read.to_safetensors(&read_metadata), bytes);
}

#[test]
fn the_moments_of_observations_are_part_of_a_policy() {
    let mut normalising = policy();
    let mut moments = RunningMoments::new(4);
    moments.update([[0.1, 20.0, -3.0, 0.5], [0.2, 25.0, -3.5, 0.25]].iter().map(|sample| &sample[..]));
    *normalising.observation_moments_mut() = Some(moments.clone());
    let bytes = normalising.to_safetensors(&BTreeMap::new());
    let (read, _) = ActorCritic::from_safetensors(&bytes).unwrap();
    assert_eq!(read.observation_moments(), Some(&moments));
    assert_eq!(read, normalising);
    let (mut a, mut b, mut plain) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let obs = [0.15, 22.0, -3.1, 0.3];
    normalising.act(&obs, &mut a, &mut normalising.scratch(1));
    read.act(&obs, &mut b, &mut read.scratch(1));
    policy().act(&obs, &mut plain, &mut read.scratch(1));
    assert_eq!(a, b);
    assert_ne!(a, plain);
}

#[test]
fn names_and_layout_are_those_of_the_state_dictionary() {
    let policy = policy();
    let bytes = policy.to_safetensors(&BTreeMap::new());
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    let mut names: Vec<String> = tensors.names().into_iter().map(str::to_owned).collect();
    names.sort();
    let mut expected = vec!["log_std".to_owned()];
    for layer in
        ["policy_net.0", "policy_net.2", "value_net.0", "value_net.2"].map(|name| format!("mlp_extractor.{name}"))
    {
        expected.extend([format!("{layer}.bias"), format!("{layer}.weight")]);
    }
    for head in ["action_net", "value_net"] {
        expected.extend([format!("{head}.bias"), format!("{head}.weight")]);
    }
    expected.sort();
    assert_eq!(names, expected);

    // Row-major: the second number is the weight of the second input, six further on in a column-major matrix.
    let first = tensors.tensor("mlp_extractor.policy_net.0.weight").unwrap();
    assert_eq!(first.shape(), [6, 4]);
    assert_eq!(first.data()[4..8], policy.parameters()[6].to_le_bytes());
    assert_eq!(tensors.tensor("action_net.weight").unwrap().shape(), [2, 5]);
    assert_eq!(tensors.tensor("value_net.bias").unwrap().shape(), [1]);
}

#[test]
fn corrupt_bytes_are_errors_and_never_panics() {
    let bytes = policy().to_safetensors(&metadata());
    for end in 0..bytes.len() {
        assert!(ActorCritic::from_safetensors(&bytes[..end]).is_err(), "the first {end} bytes pass");
    }
    let header = 8 + u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize;
    for at in 0..header {
        for flip in [0x01, 0x10, 0x80] {
            let mut broken = bytes.clone();
            broken[at] ^= flip;
            // Flipped bits in the metadata and in unused names may pass; none may panic.
            let _ = ActorCritic::from_safetensors(&broken);
        }
    }
}

fn with_replaced(from: &str, to: &str) -> Result<(ActorCritic, BTreeMap<String, String>), CheckpointError> {
    assert_eq!(from.len(), to.len());
    let mut bytes = policy().to_safetensors(&metadata());
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).expect("the text occurs");
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    ActorCritic::from_safetensors(&bytes)
}

#[test]
fn each_kind_of_damage_has_its_error() {
    let missing = with_replaced("policy_net.0.bias", "policy_net.0.bios");
    assert!(matches!(missing, Err(CheckpointError::Missing { name }) if name.ends_with("policy_net.0.bias")));
    // Read as 4 outputs of 6 inputs, which the bias contradicts.
    let transposed = with_replaced("[6,4]", "[4,6]");
    assert!(matches!(transposed, Err(CheckpointError::Shape { found, .. }) if found == [6]));
    let other_type = with_replaced("\"F32\"", "\"I32\"");
    assert!(
        matches!(other_type, Err(CheckpointError::Type { name, found, .. }) if name == "log_std" && found == "I32")
    );
    assert!(matches!(with_replaced("\"log_std\"", "'log_std'"), Err(CheckpointError::Format(_))));

    let mut infinite = policy();
    infinite.parameters_mut()[0] = f32::INFINITY;
    let read = ActorCritic::from_safetensors(&infinite.to_safetensors(&BTreeMap::new()));
    assert!(matches!(read, Err(CheckpointError::NonFinite { .. })));
}

#[test]
fn the_paper_size_has_9155_weights_and_two_deviations() {
    let policy = ActorCritic::<f32>::new(4, 2, &[64, 64], -0.5, &mut Seed::root(0).stream());
    // 4·64 + 64 + 64·64 + 64 twice, heads 2·64 + 2 and 64 + 1, two standard deviations.
    assert_eq!(policy.parameters().len(), 2 * (320 + 4160) + 130 + 65 + 2);
    assert_eq!(policy.log_std(), [-0.5, -0.5]);
}

#[test]
fn first_actions_are_small_and_depend_on_the_observation() {
    let policy = ActorCritic::<f32>::new(4, 2, &[64, 64], 0.0, &mut Seed::root(0).stream());
    let mut scratch = policy.scratch(1);
    let (mut a, mut b) = ([0.0; 2], [0.0; 2]);
    policy.act(&[0.1, -0.2, 0.3, 0.4], &mut a, &mut scratch);
    policy.act(&[0.1, -0.2, -0.3, 0.4], &mut b, &mut scratch);
    assert!(a.iter().chain(&b).all(|x| x.abs() < 0.1));
    assert_ne!(a, b);
    assert_ne!(policy.value(&[0.1; 4], &mut scratch), policy.value(&[0.2; 4], &mut scratch));
}
