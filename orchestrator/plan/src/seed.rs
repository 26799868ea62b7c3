//! A campaign has one seed; every other seed is derived from it by name.
//!
//! The names leave out client, rate and mode on purpose: cells that share a topology and a repeat share
//! the link's seed, so that every client meets the same bad second.

use sha2::{Digest, Sha256};

/// The link's seed for a topology and a repeat.
///
/// The first eight bytes of SHA-256 over the campaign's seed and the names: the same on every machine,
/// and unrelated for similar names.
#[must_use]
pub fn link_seed(campaign: u64, topology: &str, repeat: u32) -> u64 {
    first_u64(&format!("link/{campaign}/{topology}/{repeat}"))
}

/// The link's seed with a further name, to search for a link with some property.
pub(crate) fn link_seed_of(campaign: u64, topology: &str, repeat: u32, name: u32) -> u64 {
    first_u64(&format!("link/{campaign}/{topology}/{repeat}/{name}"))
}

/// A short fingerprint of a text: its SHA-256 in hex, cut to `digits`.
pub(crate) fn fingerprint(text: &str, digits: usize) -> String {
    let mut hex = format!("{:016x}", first_u64(text));
    hex.truncate(digits);
    hex
}

fn first_u64(text: &str) -> u64 {
    let digest = Sha256::digest(text.as_bytes());
    digest
        .iter()
        .take(8)
        .fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_topology_repeat_or_campaign_gets_another_seed() {
        let seeds = [
            link_seed(1, "couva", 1),
            link_seed(1, "couva", 2),
            link_seed(1, "buccoo", 1),
            link_seed(2, "couva", 1),
        ];
        for (i, a) in seeds.iter().enumerate() {
            assert!(seeds[i + 1..].iter().all(|b| a != b));
        }
    }

    #[test]
    fn a_seed_is_the_same_on_every_machine() {
        // SHA-256 of `link/1/couva/1`, computed elsewhere. If it changes, published runs can no longer
        // be repeated.
        assert_eq!(link_seed(1, "couva", 1), 14_285_805_710_883_392_567);
    }
}
