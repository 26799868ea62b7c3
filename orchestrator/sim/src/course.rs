//! The event loop of a run: takes the next event and computes its consequences.
//!
//! Events have four sources: the plant's next tick, the controller's next waking, the next message to
//! time out, and packets, which have a queue. Simultaneous events are taken in the order tick,
//! packet, timeout, waking: a client that wakes first takes in the packets that are there. `endpoint`
//! has what the ends do, `link` what the link does.

mod echoing;
mod frozen;
mod passage;
mod resending;

use std::collections::VecDeque;

use endpoint::{
    Carriage, Clock, Command, Connection, ControllerEnd, Mode, Model, Next, Outstanding, PlantEnd,
    PlantSettings,
};
use link::Way;
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;

use crate::connection::{Connections, Id};
use crate::echo::Series;
use crate::queue::{First, Queue};
use crate::record::Record;
use crate::retransmission::Wheel;
use crate::setup::{Outcome, Setup, Unfit};
use crate::stream::Stream;
use crate::timing::Timing;
use crate::wire::{Out, Wire};

use frozen::Frozen;
use passage::{Event, Packet};

/// In a browser with a timer floor, timers wait in whole steps of this, as event loops on poll did.
const TIMER_STEP_NS: u64 = 1_000_000;

/// Simulates a run and passes its rows to `record`.
///
/// # Errors
/// [`Unfit`] if the controller's settings are invalid, or a fault of the link has no model here.
pub fn run<M: Model + Clone>(
    setup: &Setup<'_, M>,
    record: &mut impl Record,
) -> Result<Outcome, Unfit> {
    let mut course = Course::try_new(setup, record)?;
    course.run();
    Ok(course.outcome)
}

/// The timeout of a message.
#[derive(Debug, Clone, Copy)]
struct Term {
    end_ns: u64,
    seq: u64,
    carrier: Option<Id>,
}

/// What the controller waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Waiting {
    Until(u64),
    Answer,
    Nothing,
}

/// Both ends of a run, before its first event.
fn ends<M: Model + Clone>(setup: &Setup<'_, M>) -> Result<(ControllerEnd, PlantEnd<M>), Unfit> {
    let settings = setup.settings;
    let controller = ControllerEnd::try_new(
        settings,
        setup.law.clone(),
        setup.plant.at_rest(),
        setup.start_ns,
        setup.start_ns.saturating_add(setup.duration_ns),
    )?
    .following(setup.reference.clone());
    let plant_settings = PlantSettings {
        h: settings.h,
        late: settings.late,
        clock: Clock::Shared,
        ..setup.plant_settings
    };
    let plant = PlantEnd::new(&plant_settings, setup.plant.clone(), setup.plant_start_ns);
    Ok((controller, plant))
}

struct Course<'a, R, M> {
    timing: &'a Timing,
    mode: Mode,
    timer_floor_ns: u64,
    timeout_ns: u64,
    after_ns: u64,
    controller: ControllerEnd,
    plant: PlantEnd<M>,
    wire: Wire,
    wheel: Wheel,
    message_bytes: [u32; 2],
    echoes: &'a [Series],
    frozen: [Frozen<'a>; 2],
    /// The link's seed, which also draws when echoes are sent.
    seed: u64,
    connections: Connections,
    /// With one connection for all messages, or none, the entries of `connections` are places of messages.
    stream: Option<Stream>,
    carriage: Carriage,
    queue: Queue<(Id, Packet), Event>,
    terms: VecDeque<Term>,
    random: ChaCha8Rng,
    waiting: Waiting,
    /// When the plant ticks next, the oldest message times out, and the controller wakes: asked for at each event,
    /// and kept until it changes. `u64::MAX` is never.
    tick_ns: u64,
    term_ns: u64,
    waking_ns: u64,
    /// Requests that wait for the plant's thread, and answers that wait for the client's.
    at_plant: VecDeque<Id>,
    at_client: VecDeque<Id>,
    plant_free_ns: u64,
    client_free_ns: u64,
    last_end_ns: u64,
    outcome: Outcome,
    record: &'a mut R,
}

