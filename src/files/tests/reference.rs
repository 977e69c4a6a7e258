//! The reference of the formats is that of the descriptions.

use std::fs;
use std::path::Path;

use super::super::reference;

#[test]
fn the_shipped_reference_is_that_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference.md");
    if std::env::var_os("AMBIDEX_BLESS").is_some() {
        fs::write(&path, reference()).unwrap();
    }
    let shipped = fs::read_to_string(&path).unwrap_or_default();
    assert!(shipped == reference(), "docs/reference.md is not that of the code: see its head for how to write it anew");
}
