//! Every message of the loop, held against the link each way: never quicker than it, no later than
//! client, kernel and loss explain, and answered by the plant at its far side.
//!
//! A message's stamps are its client's and its plant's. Its first packet enters the link a little
//! after it is stamped, so what the link had in that window counts. Whoever opens a connection for a
//! message crosses the link three times. What is lost comes by a resend, at the earliest 200 ms later.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use endpoint::{ArrivalRow, MessageRow};
use link::{Timeline, Way};
use serde::{Deserialize, Serialize};

use crate::limit::{
    Allowance, DRAIN_MS, DRAIN_SHARE, FLOOR_AT_MOST, FLOOR_PER_COST, FLOOR_QUANTILE, LATE_MS,
    LATE_SHARE, LATE_SHARE_OF_DELAY, QUICKER_MS, QUICKER_PER_MILLE, RESEND_MS, RESENT,
    RESENT_DEVIATIONS, RESENT_MS, RESENT_PER_MILLE, STALL_LOOK_NS, STALL_MS,
};

/// The least IP length of a request or an answer, longer than an echo's. It matters where there is a
/// rate limit; what really entered is then known, and the message is taken to be the first of it.
const MESSAGE_BYTES: u32 = 90;
/// IP length of a handshake's packet.
const HANDSHAKE_BYTES: u32 = 60;

/// The link's state is looked at this often within a window: loss is decided by the millisecond.
const LOOK_NS: u64 = 250_000;

/// A connection is free again this long after the answer on it was had.
const FREED_NS: u64 = 1_000_000;

/// One that has idled for this long may have been closed: webloop's own clients do so after 5 s.
const IDLE_NS: u64 = 4_500_000_000;

/// What has to be known to judge messages.
#[derive(Debug)]
pub struct Terms {
    /// The link as it was to be.
    pub timeline: Timeline,
    /// The time of the run, monotonic ns: rows that a client stamped outside it are believed in nothing.
    pub run_ns: Range<u64>,
    /// How long a state of the link that has ended may still be met, ns, by how its player works.
    pub before_ns: u64,
    /// How far a falling delay may be off, ns, likewise.
    pub fall_ns: u64,
    /// What crossing the player itself costs up and down, ms.
    pub baseline_ms: [f64; 2],
    /// What the client is allowed.
    pub allowance: Allowance,
    /// Whether each message has a connection of its own.
    pub opens_always: bool,
    /// Whether the link has a rate limit.
    pub has_rate: bool,
    /// Whether all share one connection, on which what is lost holds up what follows.
    pub shares_one: bool,
    /// The sample time, ms: how many messages wait in a stall.
    pub h_ms: f64,
}

/// What the messages say of one way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
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

/// What the messages say of the link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Messages {
    /// From controller to plant.
    pub up: Crossed,
    /// From plant to controller.
    pub down: Crossed,
    /// Messages that were back sooner than the link lets them: one clock has both stamps.
    pub back_sooner: u64,
    /// Messages with a stamp outside the time of the run.
    pub outside: u64,
    /// Answers that the plant's own record of arrivals does not bear out.
    pub unborne: u64,
}

/// What is wrong with a link by its messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// A sentence, with its limit.
    pub words: String,
    /// Whether a machine that stood still could have done it: that makes messages late, and never
    /// quick.
    pub by_lateness: bool,
}

/// One message on one way.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    enters_ns: u64,
    /// `None` if it never came.
    leaves_ns: Option<u64>,
    /// Whether its client may have had to open a connection for it.
    opens: bool,
}

