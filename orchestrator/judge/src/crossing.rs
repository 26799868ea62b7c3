//! Compares the messages of one way with the link that was asked for.

use link::{Timeline, Way};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::limit::{
    Allowance, FLOOR_QUANTILE, LATE_MS, LATE_SHARE_OF_DELAY, QUICKER_MS, QUICKER_PER_MILLE,
    READING_SHARE, RESEND_MS, RESENT, RESENT_DEVIATIONS, RESENT_MS, RESENT_PER_MILLE, STALL_MS,
};
use crate::terms::{MESSAGE_BYTES, Swamped, Terms, Window, ms, ns};

/// What the messages say of one way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Crossed {
    /// Messages that crossed it.
    pub count: u64,
    /// Those that were quicker than the link lets them.
    pub quicker: u64,
    /// How much later than the link a tenth of them are at most, ms.
    pub excess_p10_ms: f64,
    /// Half of them.
    pub excess_p50_ms: f64,
    /// Ninety-nine of a hundred.
    pub excess_p99_ms: f64,
    /// Those that are late and that no loss of the link excuses.
    pub late: u64,
    /// Those of them that came as late as a resend.
    pub resent: u64,
    /// Those that may have been lost, by the link's slots, expected.
    pub lost_due: f64,
    /// Those of them that came as late as a resend, or never.
    pub lost: u64,
    /// The variance of what is lost: [`Crossed::lost_due`] of messages by themselves, more of those that
    /// enter together and meet one slot of the link. Known to who held them, and not written.
    #[serde(skip)]
    pub lost_variance: f64,
}

/// One message on one way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    pub(crate) enters_ns: u64,
    /// `None` if it never arrived.
    pub(crate) leaves_ns: Option<u64>,
    /// Whether its client may have had to open a connection for it.
    pub(crate) opens: bool,
    /// Whether a fault of the link may have broken its connection, or one of an end held it up: then it may be sent
    /// again at any time, or never, and how late it is says nothing.
    pub(crate) is_unsure: bool,
}

/// Compares the crossings of one way, in order of entry, with the link.
pub(crate) fn cross(way: Way, crossings: &[Crossing], terms: &Terms, swamped: &Swamped) -> Crossed {
    let mut held = Held::new(way, terms);
    let expected: Vec<Expected> = crossings.iter().map(|one| held.expect(one)).collect();
    let read_by_ns = held.read_by_ns(&expected);
    for ((crossing, expected), read_by_ns) in crossings.iter().zip(&expected).zip(read_by_ns) {
        held.add(crossing, expected, read_by_ns, swamped);
    }
    held.finish()
}

/// The state of the comparison of one way.
struct Held<'a> {
    way: Way,
    terms: &'a Terms,
    /// Each way has its own: a timeline forgets what lies far behind its newest query.
    link: Timeline,
    sender: Allowance,
    /// Time between the stamps of sender and receiver that is not the link's, ms: the player's cost
    /// and, on the way down, the client's delay.
    own_ms: f64,
    /// Time that the receiver needs to read a message.
    read_ns: u64,
    /// On a shared connection no message leaves before those sent earlier.
    held_until_ns: u64,
    crossed: Crossed,
    excess_ms: Vec<f64>,
    bunch: Bunch,
}

/// What the link should do to a message.
struct Expected {
    /// When it leaves, if it needs no new connection and waits for no other message.
    direct: Window,
    /// The latest time at which it leaves.
    latest_ns: u64,
    /// The probability that it is lost.
    lossy: f64,
    /// When a resend of it leaves at the earliest; `None` if its loss would not show. If a connection is
    /// opened for the message, it is unknown at which crossing of the handshake a loss was.
    again_ns: Option<u64>,
    /// Whether its lateness or loss says nothing, because of a fault of the link.
    is_unsure: bool,
    /// Whether it may have waited until the link lost it, though it should have crossed.
    may_stray: bool,
}

