//! How old a command is when it arrives, and which is too old to be applied.
//!
//! A stamp says when a command was sent, by its sender's clock. What the plant makes of it depends on that clock:
//!
//! - **Shared** with the plant: the age is arrival minus stamp, and nothing is learned or forgotten. A stamp from the
//!   plant's future is by another clock, or a wrong one.
//! - **Its own**: the difference of both clocks is only bounded from above, by the least arrival minus stamp, the
//!   *zero*. A command is too old if it came later than the zero by more than the limit.
//!
//! The zero belongs to a clock, so to an address: a lease, a silence, a session or a reset of the plant does not
//! forget it. A quicker command lowers it, by a little for good; by more, until others have said the same for
//! [`CONFIRM_NS`], only for [`DOUBT_NS`], and by more than [`LEAP_NS`] not at all before. So one stamp ahead of its
//! time does not outlast a second. It is raised by [`DRIFT_PPM`], and set anew only by a session whose commands
//! cannot be as old as it says.
//!
//! Left out: who sends (`plant`'s session), order (`seq`), and a first command by a clock that nothing is known of,
//! whose age nobody can tell.

use std::{collections::BTreeMap, net::IpAddr};

use crate::setting::Clock;

/// Clocks of two machines part by at most this, in parts of a million. So a zero is let go by as much, or a command
/// would seem to age while its controller runs for hours.
const DRIFT_PPM: i128 = 250;

/// How long commands must say that the zero is too high before it is lowered for good.
const CONFIRM_NS: u64 = 500_000_000;

/// How long one that nothing else bears out is believed.
const DOUBT_NS: u64 = 1_000_000_000;

/// By how much a link may become quicker at once. Beyond it, and beyond the limit of age, a clock may as well be
/// wrong.
const LEAP_NS: i128 = 1_000_000_000;

/// How far from the future a stamp by the plant's own clock may be: a page measures that clock, and a timer's steps
/// are coarse.
const AHEAD_NS: i128 = 50_000_000;

/// How far behind a stamp over loopback may be and still be by this machine's clock. Beyond it is more likely another
/// one, as behind a tunnel, unless that address has used this clock.
const BEHIND_NS: i128 = 600_000_000_000;

/// A command that is this young by the plant's clock was stamped by it.
const SHOWN_NS: i128 = 1_000_000_000;

/// How many addresses are remembered. None is forgotten; commands of more are too old.
const ADDRESSES: usize = 4096;

/// What is known of the clocks of all who send.
#[derive(Clone, Debug)]
pub(crate) struct Ages {
    max_ns: i128,
    setting: Clock,
    known: BTreeMap<Option<IpAddr>, Known>,
    from: Option<IpAddr>,
}

/// What is known of the clock at one address.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// Whether it has stamped by the plant's clock.
    is_shared: bool,
    zero: Option<Zero>,
    doubt: Option<Doubt>,
}

/// The least arrival minus stamp of a clock.
#[derive(Clone, Copy, Debug)]
struct Zero {
    way_ns: i128,
    at_ns: u64,
}

/// A lower zero that is not confirmed.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    zero: Zero,
    since_ns: u64,
    /// Whether commands are judged by it already.
    is_acting: bool,
}

/// A command's stamp, when it arrived, and from when on it can have been sent, if a session says so.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stamped {
    pub(crate) t_send_ns: u64,
    pub(crate) now_ns: u64,
    pub(crate) since_ns: Option<u64>,
}

impl Stamped {
    fn way_ns(self) -> i128 {
        i128::from(self.now_ns) - i128::from(self.t_send_ns)
    }
}

impl Zero {
    fn of(stamped: Stamped) -> Self {
        Self {
            way_ns: stamped.way_ns(),
            at_ns: stamped.now_ns,
        }
    }

    /// Where it is at `now_ns`.
    fn now(self, now_ns: u64) -> i128 {
        let passed_ns = i128::from(now_ns.saturating_sub(self.at_ns));
        self.way_ns + passed_ns * DRIFT_PPM / 1_000_000
    }
}

impl Ages {
    /// Nothing is known yet; a command may be `max_age_ns` old.
    pub(crate) fn new(max_age_ns: u64, setting: Clock) -> Self {
        Self {
            max_ns: i128::from(max_age_ns),
            setting,
            known: BTreeMap::new(),
            from: None,
        }
    }

    /// The next commands come from here.
    pub(crate) fn hear(&mut self, address: IpAddr) {
        self.from = Some(address);
    }

