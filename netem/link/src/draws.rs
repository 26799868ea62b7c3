//! Seeded uniform draws that can be requested in any order.
//!
//! ChaCha maps a counter to bits, so draw number `index` of a stream exists without its predecessors;
//! this makes a link's state a function of time. This file does not know what the draws are for.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// Number of draws computed at once: the four ChaCha blocks (256 bytes) with which the generator
/// fills its own buffer.
const BATCH: u64 = 32;

/// One stream of independent draws, uniform on the open interval (0, 1).
#[derive(Debug, Clone)]
pub(crate) struct Draws {
    rng: ChaCha8Rng,
    /// The number of the batch that is there; `u64::MAX`, which no draw's is, before the first.
    number: u64,
    batch: [u64; BATCH as usize],
}

impl Draws {
    /// The stream called `name` under `seed`. Streams of one seed are
    /// independent: the seed is ChaCha's key, the name its stream number.
    pub(crate) fn new(seed: u64, name: &[u8; 8]) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(u64::from_le_bytes(*name));
        Self {
            rng,
            number: u64::MAX,
            batch: [0; BATCH as usize],
        }
    }

    /// Draw number `index`.
    #[inline]
    pub(crate) fn at(&mut self, index: u64) -> f64 {
        let number = index / BATCH;
        if self.number != number {
            self.fill(number);
        }
        // 52 bits and a half: exact in an f64, never 0 and never 1, so that no quantile function is
        // evaluated at its infinite ends.
        ((self.batch[(index % BATCH) as usize] >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    fn fill(&mut self, number: u64) {
        let mut bits = [0; BATCH as usize * 8];
        // A draw is two 32-bit words of the stream.
        self.rng
            .set_word_pos(u128::from(number) * u128::from(BATCH) * 2);
        self.rng.fill_bytes(&mut bits);
        for (draw, bits) in self.batch.iter_mut().zip(bits.as_chunks().0) {
            *draw = u64::from_le_bytes(*bits);
        }
        self.number = number;
    }
}

/// When in its interval echo `seq` of a series is sent: uniformly distributed, by the link's seed and
/// the number of the series, so that no periodic disturbance can always fall between echoes.
#[must_use]
pub fn within_ns(seed: u64, series: u16, seq: u32, interval_ns: u64) -> u64 {
    let draw = mix(seed ^ (u64::from(series) << 32 | u64::from(seq)));
    // The upper half of the product is less than the interval.
    ((u128::from(draw) * u128::from(interval_ns)) >> 64) as u64
}

/// Mixes the bits of a number: the last step of splitmix64 (Steele, Lea and Flood, 2014).
fn mix(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draw_does_not_depend_on_the_order_of_asking() {
        let mut forward = Draws::new(1, b"up.level");
        let all: Vec<f64> = (0..200).map(|i| forward.at(i)).collect();
        let mut backward = Draws::new(1, b"up.level");
        for i in (0..200).rev() {
            assert_eq!(backward.at(i).to_bits(), all[i as usize].to_bits());
        }
    }

    #[test]
    fn streams_and_seeds_differ() {
        let first = |seed, name| Draws::new(seed, name).at(0).to_bits();
        assert_ne!(first(1, b"up.level"), first(2, b"up.level"));
        assert_ne!(first(1, b"up.level"), first(1, b"dn.level"));
    }

    #[test]
    fn the_mean_of_a_hundred_thousand_draws_is_a_half() {
        // Standard error: 1/sqrt(12 n) = 0.0009; the limit is five of them.
        let mut draws = Draws::new(7, b"up.level");
        let n = 100_000;
        let mean = (0..n).map(|i| draws.at(i)).sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < 0.0046, "mean {mean}");
    }

    #[test]
    fn the_first_draws_are_the_same_on_every_machine_and_in_every_version() {
        // A change here changes every recorded run, so it needs a new major version.
        let mut draws = Draws::new(42, b"up.level");
        let first: Vec<String> = (0..10)
            .map(|i| format!("{:016x}", draws.at(i).to_bits()))
            .collect();
        insta::assert_snapshot!(first.join("\n"));
    }
}