/// Holds the messages of a run against its link.
#[must_use]
pub fn hold(messages: &[MessageRow], arrivals: &[ArrivalRow], terms: &Terms) -> Messages {
    let is_inside = |row: &&MessageRow| {
        let stamps = [row.t_send_ns, row.t_arrive_ns, row.t_receive_ns];
        let mut stamps = stamps.into_iter().flatten();
        stamps.all(|t_ns| terms.run_ns.contains(&t_ns))
    };
    let all = messages.iter().filter(|row| row.t_send_ns.is_some());
    let (mut sent, outside): (Vec<&MessageRow>, Vec<&MessageRow>) = all.partition(is_inside);
    sent.sort_by_key(|row| row.seq);
    let mut first_arrival: BTreeMap<u64, u64> = BTreeMap::new();
    for row in arrivals
        .iter()
        .filter(|row| terms.run_ns.contains(&row.t_arrive_ns))
    {
        first_arrival.entry(row.seq).or_insert(row.t_arrive_ns);
    }
    let is_unborne = |row: &&&MessageRow| match (row.t_arrive_ns, first_arrival.get(&row.seq)) {
        (None, _) => false,
        (Some(own_ns), Some(plants_ns)) => plants_ns.abs_diff(own_ns) > 1_000,
        (Some(_), None) => true,
    };
    let unborne = sent.iter().filter(is_unborne).count() as u64;
    let opens = openings(&sent, terms);
    let up = sent.iter().zip(opens).filter_map(|(row, opens)| {
        Some(Crossing {
            enters_ns: row.t_send_ns?,
            leaves_ns: row
                .t_arrive_ns
                .or_else(|| first_arrival.get(&row.seq).copied()),
            opens,
        })
    });
    let up: Vec<Crossing> = up.collect();
    let mut down: Vec<Crossing> = sent
        .iter()
        .filter_map(|row| {
            Some(Crossing {
                enters_ns: row
                    .t_arrive_ns
                    .or_else(|| first_arrival.get(&row.seq).copied())?,
                leaves_ns: row.t_receive_ns,
                opens: false,
            })
        })
        .collect();
    down.sort_by_key(|crossing| crossing.enters_ns);
    let swamped = Swamped::of(terms);
    Messages {
        up: cross(Way::Up, &up, terms, &swamped),
        down: cross(Way::Down, &down, terms, &swamped),
        back_sooner: back_sooner(&sent, terms),
        outside: outside.len() as u64,
        unborne,
    }
}

/// Of each message whether a connection may have been opened for it: none was free that had been used
/// not long ago. Clients take the one that was used last; one that is freed goes first to a message
/// that waits for one.
fn openings(sent: &[&MessageRow], terms: &Terms) -> Vec<bool> {
    let mut link = terms.timeline.clone();
    let mut ends: Vec<u64> = sent.iter().filter_map(|row| row.t_receive_ns).collect();
    ends.sort_unstable();
    let mut ends = ends.into_iter().map(|t_ns| t_ns + FREED_NS).peekable();
    // Those that are free, since when, the one used last at the end. One is opened beforehand.
    let mut free = vec![u64::MAX];
    // Until when each message that found none waits at the longest: its own is open by then.
    let mut waiting: VecDeque<u64> = VecDeque::new();
    let is_opened = |row: &&MessageRow| {
        let send_ns = row.t_send_ns.unwrap_or_default();
        while let Some(freed_ns) = ends.next_if(|freed_ns| *freed_ns <= send_ns) {
            while waiting
                .front()
                .is_some_and(|until_ns| *until_ns <= freed_ns)
            {
                waiting.pop_front();
            }
            if waiting.pop_front().is_none() {
                free.push(freed_ns);
            }
        }
        let found = free.pop();
        let is_free = found.is_some_and(|since_ns| send_ns.saturating_sub(since_ns) < IDLE_NS);
        if !is_free {
            // Those below it have idled for longer.
            free.clear();
            let delay_ns = link.passage(Way::Up, send_ns, MESSAGE_BYTES).delay_ns;
            waiting.push_back(
                row.t_arrive_ns
                    .map_or(u64::MAX, |t_ns| t_ns - delay_ns.min(t_ns)),
            );
        }
        !terms.shares_one && (!is_free || terms.opens_always)
    };
    sent.iter().map(is_opened).collect()
}

/// How many messages were back sooner than the link lets them.
fn back_sooner(sent: &[&MessageRow], terms: &Terms) -> u64 {
    let mut link = terms.timeline.clone();
    let within_ns = ns(terms.allowance.enters_within_ms);
    let is_sooner = |row: &&&MessageRow| {
        let (Some(send_ns), Some(receive_ns)) = (row.t_send_ns, row.t_receive_ns) else {
            return false;
        };
        let up = terms.window(&mut link, Way::Up, send_ns, within_ns, MESSAGE_BYTES);
        let wait_ns = within_ns.max(receive_ns.saturating_sub(up.earliest_ns));
        let down = terms.window(&mut link, Way::Down, up.earliest_ns, wait_ns, MESSAGE_BYTES);
        ms(down.earliest_ns) - ms(receive_ns) > QUICKER_MS
    };
    sent.iter().filter(is_sooner).count() as u64
}

