//! Plays a link on real packets: a packet that comes in at one port leaves by the other at the time
//! that the link gives it, if it is not lost.
//!
//! The delay counts from the kernel's receive stamp, so the player's own wake-up does not add to it.
//! What the player did is in its [report](PlayerReport), and in a [row](LinkRow) once a second;
//! others judge it.

pub(crate) mod relay;
pub(crate) mod tally;
pub(crate) mod tunnel;
pub(crate) mod twist;
pub(crate) mod watch;

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use clock::guard::Guard;
use clock::now::{SECOND_NS, now_ns, timespec};
use link::certificate::{LinkRow, Pause, PlayerReport, Scheduling, WayReport};
use link::{Epoch, LinkTime, PacketRow, PerWay, Profile, Timeline, Way};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;

use crate::error::{Doing, Result};
use crate::player::relay::Relay;
use crate::player::tally::Tally;
use crate::player::watch::Watch;
use crate::port::Port;
use crate::port::inbox::Inbox;
use crate::record::Record;
use crate::scheduling::{prefer_this_thread, reported};

/// Above the ends, at 45: a network does not get slower because the ends are busy, as they are when a stall
/// ends and releases thousands of packets. Below a plant's tick, at 50, which is short and rare.
const PRIORITY: u8 = 48;

/// The longest sleep, so that a request to stop is seen soon.
const LONGEST_SLEEP_NS: u64 = 50_000_000;

/// Batches of packets taken from one port before the other port and the departures have their turn.
const TURNS: usize = 4;

/// What to play.
#[derive(Debug)]
pub struct PlayerConfig<P> {
    /// The link to play.
    pub profile: Profile,
    /// The seed of the link.
    pub seed: u64,
    /// The monotonic instant of link time 0.
    pub epoch: Epoch,
    /// The link time from which on the link is played. Before it, the empty link is.
    pub opens: LinkTime,
    /// The port where the controller's packets come in and the plant's go out.
    pub controller: P,
    /// The port where the plant's packets come in and the controller's go out.
    pub plant: P,
    /// Where each packet that enters is recorded, if at all.
    pub packets: Option<Record<PacketRow>>,
}

/// Plays until `stop` is set, on the calling thread, for which it requests real-time scheduling.
/// Start other threads first, since they would inherit it.
///
/// `on_second` gets the rows of both ways once a second and at the end. It is called between two
/// packets, so it must neither wait nor write; [`record`](crate::record) writes on a thread of its
/// own. Packets still under way at the end are counted, not sent.
///
/// # Errors
/// [`Error::Failed`](crate::Error::Failed) if a port fails, for instance because its interface is gone.
pub fn play<P: Port>(
    config: PlayerConfig<P>,
    stop: &AtomicBool,
    mut on_second: impl FnMut([LinkRow; 2]),
) -> Result<PlayerReport> {
    let timeline = Timeline::new(&config.profile, config.seed, config.epoch).opening(config.opens);
    let (mut controller, mut plant) = (config.controller, config.plant);
    let mut player = Player::new(
        Relay::new(timeline),
        PerWay {
            up: &mut controller,
            down: &mut plant,
        },
        if config.profile.treats_packets_alike() {
            Inbox::of_segments()
        } else {
            Inbox::of_packets()
        },
        config.packets,
    );
    let played = player.run(stop, &mut |rows| on_second([rows.up, rows.down]))?;
    let PerWay { up, down } = player.into_reports();
    Ok(PlayerReport {
        scheduling: played.scheduling,
        epoch: config.epoch,
        started_ns: played.started_ns,
        ended_ns: played.ended_ns,
        pauses: played.pauses,
        up,
        down,
    })
}

/// The player of both ways. A way's packets come in at its own port and leave by that of the way back.
pub(crate) struct Player<'p> {
    relay: Relay,
    ports: PerWay<&'p mut dyn Port>,
    inbox: Inbox,
    tallies: PerWay<Tally>,
    watch: Watch,
    packets: Option<Record<PacketRow>>,
    /// The packets of this second.
    entered: Vec<PacketRow>,
}

/// The result of a play.
pub(crate) struct Played {
    pub(crate) scheduling: Scheduling,
    pub(crate) started_ns: u64,
    pub(crate) ended_ns: u64,
    pub(crate) pauses: Vec<Pause>,
}

impl<'p> Player<'p> {
    pub(crate) fn new(
        relay: Relay,
        ports: PerWay<&'p mut dyn Port>,
        inbox: Inbox,
        packets: Option<Record<PacketRow>>,
    ) -> Self {
        Self {
            relay,
            ports,
            inbox,
            tallies: PerWay::of(Tally::new),
            watch: Watch::new(now_ns()),
            entered: room(packets.is_some()),
            packets,
        }
    }

