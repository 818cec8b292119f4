#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    falsify::internal::fuzzing::settings(bytes);
});
