//! Compares a generated file with its text in the repository, or writes it.

use std::fs;
use std::path::Path;

/// Asserts that a file equals its generated text; with `RENEW` set, writes the generated text.
pub fn renewed(file: &str, made: impl Fn(&str) -> String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = fs::read_to_string(&path).unwrap_or_default();
    let made = made(&text);
    if std::env::var_os("RENEW").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let place = text.lines().zip(made.lines()).find(|(old, new)| old != new);
    assert!(
        std::env::var_os("RENEW").is_some() || text == made,
        "{file} differs from its source, first at {place:?}; RENEW=1 cargo test --test house \
         writes it again"
    );
}