impl<'a> Held<'a> {
    fn new(way: Way, terms: &'a Terms) -> Held<'a> {
        // The plant is webloop's own, whatever the client.
        let plant = plan::Client::Native.spec().allowance;
        let client = terms.allowance;
        let (sender, receiver, slack_ms) = match way {
            Way::Up => (client, plant, 0.0),
            Way::Down => (plant, client, client.enters_within_ms),
        };
        Held {
            way,
            terms,
            link: terms.timeline.clone(),
            sender,
            own_ms: terms.baseline_ms[way as usize] + slack_ms,
            read_ns: ns(receiver.message_ms.min(READING_SHARE * terms.h_ms)),
            held_until_ns: 0,
            crossed: Crossed::default(),
            excess_ms: Vec::new(),
            bunch: Bunch::default(),
        }
    }

    fn expect(&mut self, crossing: &Crossing) -> Expected {
        let Held {
            way, terms, sender, ..
        } = *self;
        let within_ns = ns(sender.enters_within_ms);
        let stray_ns = ns(sender.strays_within_ms);
        let mut window = |within_ns| {
            let t_ns = crossing.enters_ns;
            terms.window(&mut self.link, way, t_ns, within_ns, MESSAGE_BYTES)
        };
        let (mut direct, stray) = (window(within_ns), window(stray_ns));
        if stray.lossy >= 1.0 {
            let link = &mut self.link;
            let again_ns = terms.carries_again_ns(link, way, crossing.enters_ns, stray_ns);
            direct.earliest_ns = direct.earliest_ns.max(again_ns);
        }
        let (mut latest_ns, mut lossy) = (direct.latest_ns, stray.lossy);
        let mut is_unsure = crossing.is_unsure;
        if crossing.opens {
            let opened = terms.opened(&mut self.link, crossing.enters_ns, within_ns);
            latest_ns = latest_ns.max(opened.latest_ns);
            let strays = terms.opened_lossy(&mut self.link, crossing.enters_ns, within_ns);
            lossy = lossy.max(opened.lossy).max(strays);
        }
        // Where a fault loses many packets, which connection is free when is not known so exactly: any message
        // may have waited for one for as long as a handshake takes.
        let link = &mut self.link;
        let may_wait =
            way == Way::Up && !crossing.opens && link.loses_by_fault(way, crossing.enters_ns);
        let may_stray = may_wait && {
            let opened = terms.opened(link, crossing.enters_ns, within_ns);
            let wait_ns = opened.latest_ns.saturating_sub(crossing.enters_ns);
            let wait_ns = wait_ns.min(ns(RESEND_MS));
            let waited = terms.window(link, way, crossing.enters_ns, wait_ns, MESSAGE_BYTES);
            waited.lossy > 0.0
        };
        // Asked here, where the link is asked for this time anyway: it has forgotten it later.
        let again_ns = (lossy > 0.0 && !crossing.opens).then(|| {
            let again_ns = crossing.enters_ns + ns(RESEND_MS);
            let link = &mut self.link;
            let again = terms.window(link, way, again_ns, within_ns, MESSAGE_BYTES);
            again.earliest_ns
        });
        if terms.shares_one {
            // Behind a lost packet others follow on the same connection, so that it is sent again a round
            // trip later: where a fault loses many, how many were lost does not show.
            let last_ns = crossing.enters_ns.saturating_add(stray_ns);
            let mut is_faulty = |t_ns| self.link.loses_by_fault(way, t_ns);
            is_unsure |= is_faulty(crossing.enters_ns) || is_faulty(last_ns);
            latest_ns = latest_ns.max(self.held_until_ns);
            let leaves_ns = crossing.leaves_ns.unwrap_or_default();
            self.held_until_ns = self.held_until_ns.max(leaves_ns);
        }
        Expected {
            direct,
            latest_ns,
            lossy,
            again_ns,
            is_unsure,
            may_stray,
        }
    }

    /// The latest time at which the receiver has read each message. Messages that arrive while it reads
    /// others wait, and it may take them in any order, so each may be the last of them.
    fn read_by_ns(&self, expected: &[Expected]) -> Vec<u64> {
        let mut read_by_ns: Vec<u64> = expected.iter().map(|one| one.latest_ns).collect();
        // `u64::MAX` stands for a queue of unknown length, about which nothing can be said.
        let known = read_by_ns.iter_mut().filter(|t_ns| **t_ns < u64::MAX);
        let mut known: Vec<&mut u64> = known.collect();
        let mut rest = known.as_mut_slice();
        while let Some(start_ns) = rest.first().map(|t_ns| **t_ns) {
            let until_ns = |count: usize| start_ns + count as u64 * self.read_ns;
            let is_more = |count: &usize| {
                rest.get(*count)
                    .is_some_and(|t_ns| **t_ns < until_ns(*count))
            };
            let more = (1..).take_while(is_more).count();
            let (together, later) = rest.split_at_mut(1 + more);
            for t_ns in together {
                **t_ns = (**t_ns).max(until_ns(more));
            }
            rest = later;
        }
        read_by_ns
    }

    fn add(
        &mut self,
        crossing: &Crossing,
        expected: &Expected,
        read_by_ns: u64,
        swamped: &Swamped,
    ) {
        let Expected {
            direct,
            latest_ns,
            lossy,
            again_ns,
            is_unsure,
            may_stray,
        } = *expected;
        let delay_ms = ms(direct.latest_ns.min(latest_ns)) - ms(crossing.enters_ns);
        let resent_ms = RESENT_MS + LATE_SHARE_OF_DELAY * delay_ms;
        let early_ms = ms(direct.earliest_ns) - ms(crossing.leaves_ns.unwrap_or(u64::MAX));
        let is_quicker = early_ms > QUICKER_MS + self.terms.allowance.clock_ms;
        let crossed = &mut self.crossed;
        crossed.quicker += u64::from(is_quicker);
        crossed.count += u64::from(crossing.leaves_ns.is_some());
        if is_unsure {
            return;
        }
        if self.terms.has_rate && delay_ms > RESEND_MS {
            // In such a long queue, handshakes and resends wait for each other: the queue alone
            // explains a late message.
            return;
        }
        // While the link stalls, a resend waits for the same end of the stall as what was lost.
        let would_show = again_ns.is_some_and(|again_ns| ms(again_ns) - ms(latest_ns) > resent_ms);
        if would_show {
            self.on_lossy(crossing.enters_ns, lossy);
        }
        let crossed = &mut self.crossed;
        let Some(leaves_ns) = crossing.leaves_ns else {
            crossed.lost += u64::from(would_show);
            return;
        };
        let still_ms = self.terms.still.between_ms(crossing.enters_ns, leaves_ns);
        let late_ms = ms(leaves_ns) - ms(read_by_ns) - self.own_ms - still_ms;
        let is_late = late_ms > LATE_MS + LATE_SHARE_OF_DELAY * delay_ms;
        let is_resent = late_ms > resent_ms;
        if lossy > 0.0 {
            crossed.lost += u64::from(would_show && is_resent);
            return;
        }
        if may_stray {
            return;
        }
        // While a link stalls and drains, hundreds of messages, handshakes and resends wait for each
        // other: how late one of them is says nothing.
        let is_swamped = ms(latest_ns) - ms(crossing.enters_ns) > STALL_MS
            || swamped.contains(crossing.enters_ns);
        if is_swamped {
            return;
        }
        crossed.late += u64::from(is_late);
        crossed.resent += u64::from(is_resent);
        if !crossing.opens {
            let baseline_ms = self.terms.baseline_ms[self.way as usize];
            self.excess_ms.push(-early_ms - baseline_ms);
        }
    }

    /// Counts a message that may be lost, and whose loss would show.
    fn on_lossy(&mut self, enters_ns: u64, lossy: f64) {
        self.crossed.lost_due += lossy;
        let stray_ns = ns(self.sender.strays_within_ms);
        if enters_ns > self.bunch.last_ns.saturating_add(stray_ns) {
            self.crossed.lost_variance += std::mem::take(&mut self.bunch).variance();
        }
        self.bunch.last_ns = enters_ns;
        self.bunch.count += 1.0;
        self.bunch.lost_due += lossy;
    }

    fn finish(mut self) -> Crossed {
        self.crossed.lost_variance += self.bunch.variance();
        self.crossed.lost_due = (self.crossed.lost_due * 1e3).round() / 1e3;
        self.crossed.with_excess(self.excess_ms)
    }
}

/// Messages that enter so close together that one slot of the link may lose all of them or none.
#[derive(Debug, Default)]
struct Bunch {
    last_ns: u64,
    count: f64,
    lost_due: f64,
}

impl Bunch {
    /// Upper bound on the variance of the number of its messages that are lost.
    fn variance(&self) -> f64 {
        self.count * self.lost_due
    }
}

/// The quantiles of fewer messages than this say nothing.
const ENOUGH: u64 = 20;

impl Crossed {
    /// Sets the quantiles of how much later than the link the messages were.
    fn with_excess(self, mut excess_ms: Vec<f64>) -> Crossed {
        excess_ms.sort_by(f64::total_cmp);
        let quantile = |q: f64| {
            let rank = (q * excess_ms.len() as f64) as usize;
            let found = excess_ms.get(rank.min(excess_ms.len().saturating_sub(1)));
            (found.copied().unwrap_or_default() * 1e3).round() / 1e3
        };
        Crossed {
            excess_p10_ms: quantile(FLOOR_QUANTILE),
            excess_p50_ms: quantile(0.5),
            excess_p99_ms: quantile(0.99),
            ..self
        }
    }

