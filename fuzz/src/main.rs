//! The parsers under libFuzzer, which calls a target with bytes and keeps those that lead to code not seen before.
//!
//! `WEBLOOP_FUZZ` names the target. Each must not panic, and what was read and is written must read the same.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

mod target;

static TARGET: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let asked = std::env::var("WEBLOOP_FUZZ").unwrap_or_default();
    let found = target::ALL.iter().find(|(name, _)| *name == asked);
    let Some((_, target)) = found else {
        let names: Vec<&str> = target::ALL.iter().map(|(name, _)| *name).collect();
        panic!(
            "WEBLOOP_FUZZ names no target; use one of {}",
            names.join(", ")
        );
    };
    *target
});

fuzz_target!(|bytes: &[u8]| (*TARGET)(bytes));
