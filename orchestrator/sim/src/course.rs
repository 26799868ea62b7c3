//! The course of a run: what happens next, and what comes of it.
//!
//! There are four sources of what happens: the plant's next tick, the controller's next waking,
//! the next message that runs out of time, and packets, which have a queue. At equal times they
//! come in that order, packets before the waking, since a client that wakes takes in first what
//! is there. What the ends do is in `endpoint`, what the link does in `link`.

use std::collections::VecDeque;

use endpoint::{
    Command, ControllerEnd, Counts, Loss, Mode, PlantEnd, PlantSettings, Step, Transport,
};
use link::Way;
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;

use crate::connection::{Connections, Id};
use crate::queue::Queue;
use crate::record::Record;
use crate::retransmission::{handshake_pause_ns, pause_ns};
use crate::setup::{Outcome, Setup, Unfit};
use crate::timing::Timing;
use crate::wire::Wire;

/// IP packets of a handshake: header, TCP header, options.
const HANDSHAKE_BYTES: u32 = 60;
/// A request, and an answer, with their HTTP heads.
const REQUEST_BYTES: u32 = 260;
const ANSWER_BYTES: u32 = 240;
/// Timers of a browser with a floor wait in whole steps of this, as event loops on poll did.
const TIMER_STEP_NS: u64 = 1_000_000;

/// Simulates a run, and gives its rows to `record`.
///
/// # Errors
/// [`Unfit`] where the controller's settings are none, or there is no model of what they ask.
pub fn run(setup: &Setup, record: &mut impl Record) -> Result<Outcome, Unfit> {
    if setup.settings.transport != Transport::Http {
        return Err(Unfit::Unmodelled("WebSocket"));
    }
    let mut course = Course::try_new(setup, record)?;
    course.run();
    Ok(course.outcome)
}

/// A packet, by what it does; what it carries is its connection's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Packet {
    /// Opens a connection.
    Syn,
    /// The plant's kernel agrees.
    SynAck,
    /// A command.
    Request,
    /// Its answer.
    Answer,
}

/// What is in the queue.
#[derive(Debug, Clone, Copy)]
enum Event {
    /// A packet is with the program, or the kernel, that it is for.
    Arrived(Id, Packet),
    /// A lost packet is sent for another time.
    Again(Id, Packet, u16),
    /// The plant's thread is free for the next request.
    PlantFree,
    /// The client's thread is free for the next answer.
    ClientFree,
}

/// A message that may run out of time.
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

struct Course<'a, R> {
    timing: &'a Timing,
    mode: Mode,
    timer_floor_ns: u64,
    timeout_ns: u64,
    after_ns: u64,
    controller: ControllerEnd,
    plant: PlantEnd,
    wire: Wire,
    connections: Connections,
    queue: Queue<Event>,
    terms: VecDeque<Term>,
    random: ChaCha8Rng,
    waiting: Waiting,
    /// Requests at the plant whose turn has not come, and answers at the client.
    at_plant: VecDeque<Id>,
    at_client: VecDeque<Id>,
    plant_free_ns: u64,
    client_free_ns: u64,
    last_end_ns: u64,
    outcome: Outcome,
    record: &'a mut R,
}

