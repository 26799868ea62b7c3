//! Settings for tc's netem: one setting of the queueing discipline, and the commands that apply and
//! remove it.
//!
//! A setting is complete and does not rely on an earlier one, since a change keeps all that it does
//! not name. The [staircase](crate::Staircase) decides when it applies.

use std::fmt;

/// The handle that identifies webloop's own queueing disciplines.
pub const HANDLE: &str = "77:";

/// tc reads a time into 32 bits of 64 ns and rejects more than 274.8 s. No loop waits so long, so a
/// longer delay is played as this one.
const LONGEST_US: u32 = 270_000_000;

/// A rate at which 1500 bytes take 12 ns, so that a burst of ten thousand packets after a stall takes
/// a tenth of a millisecond. It is set only for the order that it implies.
const ORDER_ONLY: &str = "1tbit";

/// netem counts a frame with its Ethernet header, the model only the IP packet in it.
const ETHERNET_HEADER_BYTES: u32 = 14;

/// What netem does to each packet that it receives from now on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// Delay, in the finest unit that every version of tc reads.
    pub delay_us: u32,
    /// Whether all packets are lost.
    pub lost: bool,
    /// The purpose of netem's `rate`.
    pub pace: Pace,
    /// Most packets that netem may hold, including those on the wire.
    pub limit: u32,
}

/// The purpose of netem's `rate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// No rate: a packet overtakes others if the delay falls.
    Free,
    /// A rate too high to have an effect of its own. With any rate netem lets no packet leave before
    /// the one ahead of it; without one it sorts by time of departure.
    Ordered,
    /// The link's own rate limit, in bit/s. It also keeps the order.
    Limited(u64),
}

/// How tc applies a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// The device has only the kernel's default queueing discipline.
    Add,
    /// The device has webloop's. Packets in it stay, with their times of departure.
    Change,
}

impl Setting {
    /// A delay as netem accepts it: rounded to the microsecond and limited to what tc can express.
    pub(crate) fn delay_us(delay_ns: u64) -> u32 {
        let us = (delay_ns.saturating_add(500)) / 1000;
        u32::try_from(us).map_or(LONGEST_US, |us| us.min(LONGEST_US))
    }

    /// The arguments of `tc` that apply this setting to `device`, on one line.
    #[must_use]
    pub fn command(&self, verb: Verb, device: &str) -> String {
        let verb = match verb {
            Verb::Add => "add",
            Verb::Change => "change",
        };
        format!("qdisc {verb} dev {device} root handle {HANDLE} netem {self}")
    }

    /// The arguments of `tc` that remove webloop's netem from `device`, and no other; the kernel then
    /// restores its default.
    #[must_use]
    pub fn removal(device: &str) -> String {
        format!("qdisc del dev {device} root handle {HANDLE}")
    }

    /// The arguments of `tc` that show the queueing discipline of `device`.
    #[must_use]
    pub fn inquiry(device: &str) -> String {
        format!("qdisc show dev {device}")
    }
}

/// The setting in netem's syntax.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = if self.lost { 100 } else { 0 };
        let Self {
            limit, delay_us, ..
        } = self;
        write!(f, "limit {limit} delay {delay_us}us loss {share}%")?;
        match self.pace {
            // Written out, because a change would keep an earlier rate.
            Pace::Free => write!(f, " rate 0bit"),
            Pace::Ordered => write!(f, " rate {ORDER_ONLY}"),
            Pace::Limited(rate_bps) => {
                write!(f, " rate {rate_bps}bit -{ETHERNET_HEADER_BYTES}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_rounded_to_the_microsecond_and_cut_where_tc_ends() {
        assert_eq!(Setting::delay_us(2_461_499), 2_461);
        assert_eq!(Setting::delay_us(2_461_500), 2_462);
        assert_eq!(Setting::delay_us(3_000_000_000), 3_000_000);
        assert_eq!(Setting::delay_us(300_000_000_000), LONGEST_US);
        assert_eq!(Setting::delay_us(u64::MAX), LONGEST_US);
        // 2^32 ticks of 64 ns.
        assert!(u64::from(LONGEST_US) * 1000 < (1 << 32) * 64);
    }
}
