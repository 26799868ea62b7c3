//! What a sweep can vary, and how each of it is called: in a file, in a column, in a figure, in a
//! sentence.

use std::fmt;
use std::str::FromStr;

/// Something that a sweep varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Axis {
    /// A whole link, by its profile.
    Topology,
    /// The constant part of the round trip, half of it each way.
    Rtt,
    /// The mean of an exponential variation on top of it, half of it each way.
    Jitter,
    /// The share of packets lost, each way.
    Loss,
    /// The rate limit, each way.
    Rate,
    /// Whose timings the two ends have.
    Client,
    /// What is controlled, and by what law.
    System,
    /// The sample time of plant and controller.
    H,
    /// Requests that may be under way.
    Outstanding,
    /// Proportional gain.
    Kp,
    /// Integral gain.
    Ki,
}

impl Axis {
    /// All of them, the slowest to change first: runs over one link follow each other.
    pub const ALL: [Axis; 11] = [
        Axis::Topology,
        Axis::Rtt,
        Axis::Jitter,
        Axis::Loss,
        Axis::Rate,
        Axis::Client,
        Axis::System,
        Axis::H,
        Axis::Outstanding,
        Axis::Kp,
        Axis::Ki,
    ];

    /// Its key in a file, and on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Axis::Topology => "topology",
            Axis::Rtt => "rtt",
            Axis::Jitter => "jitter",
            Axis::Loss => "loss",
            Axis::Rate => "rate",
            Axis::Client => "client",
            Axis::System => "system",
            Axis::H => "h",
            Axis::Outstanding => "outstanding",
            Axis::Kp => "kp",
            Axis::Ki => "ki",
        }
    }

    /// Its column in a table of rows, with its unit.
    #[must_use]
    pub fn column(self) -> &'static str {
        match self {
            Axis::Rtt => "rtt_ms",
            Axis::Jitter => "jitter_ms",
            Axis::Loss => "loss_pct",
            Axis::Rate => "rate_bps",
            Axis::H => "h_ms",
            Axis::Ki => "ki_per_s",
            Axis::Topology | Axis::Client | Axis::System | Axis::Outstanding | Axis::Kp => {
                self.word()
            }
        }
    }

    /// Its heading in a table for people.
    pub(crate) fn heading(self) -> &'static str {
        match self {
            Axis::Rtt => "rtt/ms",
            Axis::Jitter => "jitter/ms",
            Axis::Loss => "loss/%",
            Axis::Rate => "rate/(bit/s)",
            Axis::H => "h/ms",
            Axis::Ki => "ki/(1/s)",
            Axis::Topology | Axis::Client | Axis::System | Axis::Outstanding | Axis::Kp => {
                self.word()
            }
        }
    }

    /// Its name along the axis of a figure.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Axis::Topology => "topology",
            Axis::Rtt => "constant round trip/ms",
            Axis::Jitter => "mean jitter of the round trip/ms",
            Axis::Loss => "packets lost each way/%",
            Axis::Rate => "rate/(bit/s)",
            Axis::Client => "client",
            Axis::System => "system",
            Axis::H => "h/ms",
            Axis::Outstanding => "requests that may be under way",
            Axis::Kp => "proportional gain kp",
            Axis::Ki => "integral gain ki/(1/s)",
        }
    }

    /// What stands behind its numbers in a sentence.
    fn unit(self) -> &'static str {
        match self {
            Axis::Rtt | Axis::Jitter | Axis::H => " ms",
            Axis::Loss => " %",
            Axis::Rate => " bit/s",
            Axis::Ki => "/s",
            Axis::Topology | Axis::Client | Axis::System | Axis::Outstanding | Axis::Kp => "",
        }
    }

    /// One of its levels in a sentence or a heading: `h = 3 ms`, `over couva`.
    #[must_use]
    pub fn say(self, level: &str) -> String {
        match self {
            Axis::Topology => format!("over {level}"),
            Axis::Client => format!("from {level}"),
            Axis::System => format!("of {level}"),
            Axis::Outstanding => match level {
                "1" => "with 1 request under way".to_owned(),
                _ => format!("with {level} requests under way"),
            },
            _ => format!("at {} = {level}{}", self.word(), self.unit()),
        }
    }

    /// The same where it stands alone: `h = 3 ms`, `couva`.
    #[must_use]
    pub fn title(self, level: &str) -> String {
        match self {
            Axis::Topology | Axis::Client | Axis::System => level.to_owned(),
            _ => format!("{} = {level}{}", self.word(), self.unit()),
        }
    }

    /// Whether its levels stand in an order, so that a line may join them.
    #[must_use]
    pub fn is_ordered(self) -> bool {
        !matches!(self, Axis::Topology | Axis::Client | Axis::System)
    }

    /// Whether it is part of a link that is made from numbers.
    pub(crate) fn makes_a_link(self) -> bool {
        matches!(self, Axis::Rtt | Axis::Jitter | Axis::Loss | Axis::Rate)
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

/// A word that no axis has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no axis `{0}`; choose topology, rtt, jitter, loss, rate, client, system, h, outstanding, \
     kp or ki"
)]
pub struct UnknownAxis(String);

impl FromStr for Axis {
    type Err = UnknownAxis;

    fn from_str(word: &str) -> Result<Self, UnknownAxis> {
        Axis::ALL
            .into_iter()
            .find(|axis| axis.word() == word)
            .ok_or_else(|| UnknownAxis(word.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_read_as_it_is_written() {
        for axis in Axis::ALL {
            assert_eq!(axis.to_string().parse(), Ok(axis));
        }
        assert!("delay".parse::<Axis>().is_err());
    }

    #[test]
    fn levels_are_said_with_their_units() {
        assert_eq!(Axis::H.say("3"), "at h = 3 ms");
        assert_eq!(Axis::Topology.say("couva"), "over couva");
        assert_eq!(Axis::Outstanding.say("1"), "with 1 request under way");
        assert_eq!(Axis::Ki.title("0.378"), "ki = 0.378/s");
    }
}
