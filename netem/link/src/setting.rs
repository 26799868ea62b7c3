//! Settings for tc's netem: one setting of the queueing discipline, and the commands that
//! put it in force and take it away.
//!
//! A setting is complete: nothing is left to what an earlier one has said, since a change
//! keeps what it does not name. When it is in force is the business of the
//! [staircase](crate::Staircase).

use std::fmt;

/// The handle of every queueing discipline that is ours, by which it is known again.
pub const HANDLE: &str = "77:";

/// tc reads a time into 32 bits of 64 ns, and refuses more than 274.8 s. No loop waits so
/// long, so a longer delay is played as this one.
const LONGEST_US: u32 = 270_000_000;

/// A rate at which 1500 bytes take 12 ns, so that the burst of ten thousand that a stall lets
/// go takes a tenth of a millisecond. It is given for the order that comes with it.
const ORDER_ONLY: &str = "1tbit";

/// netem counts a frame with its Ethernet header, the model counts the IP packet in it.
const ETHERNET_HEADER_BYTES: u32 = 14;

/// What netem is to do with each packet that it gets from now on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// Delay, in the finest unit that every tc reads.
    pub delay_us: u32,
    /// Whether packets are lost, all of them.
    pub lost: bool,
    /// What netem's `rate` is for.
    pub pace: Pace,
    /// The most packets that netem may hold, those on the wire included.
    pub limit: u32,
}

/// What netem's `rate` is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// No rate: a packet overtakes others when the delay falls.
    Free,
    /// A rate too high to be felt. With any rate netem lets no packet leave before the one
    /// ahead of it, and without one it sorts by time of departure.
    Ordered,
    /// The link's own rate limit, in bit/s. It keeps the order too.
    Limited(u64),
}

/// How tc applies a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// The device has no queueing discipline but the kernel's default.
    Add,
    /// It has ours. Packets in it stay, with the departures that they have.
    Change,
}

impl Setting {
    /// A delay as netem takes it: to the microsecond, and no longer than tc can say.
    pub(crate) fn delay_us(delay_ns: u64) -> u32 {
        let us = (delay_ns.saturating_add(500)) / 1000;
        u32::try_from(us).map_or(LONGEST_US, |us| us.min(LONGEST_US))
    }

    /// The arguments of `tc` that put this in force on `device`, on one line.
    #[must_use]
    pub fn command(&self, verb: Verb, device: &str) -> String {
        let verb = match verb {
            Verb::Add => "add",
            Verb::Change => "change",
        };
        format!("qdisc {verb} dev {device} root handle {HANDLE} netem {self}")
    }

    /// The arguments of `tc` that remove our netem from `device`, and no other: the kernel puts
    /// its default back.
    #[must_use]
    pub fn removal(device: &str) -> String {
        format!("qdisc del dev {device} root handle {HANDLE}")
    }

    /// The arguments of `tc` that show what is in force on `device`.
    #[must_use]
    pub fn inquiry(device: &str) -> String {
        format!("qdisc show dev {device}")
    }
}

/// The setting in netem's words.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = if self.lost { 100 } else { 0 };
        let Self {
            limit, delay_us, ..
        } = self;
        write!(f, "limit {limit} delay {delay_us}us loss {share}%")?;
        match self.pace {
            // Said, because a change would keep an earlier one.
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
