//! Milliseconds, which limits are in, from nanoseconds, which instants are in, and back.

pub(crate) fn ms(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

pub(crate) fn ns(ms: f64) -> u64 {
    (ms * 1e6) as u64
}
