//! The output of `tc -s -j qdisc show` for an interface: the owner of the queueing discipline at its
//! root, the setting of a netem there, and its counters.
//!
//! Pure: text in, values out. Running tc is the task of others.

use std::io;

use link::{HANDLE, Pace, Setting};
use serde::Deserialize;
use serde_json::Value;

/// The handle of the kernel's default queueing disciplines, whichever they are.
const KERNELS_HANDLE: &str = "0:";

/// tc counts time in units of 64 ns, and prints it truncated to the microsecond or to six digits,
/// whichever is coarser.
fn rounding_us(delay_us: u64) -> u64 {
    2 + delay_us / 100_000
}

/// The queueing discipline at the root of an interface.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Root {
    kind: String,
    handle: String,
    /// Options differ by kind.
    #[serde(default)]
    options: Value,
    #[serde(flatten)]
    pub(crate) counters: Counters,
}

/// Its counters since it was added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub(crate) struct Counters {
    /// Frames that have left.
    pub(crate) packets: u64,
    /// Their length, Ethernet headers included.
    pub(crate) bytes: u64,
    /// Frames lost by the setting or for lack of room: netem does not distinguish them.
    pub(crate) drops: u64,
    /// Frames in it.
    pub(crate) qlen: u64,
}

/// netem's options. tc leaves out zeros.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Options {
    limit: Option<u32>,
    delay: Delay,
    #[serde(rename = "loss-random")]
    loss: Loss,
    rate: Rate,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Delay {
    /// Delay in seconds.
    delay: f64,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Loss {
    /// A share from 0 to 1.
    loss: f64,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
struct Rate {
    /// Bytes a second.
    rate: u64,
}

/// The owner of a root queueing discipline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// The kernel: its default.
    Kernel,
    /// webloop: a netem with our handle.
    Ours,
    /// Another program: kind and handle.
    Foreign(String),
}

impl Root {
    /// The root among the queueing disciplines of an interface, from tc's listing.
    pub(crate) fn of(listing: &Value) -> io::Result<Self> {
        let invalid = |why: &str| {
            let what = format!("{why} in what tc says: {listing}");
            io::Error::new(io::ErrorKind::InvalidData, what)
        };
        let root = listing
            .as_array()
            .into_iter()
            .flatten()
            .find(|qdisc| qdisc.get("root").and_then(Value::as_bool) == Some(true))
            .ok_or_else(|| invalid("no root"))?;
        Self::deserialize(root).map_err(|error| invalid(&error.to_string()))
    }

    pub(crate) fn owner(&self) -> Owner {
        match (self.kind.as_str(), self.handle.as_str()) {
            (_, KERNELS_HANDLE) => Owner::Kernel,
            ("netem", HANDLE) => Owner::Ours,
            (kind, handle) => Owner::Foreign(format!("{kind} {handle}")),
        }
    }

    /// Checks that the kernel plays `asked`; the error says what differs.
    pub(crate) fn confirm(&self, asked: &Setting) -> Result<(), String> {
        if self.owner() != Owner::Ours {
            return Err(format!("{} {} has taken its place", self.kind, self.handle));
        }
        let options = Options::deserialize(&self.options).map_err(|error| error.to_string())?;
        let delay_us = (options.delay.delay * 1e6).round() as u64;
        let rate = match asked.pace {
            Pace::Free => options.rate.rate == 0,
            Pace::Ordered => options.rate.rate > 0,
            // In whole bytes a second.
            Pace::Limited(rate_bps) => options.rate.rate.abs_diff(rate_bps / 8) <= 1,
        };
        let agrees = delay_us.abs_diff(u64::from(asked.delay_us)) <= rounding_us(delay_us)
            && (options.loss.loss > 0.5) == asked.lost
            && options.limit == Some(asked.limit)
            && rate;
        if agrees {
            Ok(())
        } else {
            Err(format!("it plays {}", self.options))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As printed by tc 6.1 on Linux 6.1.
    const DEFAULT: &str = r#"[{"kind":"mq","handle":"0:","root":true,"options":{},"bytes":0,"packets":0,"drops":0,"overlimits":0,"requeues":0,"backlog":0,"qlen":0},
        {"kind":"fq_codel","handle":"0:","parent":":1","options":{"limit":10240}}]"#;
    const NETEM: &str = r#"[{"kind":"netem","handle":"77:","root":true,"refcnt":2,"options":{"limit":4000,"delay":{"delay":0.002499,"jitter":0,"correlation":0},"loss-random":{"loss":1,"correlation":0},"rate":{"rate":1250000,"packetoverhead":-14,"cellsize":0,"celloverhead":0},"ecn":false,"gap":0},"bytes":196,"packets":2,"drops":3,"overlimits":0,"requeues":0,"backlog":0,"qlen":4}]"#;
    const FOREIGN: &str = r#"[{"kind":"tbf","handle":"1:","root":true,"options":{"rate":125000}}]"#;

    fn root(text: &str) -> Root {
        Root::of(&serde_json::from_str(text).expect("JSON")).expect("a root")
    }

    #[test]
    fn the_kernel_s_ours_and_a_foreign_root_are_told_apart() {
        assert_eq!(root(DEFAULT).owner(), Owner::Kernel);
        assert_eq!(root(NETEM).owner(), Owner::Ours);
        assert_eq!(root(FOREIGN).owner(), Owner::Foreign("tbf 1:".into()));
        let other = root(&NETEM.replace("77:", "8001:"));
        assert_eq!(other.owner(), Owner::Foreign("netem 8001:".into()));
        assert!(Root::of(&Value::Null).is_err());
    }

    #[test]
    fn what_was_accepted_is_held_against_what_was_asked() {
        let asked = Setting {
            delay_us: 2500,
            lost: true,
            pace: Pace::Limited(10_000_000),
            limit: 4000,
        };
        let netem = root(NETEM);
        assert_eq!(netem.confirm(&asked), Ok(()));
        let counters = netem.counters;
        assert_eq!((counters.packets, counters.drops, counters.qlen), (2, 3, 4));
        for other in [
            Setting {
                delay_us: 2503,
                ..asked
            },
            Setting {
                lost: false,
                ..asked
            },
            Setting {
                pace: Pace::Free,
                ..asked
            },
            Setting {
                limit: 1000,
                ..asked
            },
        ] {
            assert!(netem.confirm(&other).is_err(), "{other}");
        }
        assert!(root(DEFAULT).confirm(&asked).is_err());
    }
}