/// When what enters in a window leaves, and how likely it is lost.
#[derive(Debug, Clone, Copy)]
struct Window {
    earliest_ns: u64,
    latest_ns: u64,
    lossy: f64,
}

impl Terms {
    /// What nine of ten messages may take on a way beyond the link, on this machine.
    fn floor_ms(&self, way: Way) -> f64 {
        let usual_ms = match way {
            Way::Up => self.allowance.up_floor_ms,
            Way::Down => self.allowance.down_floor_ms,
        };
        let cost_ms = self.baseline_ms[way as usize].max(0.0);
        (usual_ms + FLOOR_PER_COST * cost_ms).min(FLOOR_AT_MOST * usual_ms)
    }

    /// What enters a way within `within_ns` after `t_ns`; it is of `bytes`, or longer by what entered.
    fn window(
        &self,
        link: &mut Timeline,
        way: Way,
        t_ns: u64,
        within_ns: u64,
        bytes: u32,
    ) -> Window {
        let bytes = match bytes {
            MESSAGE_BYTES => link.bytes_entered(way, t_ns, within_ns, bytes),
            _ => None,
        }
        .unwrap_or(bytes);
        let (mut earliest_ns, mut latest_ns, mut looks, mut lossy) = (u64::MAX, 0, 0_u32, 0_u32);
        // A window that is wide is looked at as often as a narrow one needs.
        let step_ns = LOOK_NS.max(within_ns / 16);
        let mut look_ns = t_ns.saturating_sub(self.before_ns);
        let last_ns = t_ns.saturating_add(within_ns);
        while look_ns <= last_ns {
            let passage = link.passage(way, look_ns, bytes);
            let leaves_ns = look_ns.max(t_ns).saturating_add(passage.delay_ns);
            earliest_ns = earliest_ns.min(leaves_ns);
            latest_ns = latest_ns.max(match passage.queued {
                // It is not known how long the queue was.
                true => u64::MAX,
                false => leaves_ns,
            });
            looks += 1;
            lossy += u32::from(passage.lost);
            look_ns = look_ns.saturating_add(step_ns);
            if look_ns == u64::MAX {
                break;
            }
        }
        Window {
            earliest_ns: earliest_ns.saturating_sub(self.fall_ns),
            latest_ns: latest_ns.saturating_add(self.fall_ns),
            lossy: f64::from(lossy) / f64::from(looks.max(1)),
        }
    }

    /// The latest that a message leaves the way up for which a connection is opened: its handshake
    /// crosses the link both ways before.
    fn opened(&self, link: &mut Timeline, t_ns: u64, within_ns: u64) -> Window {
        let syn = self.window(link, Way::Up, t_ns, within_ns, HANDSHAKE_BYTES);
        if syn.latest_ns == u64::MAX {
            // Of a queue that nobody knows nothing is late.
            return syn;
        }
        let back = self.window(link, Way::Down, syn.latest_ns, LOOK_NS, HANDSHAKE_BYTES);
        if back.latest_ns == u64::MAX {
            return back;
        }
        let up = self.window(link, Way::Up, back.latest_ns, within_ns, MESSAGE_BYTES);
        let kept = (1.0 - syn.lossy) * (1.0 - back.lossy) * (1.0 - up.lossy);
        Window {
            lossy: 1.0 - kept,
            ..up
        }
    }
}

/// When the link stalls, and programs are busy with what it then lets go of.
#[derive(Debug)]
pub(crate) struct Swamped(Vec<Range<u64>>);