impl<'a, R: Record, M: Model + Clone> Course<'a, R, M> {
    fn try_new(setup: &Setup<'a, M>, record: &'a mut R) -> Result<Self, Unfit> {
        if let Some(fault) = setup.profile.breaks_connections() {
            return Err(Unfit::Fault(fault));
        }
        let settings = setup.settings;
        let (controller, plant) = ends(setup)?;
        let carriage = settings.transport.carriage();
        if carriage == Carriage::Datagrams
            && let Some(fault) = setup.profile.duplicates()
        {
            return Err(Unfit::Twice(fault));
        }
        let stream = (carriage == Carriage::Stream).then(|| {
            let waits = settings.outstanding == Outstanding::ONE;
            Stream::new((!waits).then(|| settings.h.ns()))
        });
        Ok(Self {
            timing: setup.timing,
            mode: settings.mode,
            timer_floor_ns: setup.timer_floor_ns,
            timeout_ns: settings.timeout_ns,
            after_ns: setup.after_ns,
            controller,
            plant,
            wire: Wire::new(
                setup.profile,
                setup.seed,
                setup.epoch,
                setup.timing.player_ns,
            ),
            wheel: Wheel::new(setup.timing.hz, setup.seed),
            message_bytes: setup.message_bytes,
            echoes: setup.echoes,
            frozen: setup.frozen.map(Frozen),
            seed: setup.seed,
            connections: Connections::new(
                match carriage {
                    Carriage::Requests => settings.connection,
                    // Each message has a place of its own.
                    Carriage::Stream | Carriage::Datagrams => Connection::New,
                },
                setup.pool,
                // On one connection for all messages, other packets reveal a loss.
                carriage == Carriage::Requests && !setup.profile.treats_packets_alike(),
            ),
            stream,
            carriage,
            queue: Queue::new(),
            terms: VecDeque::new(),
            random: ChaCha8Rng::seed_from_u64(setup.seed),
            waiting: Waiting::Nothing,
            tick_ns: 0,
            term_ns: u64::MAX,
            waking_ns: u64::MAX,
            at_plant: VecDeque::new(),
            at_client: VecDeque::new(),
            plant_free_ns: 0,
            client_free_ns: 0,
            last_end_ns: setup.start_ns,
            outcome: Outcome::default(),
            record,
        })
    }

    fn run(&mut self) {
        // A client has looked at the plant before, so its first connection is already open.
        let warm = self.connections.begin(u64::MAX, self.last_end_ns);
        self.connections.on_open(warm, self.last_end_ns);
        self.begin_series(false);
        self.tick_ns = self.next_tick_ns();
        self.wait(0);
        let mut has_ended = false;
        loop {
            if !has_ended && self.is_over() {
                has_ended = true;
                self.begin_series(true);
            }
            let packet_ns = self.queue.next_ns();
            let first_ns = packet_ns.min(self.term_ns).min(self.waking_ns);
            if self.tick_ns <= first_ns {
                if has_ended && self.tick_ns > self.last_end_ns.saturating_add(self.after_ns) {
                    break;
                }
                self.ticks();
            } else if packet_ns <= first_ns {
                self.takes_first();
            } else if self.term_ns <= first_ns {
                self.runs_out(self.term_ns);
            } else {
                self.wakes(self.waking_ns);
            }
        }
        // The plant has stopped, but its kernel still answers echoes.
        while let Some((t_ns, event)) = self.queue.pop() {
            if matches!(event, Event::EchoDue(_) | Event::EchoReached(_)) {
                self.happens(t_ns, event);
            }
        }
        self.outcome.counts = self.controller.counts();
        self.outcome.connections = self.connections.opened;
        self.outcome.end_ns = self.last_end_ns;
    }

    /// The plant ticks.
    #[inline]
    fn ticks(&mut self) {
        let row = self.plant.tick(self.tick_ns);
        self.outcome.ticks += 1;
        self.record.tick(&row);
        if let Some(row) = self.plant.second() {
            self.record.second(&row);
        }
        self.tick_ns = self.next_tick_ns();
    }

    #[inline]
    fn next_tick_ns(&self) -> u64 {
        let [_, plant] = self.frozen;
        plant.over_ns(self.plant.next_tick_ns())
    }

    /// Takes the first packet or event of the queue.
    #[inline]
    fn takes_first(&mut self) {
        match self.queue.first() {
            First::Packet(way) => {
                if let Some((t_ns, (id, packet))) = self.queue.pop_packet(way) {
                    self.arrives(way, id, packet, t_ns);
                }
            }
            First::Other => {
                if let Some((t_ns, event)) = self.queue.pop() {
                    self.happens(t_ns, event);
                }
            }
        }
    }

