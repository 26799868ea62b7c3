//! The settings that a role is started with, as programs in other languages read them.
#![allow(clippy::unwrap_used)]

use std::fs;

#[test]
fn the_schema_beside_the_crate_is_the_type() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/settings.schema.json");
    if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
        fs::write(path, backend::settings_schema()).unwrap();
    }
    let remedy = "WEBLOOP_TEST_WRITE=1 writes it anew";
    assert!(
        fs::read_to_string(path).unwrap() == backend::settings_schema(),
        "{remedy}"
    );
}