    pub(crate) fn judge(&self, way: Way, terms: &Terms, faults: &mut Vec<Fault>) {
        let floor_ms = terms.floor_ms(way);
        let mut find = |by_lateness, words| faults.push(Fault { words, by_lateness });
        let Self { count, .. } = *self;
        let quicker = QUICKER_PER_MILLE * count / 1_000;
        if self.quicker > quicker {
            find(
                false,
                format!(
                    "{} of {count} messages went {way} quicker than the link allows: they went \
                     around it (limit {quicker})",
                    self.quicker
                ),
            );
        }
        if count >= ENOUGH && self.excess_p10_ms > floor_ms {
            find(
                true,
                format!(
                    "nine of ten messages took {:.1} ms more than the link on the way {way}: \
                     something else delays them (limit {floor_ms:.1} ms)",
                    self.excess_p10_ms
                ),
            );
        }
        let resent = RESENT + RESENT_PER_MILLE * count / 1_000;
        let late = resent.max((terms.allowance.late_share * count as f64) as u64);
        if self.resent > resent {
            find(
                true,
                format!(
                    "{} of {count} messages were resent on the way {way}, but the link lost none \
                     of them (limit {resent})",
                    self.resent
                ),
            );
        } else if self.late > late {
            find(
                true,
                format!(
                    "{} of {count} messages were late on the way {way}, by more than {LATE_MS} ms \
                     plus a tenth, and no loss on the link explains it (limit {late})",
                    self.late
                ),
            );
        }
        let deviation = (self.lost_variance + self.lost as f64).sqrt();
        if (self.lost_due - self.lost as f64).abs() > 2.0 + RESENT_DEVIATIONS * deviation {
            find(
                self.lost as f64 > self.lost_due,
                format!(
                    "{} messages were lost on the way {way}; the link should have lost about {:.0}",
                    self.lost, self.lost_due
                ),
            );
        }
    }
}
