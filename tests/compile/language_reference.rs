//! `grammar/README.md` lists the forms, kinds and keys of the catalogue.

use compile::Catalog;

#[test]
fn the_language_reference_is_up_to_date() {
    const MARK: &str = "<!-- generated -->\n";
    let path = crate::repository().join("grammar/README.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (written, printed) = page.split_once(MARK).expect("the reference has a mark before its generated part");
    let wanted = format!("\n{}", Catalog::builtin().reference());
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(path, format!("{written}{MARK}{wanted}")).unwrap();
        return;
    }
    assert_eq!(printed, wanted, "run the test again with UPDATE_REFERENCE=1");
}
