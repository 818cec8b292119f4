//! PufferDrive's network and map without its weights.

use base::seed::Seed;
use ported::pufferdrive::{Network, Observation};
use rand::RngExt;

/// The bytes of weights without training.
fn weights() -> Vec<u8> {
    let mut stream = Seed::root(1).stream();
    (0..614_172).flat_map(|_| (0.2 * stream.random::<f32>() - 0.1).to_le_bytes()).collect()
}

#[test]
fn files_that_are_no_weights_are_refused() {
    let with = |place: usize, number: f32| {
        let mut bytes = weights();
        bytes[4 * place..4 * place + 4].copy_from_slice(&number.to_le_bytes());
        Network::read(&bytes).err().unwrap_or_default()
    };
    assert_eq!(with(7, 0.5), "");
    assert_eq!(with(7, f32::NAN), "its number 7 is NaN and not between -1000 and 1000");
    assert_eq!(with(614_171, -1e9), "its number 614171 is -1000000000 and not between -1000 and 1000");
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:bdd7\nsize 2456688\n";
    let said = Network::read(pointer).unwrap_err();
    assert_eq!(said, "it has 72 bytes instead of 2456688: it is a pointer of Git LFS and not the file itself");
    assert_eq!(Network::read(&weights()[4..]).unwrap_err(), "it has 2456684 bytes instead of 2456688");
}

/// The bits are those of any processor.
#[test]
fn the_network_has_the_same_bits_everywhere() {
    let network = Network::read(&weights()).unwrap();
    let row = |place: usize| std::array::from_fn(|at| (place + 3 * at) as f32 % 5.0 / 5.0);
    let (others, road) = ((0..9).map(row).collect(), (0..128).map(|place| row(place + 1)).collect());
    let observation = Observation { ego: row(2), others, road };
    let mut state = [[0.0; 256]; 2];
    let mut bits = 0_u64;
    for _ in 0..20 {
        let logits = network.step(&observation, &mut state);
        bits = logits.iter().fold(bits, |bits, logit| bits.rotate_left(5) ^ u64::from(logit.to_bits()));
    }
    assert_eq!(format!("{bits:016x}"), "eb9f8d2ef65d3c02");
}
