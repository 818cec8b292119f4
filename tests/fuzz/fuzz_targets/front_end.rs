//! Any bytes through the whole front end and the layout.
#![no_main]

use std::path::Path;

use falsify::compile::{Catalog, compile};
use falsify::diagnostic::{Colour, Sources, render};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let root = Path::new("fuzz.scn");
    let none = || std::io::Error::from(std::io::ErrorKind::NotFound);
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { Err(none()) };
    let mut sources = Sources::default();
    let compiled = compile(&[root.to_path_buf()], &Catalog::builtin(), &read, &mut sources).unwrap();
    for each in compiled.diagnostics.iter().take(20) {
        render(each, &sources, Colour::Never);
    }
    let _ = falsify::lang::format(sources.add("", text.as_str()), &text);
});
