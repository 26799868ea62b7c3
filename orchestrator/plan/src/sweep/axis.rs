//! What a sweep can vary, and the names of each axis: in a file, in a column, in a figure, in a sentence.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The names of an axis.
struct Names {
    word: &'static str,
    column: &'static str,
    heading: &'static str,
    label: &'static str,
    unit: &'static str,
}

/// Declares the axes with their names: the word, the column, the heading, the label along a figure's
/// axis, and the unit after a number in a sentence.
macro_rules! axes {
    ($($(#[$meta:meta])* $axis:ident: $word:literal $column:literal $heading:literal $label:literal $unit:literal,)+) => {
        /// Something that a sweep varies.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "lowercase")]
        pub enum Axis {
            $($(#[$meta])* $axis,)+
        }

        impl Axis {
            /// All axes, the slowest to change first, so that runs over one link follow each other.
            pub const ALL: [Axis; [$($word),+].len()] = [$(Axis::$axis),+];

            const fn names(self) -> Names {
                let (word, column, heading, label, unit) = match self {
                    $(Axis::$axis => ($word, $column, $heading, $label, $unit),)+
                };
                Names { word, column, heading, label, unit }
            }
        }
    };
}

axes! {
    /// A whole link, by its profile.
    Topology: "topology" "topology" "topology" "topology" "",
    /// The constant part of the round trip, half of it each way.
    Rtt: "rtt" "rtt_ms" "rtt/ms" "constant round trip/ms" " ms",
    /// The mean of an exponential variation on top of it, half of it each way.
    Jitter: "jitter" "jitter_ms" "jitter/ms" "mean jitter of the round trip/ms" " ms",
    /// The share of packets lost, each way.
    Loss: "loss" "loss_pct" "loss/%" "packets lost each way/%" " %",
    /// The rate limit, each way.
    Rate: "rate" "rate_bps" "rate/(bit/s)" "rate/(bit/s)" " bit/s",
    /// The client whose timings the two ends have.
    Client: "client" "client" "client" "client" "",
    /// The plant with its law.
    System: "system" "system" "system" "system" "",
    /// The sample time of plant and controller.
    H: "h" "h_ms" "h/ms" "h/ms" " ms",
    /// Requests that may be under way.
    Outstanding: "outstanding" "outstanding" "outstanding" "requests that may be under way" "",
    /// Proportional gain kp.
    Kp: "kp" "kp" "kp" "proportional gain kp" "",
    /// Integral gain ki, in 1/s.
    Ki: "ki" "ki_per_s" "ki/(1/s)" "integral gain ki/(1/s)" "/s",
}

impl Axis {
    /// Its key in a file, and on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        self.names().word
    }

    /// Its column in a table of rows, with its unit.
    #[must_use]
    pub fn column(self) -> &'static str {
        self.names().column
    }

    /// Its heading in a table for people.
    #[must_use]
    pub fn heading(self) -> &'static str {
        self.names().heading
    }

    /// Its name along the axis of a figure.
    #[must_use]
    pub fn label(self) -> &'static str {
        self.names().label
    }

    /// The unit after its numbers in a sentence.
    fn unit(self) -> &'static str {
        self.names().unit
    }

    /// One of its levels as part of a sentence or a heading: `h = 3 ms`, `over couva`.
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

    /// One of its levels on its own: `h = 3 ms`, `couva`.
    #[must_use]
    pub fn title(self, level: &str) -> String {
        match self {
            Axis::Topology | Axis::Client | Axis::System => level.to_owned(),
            _ => format!("{} = {level}{}", self.word(), self.unit()),
        }
    }

    /// Whether its levels are ordered, so that a line may join them.
    #[must_use]
    pub fn is_ordered(self) -> bool {
        !matches!(self, Axis::Topology | Axis::Client | Axis::System)
    }

    /// Whether it describes a link that is made from numbers.
    pub(crate) fn makes_a_link(self) -> bool {
        matches!(self, Axis::Rtt | Axis::Jitter | Axis::Loss | Axis::Rate)
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

/// A word that names no axis.
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