    /// Plays until `stop` is set.
    pub(crate) fn run(
        &mut self,
        stop: &AtomicBool,
        on_second: &mut dyn FnMut(PerWay<LinkRow>),
    ) -> Result<Played> {
        let granted = prefer_this_thread(PRIORITY);
        let mut guard = Guard::of(&granted);
        let started_ns = now_ns();
        let mut row_due_ns = started_ns + SECOND_NS;
        self.watch = Watch::new(started_ns);
        while !stop.load(Ordering::Relaxed) {
            self.take_arrivals()?;
            self.send_departures();
            let now = now_ns();
            if now >= row_due_ns {
                on_second(self.rows(now)?);
                self.hand_over();
                row_due_ns += SECOND_NS;
            }
            self.watch.beat(now);
            self.wait(now, &mut guard)?;
        }
        let ended_ns = now_ns();
        on_second(self.rows(ended_ns)?);
        self.hand_over();
        self.packets.take().map_or(Ok(()), Record::finish)?;
        Ok(Played {
            scheduling: reported(&granted),
            started_ns,
            ended_ns,
            pauses: std::mem::take(&mut self.watch.pauses),
        })
    }

    /// What was counted on each way.
    pub(crate) fn into_reports(self) -> PerWay<WayReport> {
        PerWay::of(|way| self.tallies[way].report(self.relay.under_way(way)))
    }

    fn take_arrivals(&mut self) -> Result<()> {
        for way in Way::BOTH {
            for _ in 0..TURNS {
                self.ports[way]
                    .receive(&mut self.inbox)
                    .doing(receiving(way))?;
                for index in 0..self.inbox.len() {
                    let Some((arrival, frame)) = self.inbox.take(index, &mut self.relay.pool)
                    else {
                        continue;
                    };
                    self.watch.on_arrival(arrival.stamp_ns);
                    let entry = self.relay.enter(way, &arrival, frame);
                    self.tallies[way].entered(arrival.packets, arrival.ip_bytes, entry);
                    self.note(way, arrival.ip_bytes);
                }
                if !self.inbox.is_full() {
                    break;
                }
            }
        }
        Ok(())
    }

    fn send_departures(&mut self) {
        let mut now = now_ns();
        while let Some(departure) = self.relay.pop_due(now) {
            let way = departure.way;
            let sent = self.ports[way.back()].send(departure.frame());
            if let Err(error) = &sent {
                tracing::debug!(%error, ?way, "a packet could not be sent");
            }
            now = now_ns();
            self.watch.beat(now);
            let late_ns = now.saturating_sub(departure.at_ns);
            self.tallies[way].left(departure.packets, late_ns, sent.is_ok());
            self.relay.finish(departure);
        }
    }

    fn rows(&mut self, now: u64) -> Result<PerWay<LinkRow>> {
        for way in Way::BOTH {
            let counters = self.ports[way].counters().doing(receiving(way))?;
            self.tallies[way].update(counters);
        }
        Ok(PerWay::of(|way| self.tallies[way].row(now)))
    }

    /// Records a packet that has entered, if requested.
    fn note(&mut self, way: Way, bytes: u32) {
        if self.packets.is_some() && !self.relay.is_carried(way) {
            self.entered.push(PacketRow {
                t_ns: self.relay.entered_ns(way),
                way,
                bytes,
            });
        }
    }

    /// Passes this second's packets to the thread that writes them.
    fn hand_over(&mut self) {
        if let Some(packets) = &mut self.packets {
            packets.add_all(std::mem::replace(&mut self.entered, room(true)));
        }
    }

    /// Sleeps until a packet comes or the next departure is near; returns at once if it is near.
    fn wait(&mut self, now: u64, guard: &mut Guard) -> Result<()> {
        let next_ns = self.relay.next_ns();
        let wake_ns = next_ns.map_or(u64::MAX, |next| guard.wake_ns(next));
        if wake_ns <= now {
            std::hint::spin_loop();
            return Ok(());
        }
        let mut ports = [&self.ports.up, &self.ports.down]
            .map(|port| PollFd::from_borrowed_fd(port.as_fd(), PollFlags::IN));
        let rested_ns = wake_ns.min(now + LONGEST_SLEEP_NS);
        self.watch.rest_until(rested_ns);
        match poll(&mut ports, Some(&timespec(rested_ns - now))) {
            // No packet ended the sleep.
            Ok(0) if rested_ns == wake_ns => guard.learn(now_ns().saturating_sub(wake_ns)),
            // After a signal the caller checks `stop`.
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(io::Error::from(error)).doing("wait for packets"),
        }
        Ok(())
    }
}

/// Room for a second's packets if they are recorded, so that none is allocated while playing.
fn room(is_needed: bool) -> Vec<PacketRow> {
    const PACKETS_PER_S: usize = 8192;
    Vec::with_capacity(if is_needed { PACKETS_PER_S } else { 0 })
}

fn receiving(way: Way) -> &'static str {
    match way {
        Way::Up => "receive the controller's packets",
        Way::Down => "receive the plant's packets",
    }
}