impl Swamped {
    /// Of a run's link.
    pub(crate) fn of(terms: &Terms) -> Swamped {
        let mut link = terms.timeline.clone();
        // A message each h waits, and the client has each of them to read.
        let share = DRAIN_SHARE + terms.allowance.message_ms / terms.h_ms;
        let mut found: Vec<Range<u64>> = Vec::new();
        let mut look_ns = terms.run_ns.start;
        while look_ns < terms.run_ns.end {
            let mut delay_ns = |way| link.passage(way, look_ns, MESSAGE_BYTES).delay_ns;
            let delay_ns = delay_ns(Way::Up).max(delay_ns(Way::Down));
            if delay_ns > ns(STALL_MS) {
                let drain_ms = DRAIN_MS + share * ms(delay_ns);
                let until_ns = look_ns + delay_ns + ns(drain_ms);
                match found.last_mut() {
                    Some(last) if last.end >= look_ns => last.end = last.end.max(until_ns),
                    _ => found.push(look_ns..until_ns),
                }
            }
            look_ns += STALL_LOOK_NS;
        }
        Swamped(found)
    }

    /// Whether an instant is in one of these times.
    pub(crate) fn contains(&self, t_ns: u64) -> bool {
        let at = self.0.partition_point(|time| time.end <= t_ns);
        self.0.get(at).is_some_and(|time| time.contains(&t_ns))
    }
}

