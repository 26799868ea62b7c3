//! The messages of one way, held against the link as it was to be.

use link::{Timeline, Way};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::limit::{
    Allowance, FLOOR_QUANTILE, LATE_MS, LATE_SHARE, LATE_SHARE_OF_DELAY, QUICKER_MS,
    QUICKER_PER_MILLE, READING_SHARE, RESEND_MS, RESENT, RESENT_DEVIATIONS, RESENT_MS,
    RESENT_PER_MILLE, STALL_MS,
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
    /// `None` if it never came.
    pub(crate) leaves_ns: Option<u64>,
    /// Whether its client may have had to open a connection for it.
    pub(crate) opens: bool,
}

/// Holds the crossings of one way, in order of entry, against it.
pub(crate) fn cross(way: Way, crossings: &[Crossing], terms: &Terms, swamped: &Swamped) -> Crossed {
    let mut held = Held::new(way, terms);
    let expected: Vec<Expected> = crossings.iter().map(|one| held.expect(one)).collect();
    let read_by_ns = held.read_by_ns(&expected);
    for ((crossing, expected), read_by_ns) in crossings.iter().zip(&expected).zip(read_by_ns) {
        held.add(crossing, expected, read_by_ns, swamped);
    }
    held.finish()
}

/// What is known of one way so far.
struct Held<'a> {
    way: Way,
    terms: &'a Terms,
    /// A link is asked in order of time: each way has its own.
    link: Timeline,
    sender: Allowance,
    /// What the sender's stamp and the receiver's may differ by of themselves, ms.
    own_ms: f64,
    /// What the receiver takes over a message.
    read_ns: u64,
    /// On a shared connection nothing leaves before what was sent before it.
    held_until_ns: u64,
    crossed: Crossed,
    excess_ms: Vec<f64>,
    bunch: Bunch,
}

/// What the link lets a message do.
struct Expected {
    /// When it leaves, if it needs no connection and waits for nobody.
    direct: Window,
    /// When it leaves at the latest.
    latest_ns: u64,
    /// How likely it is lost.
    lossy: f64,
}

impl<'a> Held<'a> {
    fn new(way: Way, terms: &'a Terms) -> Held<'a> {
        // The plant is webloop's own, whoever its client is.
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
        let (direct, stray) = (window(within_ns), window(stray_ns));
        let (mut latest_ns, mut lossy) = (direct.latest_ns, stray.lossy);
        if crossing.opens {
            let opened = terms.opened(&mut self.link, crossing.enters_ns, within_ns);
            latest_ns = latest_ns.max(opened.latest_ns);
            lossy = lossy.max(opened.lossy);
        }
        if terms.shares_one {
            latest_ns = latest_ns.max(self.held_until_ns);
            let leaves_ns = crossing.leaves_ns.unwrap_or_default();
            self.held_until_ns = self.held_until_ns.max(leaves_ns);
        }
        Expected {
            direct,
            latest_ns,
            lossy,
        }
    }

    /// When the receiver has read each message at the latest. Those that come while it reads others
    /// wait, and it takes them in any order: each may be the last of them.
    fn read_by_ns(&self, expected: &[Expected]) -> Vec<u64> {
        let mut read_by_ns: Vec<u64> = expected.iter().map(|one| one.latest_ns).collect();
        // Nothing is known of a queue whose length is not.
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
        } = *expected;
        let delay_ms = ms(direct.latest_ns.min(latest_ns)) - ms(crossing.enters_ns);
        let resent_ms = RESENT_MS + LATE_SHARE_OF_DELAY * delay_ms;
        let early_ms = ms(direct.earliest_ns) - ms(crossing.leaves_ns.unwrap_or(u64::MAX));
        let is_quicker = early_ms > QUICKER_MS + self.terms.allowance.clock_ms;
        let crossed = &mut self.crossed;
        crossed.quicker += u64::from(is_quicker);
        crossed.count += u64::from(crossing.leaves_ns.is_some());
        if self.terms.has_rate && delay_ms > RESEND_MS {
            // In a queue that long handshakes and resends wait for each other: what is late is its own
            // doing.
            return;
        }
        let would_show = lossy > 0.0 && self.would_show(crossing, latest_ns, resent_ms);
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
        // While a link stalls, and drains, hundreds of messages, handshakes and resends wait for each
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

    /// Whether one sees it if this message is lost. While the link stalls a resend waits for the same end
    /// as what was lost: nobody sees it. Nor does a handshake say at which of its crossings the loss was.
    fn would_show(&mut self, crossing: &Crossing, latest_ns: u64, resent_ms: f64) -> bool {
        let Held { way, terms, .. } = *self;
        let within_ns = ns(self.sender.enters_within_ms);
        let again_ns = crossing.enters_ns + ns(RESEND_MS);
        let mut again = || terms.window(&mut self.link, way, again_ns, within_ns, MESSAGE_BYTES);
        !crossing.opens && ms(again().earliest_ns) - ms(latest_ns) > resent_ms
    }

    /// A message may be lost, and it would show.
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

/// Messages that enter so near each other that one slot of the link may lose all of them or none.
#[derive(Debug, Default)]
struct Bunch {
    last_ns: u64,
    count: f64,
    lost_due: f64,
}

impl Bunch {
    /// Of what is lost of it, at most.
    fn variance(&self) -> f64 {
        self.count * self.lost_due
    }
}

/// Fewer messages than these say nothing by their quantiles.
const ENOUGH: u64 = 20;

impl Crossed {
    /// With the quantiles of how much later than the link messages were.
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

    pub(crate) fn judge(&self, way: Way, floor_ms: f64, faults: &mut Vec<Fault>) {
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
        let late = resent.max((LATE_SHARE * count as f64) as u64);
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
