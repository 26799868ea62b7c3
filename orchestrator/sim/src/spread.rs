//! A time that varies: the quantiles of a measurement, and draws from them.
//!
//! A measured distribution is kept as it is, since the tails of a machine's delays follow no named
//! law. It is all integers, so draws are the same bits on every machine.

use rand_chacha::ChaCha8Rng;
use rand_core::Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Steps between quantiles: the upper five bits of a draw choose the step, the others the place in it.
const STEPS: usize = 32;
const STEP_BITS: u32 = 32 - STEPS.trailing_zeros();

/// A distribution of times in ns, by its quantiles 0, 1/32, ... 1.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<u32>", into = "Vec<u32>")]
pub struct Spread {
    quantiles_ns: [u32; STEPS + 1],
    /// Whether all are equal: then nothing has to be drawn.
    constant: bool,
}

/// Values that are not the quantiles of a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum InvalidSpread {
    /// Neither a single number nor one quantile per step.
    #[error("a spread of times is one number of ns, or 33 quantiles from 0 to 1; these are {0}")]
    Count(usize),
    /// A quantile is less than the one before it.
    #[error("quantile {index} is less than the one before it")]
    Order {
        /// Its index, from 0.
        index: usize,
    },
}

impl Spread {
    /// Always the same time.
    #[must_use]
    pub const fn constant(ns: u32) -> Self {
        Self {
            quantiles_ns: [ns; STEPS + 1],
            constant: true,
        }
    }

    /// The distribution of these times, in ns and in any order; 0 for an empty list.
    ///
    /// The ends are the quantiles 0.5 % and 99.5 %: the model does not need the very slowest times,
    /// which come from the machine at that moment and not from the program.
    #[must_use]
    pub fn of(times_ns: &mut [u32]) -> Self {
        times_ns.sort_unstable();
        let Some(last) = times_ns.len().checked_sub(1) else {
            return Self::constant(0);
        };
        let mut quantiles_ns = [0; STEPS + 1];
        for (i, quantile_ns) in quantiles_ns.iter_mut().enumerate() {
            let share = (i as f64 / STEPS as f64).clamp(0.005, 0.995);
            *quantile_ns = times_ns[(share * last as f64).round() as usize];
        }
        Self::from(quantiles_ns)
    }

    /// The median, in ns.
    #[must_use]
    pub fn median_ns(&self) -> u32 {
        self.quantiles_ns[STEPS / 2]
    }

    /// Draws a time, in ns.
    #[inline]
    pub(crate) fn draw(&self, random: &mut ChaCha8Rng) -> u64 {
        if self.constant {
            return u64::from(self.quantiles_ns[0]);
        }
        let draw = random.next_u32();
        let step = (draw >> STEP_BITS) as usize;
        let within = u64::from(draw & ((1 << STEP_BITS) - 1));
        let from_ns = u64::from(self.quantiles_ns[step]);
        let width_ns = u64::from(self.quantiles_ns[step + 1]) - from_ns;
        from_ns + ((width_ns * within) >> STEP_BITS)
    }
}

impl From<[u32; STEPS + 1]> for Spread {
    fn from(quantiles_ns: [u32; STEPS + 1]) -> Self {
        Self {
            constant: quantiles_ns[0] == quantiles_ns[STEPS],
            quantiles_ns,
        }
    }
}

impl TryFrom<Vec<u32>> for Spread {
    type Error = InvalidSpread;

    fn try_from(quantiles_ns: Vec<u32>) -> Result<Self, InvalidSpread> {
        if let [ns] = quantiles_ns[..] {
            return Ok(Self::constant(ns));
        }
        if let Some(index) = quantiles_ns.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(InvalidSpread::Order { index: index + 1 });
        }
        <[u32; STEPS + 1]>::try_from(quantiles_ns)
            .map(Self::from)
            .map_err(|given| InvalidSpread::Count(given.len()))
    }
}

impl From<Spread> for Vec<u32> {
    fn from(spread: Spread) -> Self {
        if spread.constant {
            vec![spread.quantiles_ns[0]]
        } else {
            spread.quantiles_ns.to_vec()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;

    #[test]
    fn draws_have_the_quantiles_that_were_measured() {
        // An exponential law by its own quantiles, compared with 100 000 draws.
        let mut times: Vec<u32> = (0..10_000)
            .map(|i| (-50_000.0 * (1.0 - (f64::from(i) + 0.5) / 1e4).ln()) as u32)
            .collect();
        let spread = Spread::of(&mut times);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut drawn: Vec<u64> = (0..100_000).map(|_| spread.draw(&mut random)).collect();
        drawn.sort_unstable();
        for share in [0.1, 0.25, 0.5, 0.75, 0.9] {
            let (of_times, of_draws) = (
                f64::from(times[(share * 1e4) as usize]),
                drawn[(share * 1e5) as usize] as f64,
            );
            assert!(
                (of_draws / of_times - 1.0).abs() < 0.03,
                "{share}: {of_times} {of_draws}"
            );
        }
    }

    #[test]
    fn what_is_no_distribution_is_refused_with_its_place() {
        assert_eq!(Spread::try_from(vec![7]), Ok(Spread::constant(7)));
        assert_eq!(
            Spread::try_from(vec![1, 2]).map_err(|error| error.to_string()),
            Err(
                "a spread of times is one number of ns, or 33 quantiles from 0 to 1; these are 2"
                    .to_owned()
            )
        );
        let mut falling: Vec<u32> = (0..33).collect();
        falling[7] = 0;
        assert_eq!(
            Spread::try_from(falling),
            Err(InvalidSpread::Order { index: 7 })
        );
    }
}