    /// Learns from a command, and tells whether it is too old.
    pub(crate) fn refuses(&mut self, stamped: Stamped) -> bool {
        let is_full = self.known.len() >= ADDRESSES;
        if is_full && !self.known.contains_key(&self.from) {
            return true;
        }
        let max_ns = self.max_ns;
        let known = self.known.entry(self.from).or_default();
        let may_share = match self.setting {
            Clock::Shared => {
                known.is_shared = true;
                true
            }
            Clock::Own => self.from.is_some_and(|from| from.is_loopback()),
        };
        if !may_share {
            return known.refuses(stamped, max_ns);
        }
        let way_ns = stamped.way_ns();
        if way_ns < -AHEAD_NS {
            return known.refuses_ahead(stamped, max_ns);
        }
        known.is_shared |= way_ns <= SHOWN_NS;
        if way_ns > BEHIND_NS && !known.is_shared {
            return known.refuses(stamped, max_ns);
        }
        if way_ns <= max_ns {
            known.doubt = None;
        }
        way_ns > max_ns
    }
}

impl Known {
    /// Learns from a command by a clock of its own, and tells whether it is too old.
    fn refuses(&mut self, stamped: Stamped, max_ns: i128) -> bool {
        let (now_ns, way_ns) = (stamped.now_ns, stamped.way_ns());
        self.settle(stamped, max_ns);
        let Some(zero) = self.zero.map(|zero| zero.now(now_ns)) else {
            self.zero = Some(Zero::of(stamped));
            return false;
        };
        let acting = self.doubt.as_mut().filter(|doubt| doubt.is_acting);
        let least = acting.as_ref().map_or(zero, |doubt| doubt.zero.now(now_ns));
        if way_ns > least + max_ns {
            return !self.begins_anew(stamped, least);
        }
        if way_ns >= least - slack(max_ns) {
            if way_ns <= least {
                let lowered = Zero::of(stamped);
                match acting {
                    Some(doubt) => doubt.zero = lowered,
                    None => self.zero = Some(lowered),
                }
            }
            return false;
        }
        let is_acting = way_ns >= zero - LEAP_NS.max(max_ns);
        self.doubts(stamped, max_ns, is_acting);
        !is_acting
    }

    /// The same for one that is stamped in the future of the clock that is shared: it is too old until its own clock is
    /// known.
    fn refuses_ahead(&mut self, stamped: Stamped, max_ns: i128) -> bool {
        if self.zero.is_none() {
            self.settle(stamped, max_ns);
        }
        if self.zero.is_some() {
            return self.refuses(stamped, max_ns);
        }
        self.doubts(stamped, max_ns, false);
        true
    }

    /// Confirms a lower zero, or gives it up, by the next command.
    fn settle(&mut self, stamped: Stamped, max_ns: i128) {
        let Some(doubt) = self.doubt else {
            return;
        };
        let (zero, way_ns) = (doubt.zero.now(stamped.now_ns), stamped.way_ns());
        let for_ns = stamped.now_ns.saturating_sub(doubt.since_ns);
        if (way_ns - zero).abs() <= slack(max_ns) {
            if for_ns >= CONFIRM_NS {
                self.zero = Some(doubt.zero);
                self.doubt = None;
            }
            return;
        }
        // Where it is not acting, one that it would call old is against it.
        let is_against = way_ns > zero + max_ns && !doubt.is_acting;
        if is_against || (doubt.is_acting && for_ns > DOUBT_NS) {
            self.doubt = None;
        }
    }

    /// Takes a command that is far quicker than all before.
    fn doubts(&mut self, stamped: Stamped, max_ns: i128, is_acting: bool) {
        let way_ns = stamped.way_ns();
        let own = Zero::of(stamped);
        if let Some(doubt) = &mut self.doubt {
            let zero = doubt.zero.now(stamped.now_ns);
            if doubt.is_acting == is_acting && way_ns >= zero - slack(max_ns) {
                if way_ns <= zero {
                    doubt.zero = own;
                }
                return;
            }
        }
        self.doubt = Some(Doubt {
            zero: own,
            since_ns: stamped.now_ns,
            is_acting,
        });
    }

    /// Takes a command that looks old as the first by another clock, if by this one it was sent before its token was
    /// made; tells whether.
    fn begins_anew(&mut self, stamped: Stamped, zero: i128) -> bool {
        let sent_ns = i128::from(stamped.t_send_ns) + zero;
        let is_another = stamped
            .since_ns
            .is_some_and(|since_ns| sent_ns < i128::from(since_ns));
        if is_another {
            self.zero = Some(Zero::of(stamped));
            self.doubt = None;
        }
        is_another
    }
}

/// By how much one command may lower a zero, so that one that is stamped ahead leaves room for those that are not.
fn slack(max_ns: i128) -> i128 {
    max_ns / 4
}