/// Holds the crossings of one way, in order of entry, against it.
fn cross(way: Way, crossings: &[Crossing], terms: &Terms, swamped: &Swamped) -> Crossed {
    // A link is asked in order of time: each way has its own.
    let mut link = terms.timeline.clone();
    let baseline_ms = terms.baseline_ms[way as usize];
    // The plant is webloop's own, whoever its client is.
    let sender = match way {
        Way::Up => terms.allowance,
        Way::Down => Allowance::of(plan::Client::Native),
    };
    let slack_ms = match way {
        Way::Up => 0.0,
        Way::Down => terms.allowance.enters_within_ms,
    };
    let within_ns = ns(sender.enters_within_ms);
    let stray_ns = ns(sender.strays_within_ms);
    let quicker_ms = QUICKER_MS + terms.allowance.clock_ms;
    let mut crossed = Crossed::default();
    let mut excess_ms = Vec::with_capacity(crossings.len());
    // On a shared connection nothing leaves before what was sent before it.
    let mut held_until_ns = 0;
    let mut bunch = Bunch::default();
    for crossing in crossings {
        let direct = terms.window(&mut link, way, crossing.enters_ns, within_ns, MESSAGE_BYTES);
        let stray = terms.window(&mut link, way, crossing.enters_ns, stray_ns, MESSAGE_BYTES);
        let (mut latest_ns, mut lossy) = (direct.latest_ns, stray.lossy);
        if crossing.opens {
            let opened = terms.opened(&mut link, crossing.enters_ns, within_ns);
            latest_ns = latest_ns.max(opened.latest_ns);
            lossy = lossy.max(opened.lossy);
        }
        if terms.shares_one {
            latest_ns = latest_ns.max(held_until_ns);
        }
        let delay_ms = ms(direct.latest_ns.min(latest_ns)) - ms(crossing.enters_ns);
        let resent_ms = RESENT_MS + LATE_SHARE_OF_DELAY * delay_ms;
        let early_ms = ms(direct.earliest_ns) - ms(crossing.leaves_ns.unwrap_or(u64::MAX));
        if terms.has_rate && delay_ms > RESEND_MS {
            // In a queue that long handshakes and resends wait for each other: what is late is its own
            // doing.
            crossed.count += u64::from(crossing.leaves_ns.is_some());
            crossed.quicker += u64::from(early_ms > quicker_ms);
            continue;
        }
        // While the link stalls a resend waits for the same end as what was lost: nobody sees it. Nor
        // does a handshake say at which of its crossings the loss was.
        let would_show = lossy > 0.0 && !crossing.opens && {
            let again_ns = crossing.enters_ns + ns(RESEND_MS);
            let again = terms.window(&mut link, way, again_ns, within_ns, MESSAGE_BYTES);
            ms(again.earliest_ns) - ms(latest_ns) > resent_ms
        };
        if would_show {
            crossed.lost_due += lossy;
            if crossing.enters_ns > bunch.last_ns.saturating_add(stray_ns) {
                crossed.lost_variance += std::mem::take(&mut bunch).variance();
            }
            bunch.last_ns = crossing.enters_ns;
            bunch.count += 1.0;
            bunch.lost_due += lossy;
        }
        let Some(leaves_ns) = crossing.leaves_ns else {
            crossed.lost += u64::from(would_show);
            continue;
        };
        held_until_ns = held_until_ns.max(leaves_ns);
        crossed.count += 1;
        crossed.quicker += u64::from(early_ms > quicker_ms);
        let late_ms = ms(leaves_ns) - ms(latest_ns) - baseline_ms - slack_ms;
        let is_late = late_ms > LATE_MS + LATE_SHARE_OF_DELAY * delay_ms;
        let is_resent = late_ms > resent_ms;
        if lossy > 0.0 {
            crossed.lost += u64::from(would_show && is_resent);
        } else {
            // While a link stalls, and drains, hundreds of messages, handshakes and resends wait for each
            // other: how late one of them is says nothing.
            let is_swamped = ms(latest_ns) - ms(crossing.enters_ns) > STALL_MS
                || swamped.contains(crossing.enters_ns);
            crossed.late += u64::from(is_late && !is_swamped);
            crossed.resent += u64::from(is_resent && !is_swamped);
            if !crossing.opens && !is_swamped {
                excess_ms.push(-early_ms - baseline_ms);
            }
        }
    }
    crossed.lost_variance += bunch.variance();
    crossed.lost_due = (crossed.lost_due * 1e3).round() / 1e3;
    crossed.with_excess(excess_ms)
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

impl Messages {
    /// What speaks against the link; nothing if it was the one asked for.
    #[must_use]
    pub fn faults(&self, terms: &Terms) -> Vec<Fault> {
        let mut faults = Vec::new();
        for (way, crossed) in [(Way::Up, &self.up), (Way::Down, &self.down)] {
            crossed.judge(way, terms.floor_ms(way), &mut faults);
        }
        let answered = self.down.count;
        let sooner = QUICKER_PER_MILLE * answered / 1_000;
        if self.back_sooner > sooner {
            faults.push(Fault {
                words: format!(
                    "{} of {answered} messages were back quicker than the link lets them: they went \
                     around it (at most {sooner} may)",
                    self.back_sooner
                ),
                by_lateness: false,
            });
        }
        if self.outside > 0 {
            faults.push(Fault {
                words: format!(
                    "{} messages have stamps outside the time of the run: their client's clock is another",
                    self.outside
                ),
                by_lateness: false,
            });
        }
        if self.unborne > 0 {
            faults.push(Fault {
                words: format!(
                    "{} answers name an arrival that the plant has not recorded: they did not come \
                     from it",
                    self.unborne
                ),
                by_lateness: false,
            });
        }
        faults
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

    fn judge(&self, way: Way, floor_ms: f64, faults: &mut Vec<Fault>) {
        let mut find = |by_lateness, words| faults.push(Fault { words, by_lateness });
        let Self { count, .. } = *self;
        let quicker = QUICKER_PER_MILLE * count / 1_000;
        if self.quicker > quicker {
            find(
                false,
                format!(
                    "{} of {count} messages crossed the way {way} quicker than the link lets them: \
                     they went around it (at most {quicker} may)",
                    self.quicker
                ),
            );
        }
        if count >= ENOUGH && self.excess_p10_ms > floor_ms {
            find(
                true,
                format!(
                    "nine of ten messages took {:.1} ms more than the link on the way {way}: \
                     something beside it delays them (limit {floor_ms:.1} ms)",
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
                    "{} of {count} messages were resent on the way {way} though the link lost none of \
                     them (at most {resent} may)",
                    self.resent
                ),
            );
        } else if self.late > late {
            find(
                true,
                format!(
                    "{} of {count} messages were late on the way {way}, by more than {LATE_MS} ms and a \
                     tenth, and no loss of the link explains it (at most {late} may)",
                    self.late
                ),
            );
        }
        let deviation = (self.lost_variance + self.lost as f64).sqrt();
        if (self.lost_due - self.lost as f64).abs() > 2.0 + RESENT_DEVIATIONS * deviation {
            find(
                self.lost as f64 > self.lost_due,
                format!(
                    "{} messages were lost on the way {way} where the link was to lose some {:.0}",
                    self.lost, self.lost_due
                ),
            );
        }
    }
}

fn ms(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

fn ns(ms: f64) -> u64 {
    (ms * 1e6) as u64
}
