//! Compares the messages of one way with the link that was asked for.

use std::ops::Range;

use link::{Timeline, Way};
use plan::evidence::Crossed;

use crate::connecting::{Connecting, Opened};
use crate::crossed::with_lateness;
use crate::flight::Flight;
use crate::lateness::{Lateness, Untold, told};
use crate::limit::{
    Allowance, LATE_MS, LATE_SHARE_OF_DELAY, QUICKER_MS, READING_SHARE, RESEND_MS, RESENT_MS,
    STALL_MS,
};
use crate::milliseconds::{ms, ns};
use crate::quantile::thousandths;
use crate::terms::{MESSAGE_BYTES, Swamped, Terms, Window};

/// How often a message crosses the link that opens its connection.
const HANDSHAKE_CROSSINGS: f64 = 3.0;

/// One connection for so many messages is often.
const OFTEN: usize = 10;

/// One message on one way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    pub(crate) enters_ns: u64,
    /// `None` if it never arrived.
    pub(crate) leaves_ns: Option<u64>,
    /// Whether its client opened a connection for it.
    pub(crate) opened: Opened,
    /// When who receives it does not take it any more, if that is ever.
    pub(crate) given_up_ns: Option<u64>,
    /// Whether a fault of the link may have broken its connection, or one of an end held it up: then it may be sent
    /// again at any time, or never, and how late it is says nothing.
    pub(crate) is_unsure: bool,
}

impl Crossing {
    /// When its first packet enters, if it does so many ns after its stamp at the latest.
    fn enters_within(&self, ns: u64) -> Range<u64> {
        self.enters_ns..self.enters_ns.saturating_add(ns)
    }

    /// Whether the link stalls, if it leaves at `latest_ns`.
    fn is_stalled(&self, latest_ns: u64) -> bool {
        ms(latest_ns) - ms(self.enters_ns) > STALL_MS
    }
}

/// Compares the crossings of one way, in order of entry, with the link.
pub(crate) fn cross(way: Way, crossings: &[Crossing], terms: &Terms, swamped: &Swamped) -> Crossed {
    let mut held = Held::new(way, terms, crossings.len());
    let mut expected: Vec<Expected> = crossings.iter().map(|one| held.expect(one)).collect();
    held.read(&mut expected);
    for (crossing, expected) in crossings.iter().zip(&expected) {
        held.add(crossing, expected, swamped);
    }
    held.finish()
}

/// The state of the comparison of one way.
struct Held<'a> {
    way: Way,
    terms: &'a Terms,
    /// Each way has its own: a timeline forgets what lies far behind its newest query.
    link: Timeline,
    /// Whether it may lose a message: else it is not asked where one may stray to, which tells nothing but that.
    may_lose: bool,
    sender: Allowance,
    /// Time that the client may take to read a message of the way down, or between its stamp and its sending, ms.
    slack_ms: f64,
    /// Time that the receiver needs to read a message.
    read_ns: u64,
    /// On a shared connection no message leaves before those sent earlier.
    held_until_ns: u64,
    /// Whether messages may share a connection.
    may_share: bool,
    /// What is under way on it, if they do.
    flight: Option<Flight>,
    /// Whether more than a tenth of the messages may have opened connections although their rows do not tell.
    opens_often: bool,
    crossed: Crossed,
    known: Vec<Lateness>,
    untold: Vec<Untold>,
    bunch: Bunch,
}