impl<'a, R: Record> Course<'a, R> {
    fn try_new(setup: &Setup<'a>, record: &'a mut R) -> Result<Self, Unfit> {
        let stop_ns = setup.start_ns.saturating_add(setup.duration_ns);
        let settings = setup.settings;
        let controller =
            ControllerEnd::try_new(settings, setup.law.clone(), 0.0, setup.start_ns, stop_ns)?;
        let plant_settings = PlantSettings {
            h: settings.h,
            late: settings.late,
        };
        let plant = PlantEnd::new(&plant_settings, setup.plant.clone(), setup.plant_start_ns);
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
                setup.epoch_ns,
                setup.timing.player_ns,
            ),
            connections: Connections::new(settings.connection),
            queue: Queue::new(),
            terms: VecDeque::new(),
            random: ChaCha8Rng::seed_from_u64(setup.seed),
            waiting: Waiting::Nothing,
            at_plant: VecDeque::new(),
            at_client: VecDeque::new(),
            plant_free_ns: 0,
            client_free_ns: 0,
            last_end_ns: setup.start_ns,
            outcome: Outcome {
                counts: Counts::default(),
                ticks: 0,
                arrivals: 0,
                connections: 0,
                resent: 0,
                end_ns: 0,
            },
            record,
        })
    }

    fn run(&mut self) {
        // A client has looked at the plant before, and its connection is there.
        let warm = self.connections.begin(u64::MAX, self.last_end_ns);
        self.connections.is_open(warm, self.last_end_ns);
        self.wait(0);
        loop {
            let tick_ns = self.plant.next_due_ns();
            let packet_ns = self.queue.next_ns();
            let term_ns = self.terms.front().map_or(u64::MAX, |term| term.end_ns);
            let waking_ns = match self.waiting {
                Waiting::Until(t_ns) => t_ns,
                Waiting::Answer | Waiting::Nothing => u64::MAX,
            };
            let first_ns = packet_ns.min(term_ns).min(waking_ns);
            if tick_ns <= first_ns {
                if self.is_over() && tick_ns > self.last_end_ns.saturating_add(self.after_ns) {
                    break;
                }
                let row = self.plant.tick(tick_ns);
                self.outcome.ticks += 1;
                self.record.tick(&row);
            } else if packet_ns <= first_ns {
                if let Some((t_ns, event)) = self.queue.pop() {
                    self.happens(t_ns, event);
                }
            } else if term_ns <= first_ns {
                self.runs_out();
            } else {
                self.wakes(waking_ns);
            }
        }
        self.outcome.counts = self.controller.counts();
        self.outcome.connections = self.connections.opened;
        self.outcome.end_ns = self.last_end_ns;
    }

    /// Whether the controller has nothing more to do.
    fn is_over(&self) -> bool {
        self.waiting == Waiting::Nothing && self.controller.oldest_under_way().is_none()
    }

    /// The controller's thread wakes for a deadline.
    fn wakes(&mut self, now_ns: u64) {
        if now_ns < self.client_free_ns {
            self.waiting = Waiting::Until(self.client_free_ns);
        } else {
            self.wait(now_ns);
        }
    }

    /// The controller does what is to be done at `now_ns`, and waits for what comes next.
    fn wait(&mut self, now_ns: u64) {
        self.waiting = loop {
            match self.controller.poll(now_ns) {
                Step::Send(command) => self.sends(command, now_ns),
                Step::Missed(row) => self.record.message(&row),
                Step::Sleep { until_ns } => break Waiting::Until(self.rings_ns(until_ns, now_ns)),
                Step::AwaitAnswer => break Waiting::Answer,
                Step::Finished => break Waiting::Nothing,
            }
        };
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

    /// A message goes out, or waits for a connection.
    fn sends(&mut self, command: Command, now_ns: u64) {
        self.client_free_ns = now_ns + u64::from(self.timing.send_ns);
        let carrier = self.connections.take(now_ns);
        self.terms.push_back(Term {
            end_ns: now_ns.saturating_add(self.timeout_ns),
            seq: command.seq,
            carrier,
        });
        match carrier {
            Some(id) => self.requests(id, command, now_ns),
            None => {
                let id = self.connections.open(command, now_ns);
                self.transmit(id, Packet::Syn, 1, now_ns);
            }
        }
    }

    /// A message goes out on a connection that it had to wait for.
    fn carries(&mut self, id: Id, command: Command, now_ns: u64) {
        if let Ok(place) = self
            .terms
            .binary_search_by_key(&command.seq, |term| term.seq)
        {
            self.terms[place].carrier = Some(id);
        }
        self.requests(id, command, now_ns);
    }

    fn requests(&mut self, id: Id, command: Command, now_ns: u64) {
        self.connections.sends(id, command, now_ns);
        self.transmit(id, Packet::Request, 1, now_ns);
    }

    /// Sends a packet for the `tries`-th time. What is lost is sent again when its sender's timer
    /// ends; a timer that ends although nothing was lost changes nothing.
    fn transmit(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        let (way, bytes) = match packet {
            Packet::Syn => (Way::Up, HANDSHAKE_BYTES),
            Packet::Request => (Way::Up, REQUEST_BYTES),
            Packet::SynAck => (Way::Down, HANDSHAKE_BYTES),
            Packet::Answer => (Way::Down, ANSWER_BYTES),
        };
        if let Some(out_ns) = self.wire.cross(way, now_ns, bytes) {
            let timing = self.timing;
            let takes_ns = match packet {
                Packet::Syn | Packet::SynAck => 0,
                Packet::Answer => timing.down_ns.draw(&mut self.random),
                Packet::Request => match self.connections.get(id).fresh {
                    true => timing.opened_up_ns.draw(&mut self.random),
                    false => timing.up_ns.draw(&mut self.random),
                },
            };
            self.queue
                .push(out_ns + takes_ns, Event::Arrived(id, packet));
            return;
        }
        self.outcome.resent += 1;
        let pause_ns = match packet {
            Packet::Syn | Packet::SynAck => handshake_pause_ns(tries),
            Packet::Request => pause_ns(self.connections.loses(id, false), tries),
            Packet::Answer => pause_ns(self.connections.loses(id, true), tries),
        };
        self.queue.push(
            now_ns + pause_ns,
            Event::Again(id, packet, tries.saturating_add(1)),
        );
    }

    fn happens(&mut self, now_ns: u64, event: Event) {
        match event {
            Event::Arrived(id, Packet::Syn) => self.transmit(id, Packet::SynAck, 1, now_ns),
            Event::Arrived(id, Packet::SynAck) => {
                if let Some(command) = self.connections.is_open(id, now_ns) {
                    self.carries(id, command, now_ns);
                }
            }
            Event::Arrived(id, Packet::Request) => {
                if now_ns >= self.plant_free_ns {
                    self.serves(id, now_ns);
                } else {
                    if self.at_plant.is_empty() {
                        self.queue.push(self.plant_free_ns, Event::PlantFree);
                    }
                    self.at_plant.push_back(id);
                }
            }
            Event::Arrived(id, Packet::Answer) => {
                if self.connections.get(id).abandoned {
                    self.connections.close(id);
                } else if now_ns >= self.client_free_ns {
                    self.takes(id, now_ns);
                } else {
                    if self.at_client.is_empty() {
                        self.queue.push(self.client_free_ns, Event::ClientFree);
                    }
                    self.at_client.push_back(id);
                }
            }
            Event::Again(id, packet, tries) => self.transmit(id, packet, tries, now_ns),
            Event::PlantFree => {
                if let Some(id) = self.at_plant.pop_front() {
                    self.serves(id, now_ns);
                }
                if !self.at_plant.is_empty() {
                    self.queue.push(self.plant_free_ns, Event::PlantFree);
                }
            }
            Event::ClientFree => {
                if now_ns < self.client_free_ns {
                    // It has sent something in between.
                    self.queue.push(self.client_free_ns, Event::ClientFree);
                    return;
                }
                if let Some(id) = self.at_client.pop_front() {
                    match self.connections.get(id).abandoned {
                        true => self.connections.close(id),
                        false => self.takes(id, now_ns),
                    }
                }
                if !self.at_client.is_empty() {
                    let free_ns = self.client_free_ns.max(now_ns);
                    self.queue.push(free_ns, Event::ClientFree);
                }
            }
        }
    }

    /// The plant takes a command and answers.
    fn serves(&mut self, id: Id, now_ns: u64) {
        self.plant_free_ns = now_ns + u64::from(self.timing.serve_ns);
        let command = self.connections.get(id).command;
        let (row, answer) = self.plant.command(self.mode, &command, now_ns);
        self.outcome.arrivals += 1;
        self.record.arrival(&row);
        match self.connections.get(id).abandoned {
            true => self.connections.close(id),
            false => {
                self.connections.answers(id, answer);
                self.transmit(id, Packet::Answer, 1, now_ns);
            }
        }
    }

    /// The client takes an answer.
    fn takes(&mut self, id: Id, now_ns: u64) {
        self.client_free_ns = now_ns + u64::from(self.timing.take_ns);
        let answer = self.connections.get(id).answer;
        if let Some(row) = answer.and_then(|answer| self.controller.answered(&answer, now_ns)) {
            self.last_end_ns = now_ns;
            self.record.message(&row);
        }
        // Of the messages that have ended the oldest terms go, so that few are kept.
        let oldest = self.controller.oldest_under_way().unwrap_or(u64::MAX);
        while self.terms.front().is_some_and(|term| term.seq < oldest) {
            self.terms.pop_front();
        }
        if let Some(command) = self.connections.is_answered(id, now_ns) {
            self.carries(id, command, now_ns);
        }
        if self.waiting == Waiting::Answer {
            self.wait(now_ns);
        }
    }

    /// The oldest message's time is over.
    fn runs_out(&mut self) {
        let Some(term) = self.terms.pop_front() else {
            return;
        };
        if let Some(row) = self.controller.lost(term.seq, Loss::Timeout, term.end_ns) {
            self.last_end_ns = term.end_ns;
            self.record.message(&row);
            self.connections.give_up(term.seq, term.carrier);
            if self.waiting == Waiting::Answer {
                self.wait(term.end_ns);
            }
        }
    }
}
