//! A link made of four numbers, as a profile.

use link::{Diagnostic, Profile};

/// A link made of numbers. Round-trip times are halved between the two ways; loss and rate apply to each way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Made {
    /// The constant part of the round trip.
    pub rtt_ns: u64,
    /// Mean of the exponential delay that is added to it; packets stay in order.
    pub jitter_ns: u64,
    /// Share of packets lost, 0 to 1, independently in each slot of 1 ms.
    pub loss: f64,
    /// Rate limit in bit/s, if there is one.
    pub rate_bps: Option<u64>,
    /// Mean time until the added delay is redrawn.
    pub hold_ns: u64,
}

/// Why a link cannot be played: what its profile's text has against it.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.problems().join("; "))]
pub struct Unplayable(pub Vec<Diagnostic>);

impl Unplayable {
    fn problems(&self) -> Vec<&str> {
        let problems = self.0.iter().map(|finding| finding.problem.as_str());
        problems.collect()
    }
}

impl Made {
    /// The name of its profile. Seeds are derived from it, so all made links have the same draws and
    /// their points can be compared in pairs.
    pub const NAME: &'static str = "made";

    /// Whether every round trip is the same.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.jitter_ns == 0 && self.loss == 0.0 && self.rate_bps.is_none()
    }

    /// The link as a profile.
    ///
    /// # Errors
    /// [`Unplayable`] if it cannot be played.
    pub fn profile(&self) -> Result<Profile, Unplayable> {
        Profile::parse(&self.toml(), Made::NAME).map_err(Unplayable)
    }

    /// The profile as one would write it by hand.
    #[must_use]
    pub fn toml(&self) -> String {
        let one_way = |ns: u64| format!("{}us", ns as f64 / 2e3);
        let mut text = format!(
            "name = \"{}\"\nabout = \"Made of numbers\"\n\n[both]\n",
            Made::NAME
        );
        if let Some(rate_bps) = self.rate_bps {
            text += &format!("rate = \"{rate_bps}bit\"\n");
        }
        text += &format!("delay.base = \"{}\"\n", one_way(self.rtt_ns));
        if self.jitter_ns > 0 {
            text += &format!("delay.hold = \"{}ns\"\n", self.hold_ns);
            text += &format!(
                "delay.spread.exponential.mean = \"{}\"\n",
                one_way(self.jitter_ns)
            );
        }
        if self.loss > 0.0 {
            text += &format!("loss.random.share = \"{}%\"\n", self.loss * 100.0);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_made_link_is_a_profile_that_can_be_played() {
        let whole = Made {
            rtt_ns: 40_000_000,
            jitter_ns: 5_000_000,
            loss: 0.01,
            rate_bps: Some(1_000_000),
            hold_ns: 50_000_000,
        };
        assert_eq!(
            whole.toml(),
            "name = \"made\"\nabout = \"Made of numbers\"\n\n[both]\nrate = \"1000000bit\"\n\
             delay.base = \"20000us\"\ndelay.hold = \"50000000ns\"\n\
             delay.spread.exponential.mean = \"2500us\"\nloss.random.share = \"1%\"\n"
        );
        assert!(whole.profile().is_ok());
        let nothing = Made {
            rtt_ns: 0,
            jitter_ns: 0,
            loss: 0.0,
            rate_bps: None,
            ..whole
        };
        assert!(nothing.is_constant() && nothing.profile().is_ok());
    }

    #[test]
    fn what_cannot_be_played_says_why() {
        let restless = Made {
            rtt_ns: 400_000_000,
            jitter_ns: 5_000_000,
            loss: 0.0,
            rate_bps: None,
            hold_ns: 1_000,
        };
        let problem = restless.profile().map(|_| ()).expect_err("too restless");
        assert!(problem.to_string().contains("redrawn"), "{problem}");
    }
}
