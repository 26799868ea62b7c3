//! Noise of the plant's tick times, from its machine: a seeded extra time for each tick.
//!
//! A plant should keep its deadlines, but the paper's desktop did not: its sample intervals scattered
//! by as much as their own length. Each tick comes later than its due time by an extra time, drawn
//! from its number and the seed alone; its row has both times. The model still advances by one step
//! per tick, so simulated time stays at `k h`, and a late tick may be followed by the next at once.

use std::{fmt, str::FromStr};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::{duration_ns, span_text};

/// Greatest parameter of a law, ns: anything longer is more likely a typing error than a plant.
const SIZE_MAX_NS: u64 = 10_000_000_000;

/// The law of the extra time. Written `uniform 3ms` or `normal 1ms`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
pub enum NoiseLaw {
    /// Anything from nothing to so much, alike.
    Uniform {
        /// The longest, ns.
        max_ns: u64,
    },
    /// The size of a normal deviate, since no tick is early.
    Normal {
        /// The standard deviation of the deviate, ns.
        sd_ns: u64,
    },
}

/// A text that is not a law.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "tick noise `{text}` is not a law; write `uniform` and the longest extra time of a tick, like \
     uniform 3ms, or `normal` and a standard deviation, like normal 1ms, up to 10s"
)]
pub struct InvalidNoise {
    /// The text.
    text: String,
}

/// A law of extra times, with its seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TickNoise {
    /// Distribution of the extra times.
    pub law: NoiseLaw,
    /// The seed of the draws.
    pub seed: u64,
}

/// Draws that are known by their numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws {
    seed: u64,
}

impl TickNoise {
    /// The extra time of tick `k`, ns.
    #[must_use]
    pub fn extra_ns(&self, k: u64) -> u64 {
        let draws = Draws::new(self.seed);
        match self.law {
            NoiseLaw::Uniform { max_ns } => (draws.uniform(k) * max_ns as f64) as u64,
            NoiseLaw::Normal { sd_ns } => (draws.normal(k).abs() * sd_ns as f64) as u64,
        }
    }
}

impl Draws {
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// A normal deviate of variance one, up to six standard deviations.
    pub(crate) fn normal(self, index: u64) -> f64 {
        // The sum of twelve uniform draws has a variance of one, without functions that differ from machine
        // to machine.
        let sum: f64 = (0..12)
            .map(|draw| self.uniform(index.wrapping_mul(12).wrapping_add(draw)))
            .sum();
        sum - 6.0
    }

    /// Draw number `index`, at least 0 and less than 1.
    pub(crate) fn uniform(self, index: u64) -> f64 {
        // SplitMix64 (Steele, Lea and Flood), whose state after a number of steps is a product.
        let mut z = self
            .seed
            .wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl FromStr for NoiseLaw {
    type Err = InvalidNoise;

    fn from_str(text: &str) -> Result<Self, InvalidNoise> {
        let law = text.split_once(' ').and_then(|(word, size)| {
            let ns = duration_ns(size, 1..=SIZE_MAX_NS).ok()?;
            match word {
                "uniform" => Some(Self::Uniform { max_ns: ns }),
                "normal" => Some(Self::Normal { sd_ns: ns }),
                _ => None,
            }
        });
        law.ok_or_else(|| InvalidNoise {
            text: text.to_owned(),
        })
    }
}

impl fmt::Display for NoiseLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Uniform { max_ns } => f.pad(&format!("uniform {}", span_text(*max_ns))),
            Self::Normal { sd_ns } => f.pad(&format!("normal {}", span_text(*sd_ns))),
        }
    }
}

impl TryFrom<String> for NoiseLaw {
    type Error = InvalidNoise;

    fn try_from(text: String) -> Result<Self, InvalidNoise> {
        text.parse()
    }
}

impl From<NoiseLaw> for String {
    fn from(law: NoiseLaw) -> Self {
        law.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn laws_read_back_as_they_are_written_and_others_are_refused() {
        for text in ["uniform 3ms", "normal 1ms", "normal 1500us"] {
            let law: NoiseLaw = text.parse().expect(text);
            assert_eq!(law.to_string().parse(), Ok(law));
        }
        for text in [
            "",
            "uniform",
            "3ms",
            "uniform 0ms",
            "gamma 3ms",
            "normal -1ms",
            "uniform 11s",
        ] {
            assert!(text.parse::<NoiseLaw>().is_err(), "{text}");
        }
    }

    #[test]
    fn extra_times_have_the_moments_of_their_law() {
        // With 100 000 draws the mean is accurate to 0.2 %.
        let mean_ms = |law| {
            let noise = TickNoise { law, seed: 7 };
            let sum: u64 = (0..100_000).map(|k| noise.extra_ns(k)).sum();
            sum as f64 / 1e11
        };
        let uniform = mean_ms(NoiseLaw::Uniform { max_ns: 3 * MS });
        assert!((uniform / 1.5 - 1.0).abs() < 0.01, "{uniform}");
        // The mean size of a normal deviate is its sd times the square root of 2/pi; for the sum of
        // twelve draws it is 1 % more.
        let normal = mean_ms(NoiseLaw::Normal { sd_ns: MS });
        assert!((normal / 0.7979 - 1.0).abs() < 0.02, "{normal}");
    }

    proptest! {
        #[test]
        fn an_extra_time_is_its_seed_s_and_its_tick_s_alone_and_within_its_law(seed: u64, k in 0..u64::MAX / 12 - 1) {
            let noise = TickNoise { law: NoiseLaw::Uniform { max_ns: 3 * MS }, seed };
            prop_assert!(noise.extra_ns(k) < 3 * MS);
            prop_assert_eq!(noise.extra_ns(k), noise.extra_ns(k));
            let normal = TickNoise { law: NoiseLaw::Normal { sd_ns: MS }, seed };
            prop_assert!(normal.extra_ns(k) <= 6 * MS);
        }
    }
}