/// What the link should do to a message.
struct Expected {
    /// When it leaves, if it needs no new connection and waits for no other message.
    direct: Window,
    /// When it leaves if a connection is opened for it, if one may be, and the probability that it or its handshake
    /// is lost.
    opened: Option<Window>,
    /// The latest time at which it leaves; if it is untold, with a connection.
    latest_ns: u64,
    /// The latest time at which its receiver has read it.
    read_by_ns: u64,
    /// The probability that it is lost; if it is untold, with a connection.
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
    fn new(way: Way, terms: &'a Terms, count: usize) -> Held<'a> {
        // The plant is webloop's own, whatever the client.
        let plant = plan::Client::Native.spec().allowance;
        let client = terms.allowance;
        let (sender, receiver, slack_ms) = match way {
            Way::Up => (client, plant, terms.work_ms(count as u64)),
            Way::Down => (plant, client, client.enters_within_ms),
        };
        Held {
            way,
            terms,
            link: terms.timeline.clone(),
            may_lose: terms.timeline.may_lose(way),
            sender,
            slack_ms,
            read_ns: ns(receiver.message_ms.min(READING_SHARE * terms.h_ms)),
            held_until_ns: 0,
            may_share: matches!(
                terms.connecting,
                Connecting::Shared | Connecting::Own { .. }
            ),
            flight: (terms.connecting.is_stream(count)).then(|| Flight::new(way, terms)),
            opens_often: OFTEN * terms.connecting.most_untold(count) > count,
            crossed: Crossed::default(),
            known: Vec::new(),
            untold: Vec::new(),
            bunch: Bunch::default(),
        }
    }

    fn expect(&mut self, crossing: &Crossing) -> Expected {
        let (direct, strays) = self.direct(crossing);
        let opened = self.opened(crossing, &direct, strays);
        // If it is untold, how much its loss shows is known of nearly all, unless most of them opened one.
        let is_open = match crossing.opened {
            Opened::No => false,
            Opened::Perhaps | Opened::Yes => true,
            Opened::Untold => self.opens_often,
        };
        let (mut latest_ns, mut lossy) = (direct.latest_ns, strays);
        if let Some(opened) = opened.filter(|_| !self.is_either(crossing)) {
            (latest_ns, lossy) = (opened.latest_ns, opened.lossy);
        }
        let may_stray = !is_open && self.may_stray(crossing);
        // Asked here, where the link is asked for this time anyway: it has forgotten it later.
        let again_ns = (lossy > 0.0 && !is_open).then(|| {
            let again_ns = crossing.enters_ns + ns(RESEND_MS);
            let until_ns = again_ns.saturating_add(ns(self.sender.enters_within_ms));
            self.window(again_ns..until_ns).earliest_ns
        });
        latest_ns = latest_ns.max(self.held_back_ns(crossing));
        if self.may_share {
            latest_ns = latest_ns.max(self.held_until_ns);
            // A program's messages wait for each other only if they share a connection. Nobody knows whether they
            // do: it excuses none but those behind one that may have been lost.
            let holds = self.terms.connecting == Connecting::Shared || lossy > 0.0;
            let leaves_ns = crossing.leaves_ns.filter(|_| holds).unwrap_or_default();
            self.held_until_ns = self.held_until_ns.max(leaves_ns);
        }
        Expected {
            direct,
            opened,
            latest_ns,
            read_by_ns: latest_ns,
            lossy,
            again_ns,
            is_unsure: self.is_faulty(crossing) || crossing.is_unsure,
            may_stray,
        }
    }

    /// When a message leaves at the latest that its stream holds back; 0 if none does.
    fn held_back_ns(&mut self, crossing: &Crossing) -> u64 {
        let Some(flight) = &mut self.flight else {
            return 0;
        };
        let (enters_ns, leaves_ns) = (crossing.enters_ns, crossing.leaves_ns);
        match flight.waits_until_ns(enters_ns, leaves_ns, self.terms) {
            0 => 0,
            until_ns => {
                let until_ns = until_ns..until_ns + ns(self.sender.enters_within_ms);
                self.window(until_ns).latest_ns
            }
        }
    }

    /// What the link does to a message that needs no new connection, and the probability that it is lost, wherever it
    /// strays to.
    fn direct(&mut self, crossing: &Crossing) -> (Window, f64) {
        let stray_ns = ns(self.sender.strays_within_ms);
        let mut direct = self.window(crossing.enters_within(ns(self.sender.enters_within_ms)));
        let strays = match self.may_lose {
            true => self.window(crossing.enters_within(stray_ns)).lossy,
            false => 0.0,
        };
        if strays >= 1.0 {
            let (terms, link) = (self.terms, &mut self.link);
            let again_ns = terms.carries_again_ns(link, self.way, crossing.enters_ns, stray_ns);
            direct.earliest_ns = direct.earliest_ns.max(again_ns);
        }
        if let Some(leaves_ns) = crossing.leaves_ns.filter(|t_ns| *t_ns < direct.earliest_ns) {
            // Held for longer than is usual between its stamp and its sending, it met a later state of the link.
            let held = self.window(crossing.enters_ns..leaves_ns.max(crossing.enters_ns));
            if held.lossy < 1.0 {
                direct.earliest_ns = direct.earliest_ns.min(held.earliest_ns);
            }
        }
        (direct, strays)
    }

    /// What the link does to a message for which a connection is opened, if one may be: it is no earlier, and no less
    /// likely lost, than without.
    fn opened(&mut self, crossing: &Crossing, direct: &Window, strays: f64) -> Option<Window> {
        let (enters_ns, within_ns) = (crossing.enters_ns, ns(self.sender.enters_within_ms));
        (crossing.opened != Opened::No).then(|| {
            let link = &mut self.link;
            let opened = self.terms.opened(link, enters_ns, within_ns);
            let opened_strays = self.terms.opened_lossy(link, enters_ns, within_ns);
            Window {
                lossy: strays.max(opened.lossy).max(opened_strays),
                latest_ns: direct.latest_ns.max(opened.latest_ns),
                ..opened
            }
        })
    }

    /// Whether a message that opens no connection may have waited for one until the link lost it.
    fn may_stray(&mut self, crossing: &Crossing) -> bool {
        let enters_ns = crossing.enters_ns;
        // Where a fault loses many packets, which connection is free when is not known so exactly: any message
        // may have waited for one for as long as a handshake takes.
        if self.way != Way::Up
            || !self.terms.connecting.resends()
            || !self.link.loses_by_fault(self.way, enters_ns)
        {
            return false;
        }
        let within_ns = ns(self.sender.enters_within_ms);
        let opened = self.terms.opened(&mut self.link, enters_ns, within_ns);
        let wait_ns = opened.latest_ns.saturating_sub(enters_ns);
        let waited = self.window(crossing.enters_within(wait_ns.min(ns(RESEND_MS))));
        waited.lossy > 0.0
    }

    /// Whether a fault of the link may have lost packets of a connection that all messages share.
    fn is_faulty(&mut self, crossing: &Crossing) -> bool {
        if self.terms.connecting != Connecting::Shared {
            return false;
        }
        // Behind a lost packet others follow on the same connection, so that it is sent again a round
        // trip later: where a fault loses many, how many were lost does not show.
        let entry = crossing.enters_within(ns(self.sender.strays_within_ms));
        let mut is_faulty = |t_ns| self.link.loses_by_fault(self.way, t_ns);
        is_faulty(entry.start) || is_faulty(entry.end)
    }

    /// What the link does to a message that enters this way between two instants.
    fn window(&mut self, enters: Range<u64>) -> Window {
        let (link, within_ns) = (&mut self.link, enters.end - enters.start);
        self.terms
            .window(link, self.way, enters.start, within_ns, MESSAGE_BYTES)
    }

    /// Whether a message is judged both as one that had a connection and as one that opened it.
    fn is_either(&self, crossing: &Crossing) -> bool {
        match crossing.opened {
            Opened::No | Opened::Yes => false,
            Opened::Perhaps => self.terms.connecting.is_counted(),
            Opened::Untold => true,
        }
    }

    /// Finds the latest time at which the receiver has read each message. Messages that arrive while it reads
    /// others wait, and it may take them in any order, so each may be the last of them.
    fn read(&self, expected: &mut [Expected]) {
        let all = expected.iter_mut().map(|one| &mut one.read_by_ns);
        // `u64::MAX` stands for a queue of unknown length, about which nothing can be said.
        let known = all.filter(|t_ns| **t_ns < u64::MAX);
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
    }

    fn add(&mut self, crossing: &Crossing, expected: &Expected, swamped: &Swamped) {
        let (direct, latest_ns, lossy) = (expected.direct, expected.latest_ns, expected.lossy);
        let delay_ms = ms(direct.latest_ns.min(latest_ns)) - ms(crossing.enters_ns);
        let resent_ms = RESENT_MS + LATE_SHARE_OF_DELAY * delay_ms;
        let early_ms = ms(direct.earliest_ns) - ms(crossing.leaves_ns.unwrap_or(u64::MAX));
        let is_quicker = early_ms > QUICKER_MS + self.terms.allowance.clock_ms;
        self.crossed.quicker += u64::from(is_quicker);
        self.crossed.count += u64::from(crossing.leaves_ns.is_some());
        if expected.is_unsure {
            return;
        }
        if self.terms.has_rate && delay_ms > RESEND_MS {
            // In such a long queue, handshakes and resends wait for each other: the queue alone
            // explains a late message.
            return;
        }
        // While the link stalls, a resend waits for the same end of the stall as what was lost.
        let shows = |again_ns| ms(again_ns) - ms(latest_ns) > resent_ms;
        // What is not sent again never comes, and that shows if it would have been taken.
        let resends = self.terms.connecting.resends();
        let would_show = match resends {
            true => expected.again_ns.is_some_and(shows),
            false => crossing
                .given_up_ns
                .is_none_or(|t_ns| ms(expected.read_by_ns) + self.slack_ms + LATE_MS < ms(t_ns)),
        };
        if would_show {
            self.on_lossy(crossing.enters_ns, lossy);
        }
        let until_ns = [latest_ns, expected.read_by_ns];
        let Some(kept) = self.lateness(crossing, &direct, until_ns, 1.0) else {
            self.crossed.lost += u64::from(would_show);
            return;
        };
        if lossy > 0.0 && resends {
            self.crossed.lost += u64::from(would_show && kept.is_resent);
            return;
        }
        // While a link stalls and drains, hundreds of messages, handshakes and resends wait for each
        // other: how late one of them is says nothing.
        let is_swamped = crossing.is_stalled(latest_ns) || swamped.contains(crossing.enters_ns);
        if !expected.may_stray && !is_swamped {
            self.add_lateness(crossing, expected, kept);
        }
    }

    /// Counts how late a message was, or keeps it until that is told of all: `kept`, if it had a connection.
    fn add_lateness(&mut self, crossing: &Crossing, expected: &Expected, kept: Lateness) {
        let (latest_ns, read_by_ns) = (expected.latest_ns, expected.read_by_ns);
        let by_opened = |opened: Window| {
            let until_ns = [opened.latest_ns, read_by_ns.max(opened.latest_ns)];
            self.lateness(crossing, &opened, until_ns, HANDSHAKE_CROSSINGS)
        };
        // Of a bunch that its reader takes in any order, nobody knows how long each waited.
        let is_of_bunch = read_by_ns.saturating_sub(latest_ns) > 2 * self.read_ns;
        match (crossing.opened, expected.opened) {
            (Opened::No, _) if is_of_bunch => self.count_late(&kept),
            (Opened::Yes, Some(opened)) => self.known.extend(by_opened(opened)),
            (Opened::Untold | Opened::Perhaps, Some(opened)) if self.is_either(crossing) => {
                let is_told = opened.lossy == 0.0 && !crossing.is_stalled(opened.latest_ns);
                let opened = is_told.then(|| by_opened(opened)).flatten();
                let kept = Some(kept);
                self.untold.push(Untold { kept, opened });
            }
            // Late it may be, but by how much of a handshake is not known.
            (Opened::Perhaps, _) => self.count_late(&kept),
            _ => self.known.push(kept),
        }
    }

    /// How late a message was, having crossed the player so often, where the link has it leave in a window, at the
    /// latest at the first of these times, and its reader has read it by the second; `None` if it never arrived.
    fn lateness(
        &self,
        crossing: &Crossing,
        link: &Window,
        [latest_ns, read_by_ns]: [u64; 2],
        crossings: f64,
    ) -> Option<Lateness> {
        let (enters_ns, leaves_ns) = (crossing.enters_ns, crossing.leaves_ns?);
        let still_ms = self.terms.still.between_ms(enters_ns, leaves_ns);
        let own_ms = crossings * self.terms.baseline_ms[self.way as usize] + still_ms;
        // It may have waited for its connection or its reader.
        let waited_ms = ms(latest_ns) - ms(link.latest_ns) + ms(read_by_ns) - ms(latest_ns);
        let delay_ms = ms(link.latest_ns.min(latest_ns)) - ms(enters_ns);
        let late_ms = ms(leaves_ns) - ms(read_by_ns) - own_ms - self.slack_ms;
        Some(Lateness {
            least_ms: ms(leaves_ns) - ms(enters_ns) - ms(link.slowest_ns) - waited_ms - own_ms,
            most_ms: ms(leaves_ns) - ms(link.earliest_ns) - own_ms + still_ms,
            is_late: late_ms > LATE_MS + LATE_SHARE_OF_DELAY * delay_ms,
            is_resent: late_ms > RESENT_MS + LATE_SHARE_OF_DELAY * delay_ms,
        })
    }

    fn count_late(&mut self, one: &Lateness) {
        self.crossed.late += u64::from(one.is_late);
        self.crossed.resent += u64::from(one.is_resent);
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
        self.crossed.lost_due = thousandths(self.crossed.lost_due);
        let untold = std::mem::take(&mut self.untold);
        self.known.extend(told(untold, self.terms.connecting));
        let known = std::mem::take(&mut self.known);
        for one in &known {
            self.count_late(one);
        }
        with_lateness(self.crossed, &known, self.way, self.terms)
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