    /// When a packet that enters the link comes out; `None` if it is lost.
    fn cross(&mut self, way: Way, now_ns: u64, bytes: u32) -> Option<u64> {
        self.pass(way, now_ns, bytes).map(|out| out.t_ns)
    }

    /// How a packet that enters the link comes out; `None` if it is lost.
    #[inline]
    fn pass(&mut self, way: Way, now_ns: u64, bytes: u32) -> Option<Out> {
        if let Some(t_ns) = self.wire.enters_ns(way, now_ns) {
            self.record.packet(way, t_ns, bytes);
            return self.wire.cross(way, t_ns, bytes);
        }
        self.wire.cross(way, now_ns, bytes)
    }

    /// Whether the controller has nothing more to do.
    fn is_over(&self) -> bool {
        self.waiting == Waiting::Nothing && self.controller.oldest_under_way().is_none()
    }

    /// The controller's thread wakes for a deadline.
    fn wakes(&mut self, now_ns: u64) {
        if now_ns < self.client_free_ns {
            self.waits(Waiting::Until(self.client_free_ns));
        } else {
            self.wait(now_ns);
        }
    }

    /// The controller does all that is due at `now_ns`, then waits for its next event.
    fn wait(&mut self, now_ns: u64) {
        let waiting = loop {
            match self.controller.next(now_ns) {
                Next::Send(deadline) => {
                    let command = self.controller.send(deadline, now_ns);
                    self.sends(&command, now_ns);
                }
                Next::Missed(deadline) => self.record.message(&self.controller.row(deadline)),
                Next::Sleep { until_ns } => break Waiting::Until(self.rings_ns(until_ns, now_ns)),
                Next::AwaitAnswer => break Waiting::Answer,
                Next::Finished => break Waiting::Nothing,
            }
        };
        self.waits(waiting);
    }

    #[inline]
    fn waits(&mut self, waiting: Waiting) {
        let [controller, _] = self.frozen;
        self.waiting = waiting;
        self.waking_ns = match waiting {
            Waiting::Until(t_ns) => controller.over_ns(t_ns),
            Waiting::Answer | Waiting::Nothing => u64::MAX,
        };
    }

    /// When the oldest message times out.
    #[inline]
    fn next_term_ns(&self) -> u64 {
        let [controller, _] = self.frozen;
        let oldest = self.terms.front();
        oldest.map_or(u64::MAX, |term| controller.over_ns(term.end_ns))
    }

    /// When the controller's timer, set at `now_ns`, rings for a deadline.
    fn rings_ns(&mut self, until_ns: u64, now_ns: u64) -> u64 {
        let mut rings_ns = until_ns;
        if self.timer_floor_ns > 0 {
            let pause_ns = until_ns.saturating_sub(now_ns).max(self.timer_floor_ns);
            rings_ns = now_ns.saturating_add(pause_ns.next_multiple_of(TIMER_STEP_NS));
        }
        rings_ns
            .saturating_add(self.timing.late_ns.draw(&mut self.random))
            .max(self.client_free_ns)
    }

    /// A message is sent, or waits for a connection.
    #[inline]
    fn sends(&mut self, command: &Command, now_ns: u64) {
        self.client_free_ns = now_ns + u64::from(self.timing.send_ns);
        let carrier = match self.carriage {
            Carriage::Requests => self.connections.take(now_ns),
            Carriage::Stream | Carriage::Datagrams => Some(self.connections.place(now_ns)),
        };
        self.terms.push_back(Term {
            end_ns: now_ns.saturating_add(self.timeout_ns),
            seq: command.seq,
            carrier,
        });
        if self.terms.len() == 1 {
            self.term_ns = self.next_term_ns();
        }
        match carrier {
            Some(id) => {
                self.connections.sends(id, command, now_ns, self.wheel);
                self.transmit(id, Packet::Request, 1, now_ns);
            }
            None => {
                let id = self.connections.open(*command, now_ns);
                self.transmit_rarely(id, Packet::Syn, 1, now_ns);
            }
        }
    }

    /// A message is sent on a connection that it had to wait for.
    #[cold]
    fn carries(&mut self, id: Id, command: &Command, now_ns: u64) {
        if let Ok(place) = self
            .terms
            .binary_search_by_key(&command.seq, |term| term.seq)
        {
            self.terms[place].carrier = Some(id);
        }
        self.connections.sends(id, command, now_ns, self.wheel);
        self.transmit_rarely(id, Packet::Request, 1, now_ns);
    }
}
