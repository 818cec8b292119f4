//! Links the program to a fixed place in memory.
//!
//! The library of tables brings some 400,000 relocations with it; carried out at every start they take longer than checking a
//! scenario. Nothing in the program is to be guarded by a random place: it reads text files of its own user.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|found| found == value);
    if is("CARGO_CFG_TARGET_OS", "linux") && is("CARGO_CFG_TARGET_ENV", "gnu") {
        println!("cargo:rustc-link-arg-bins=-no-pie");
    }
}
