//! The client's HTTP connections: which one takes a message, and when a new one is opened.
//!
//! A message takes the idle connection that was used last. If none is idle, a new one is opened for
//! it; depending on [`Pool`] the message waits for that one or takes the first that becomes free.
//! This file also keeps what is known of a connection's round trip, but no packets.

use std::collections::VecDeque;

use endpoint::{Answer, Command, Connection as Keeping};

use crate::acknowledgement::{Acknowledged, Acknowledger};
use crate::retransmission::{RoundTrip, VARIATION_MIN_NS, Wheel};

/// Which connection a message takes if it found none idle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pool {
    /// The first that becomes free, as in the native client and in browsers.
    Shared,
    /// The one that was opened for it, as in the Python client, where each message has a worker that
    /// keeps its own connection.
    Own,
}

/// How long a connection may idle before the client leaves it.
const IDLE_MAX_NS: u64 = 4_000_000_000;
/// A connection's number; the number of a closed connection is reused.
pub(crate) type Id = u32;

/// A connection, with at most one packet under way on it.
#[derive(Debug, Clone)]
pub(crate) struct Connection {
    /// The command under way on it, or the last one.
    pub(crate) command: Command,
    /// The plant's answer to that command, once there is one.
    pub(crate) answer: Option<Answer>,
    /// The message that the connection is opened for; unused once it is open.
    opened_for: u64,
    /// Whether it has carried no message yet.
    pub(crate) fresh: bool,
    /// Whether the client has given up the message under way on it.
    pub(crate) abandoned: bool,
    /// When the handshake or message under way began, or when the connection became idle.
    since_ns: u64,
    /// How the client acknowledges answers, and how it acknowledged the last one.
    acknowledger: Acknowledger,
    acknowledged: Acknowledged,
    /// Counts handshakes and messages on the connection: the number of the current or last one.
    turn: u32,
    /// Whether that one has not been answered yet.
    is_unheard: bool,
    /// Whether the current request was lost, and whether its answer was.
    request_lost: bool,
    answer_lost: bool,
    client: RoundTrip,
    plant: RoundTrip,
}

impl Connection {
    /// The answer is there: updates the client's estimate of the round trip.
    #[inline]
    fn notes_answer(&mut self, now_ns: u64, wheel: Wheel) {
        let client = &mut self.client;
        // If the answer was lost, the client may have resent the message meanwhile, and the plant
        // acknowledged that at once.
        let probed_ns = || wheel.rings_ns(self.since_ns, client.probe_ns());
        let is_probed = self.answer_lost && probed_ns() + client.smoothed_ns() < now_ns;
        if !self.request_lost && !is_probed {
            client.seen(now_ns - self.since_ns);
        }
        self.acknowledger.receives(now_ns);
    }
}

/// All connections of a client.
#[derive(Debug)]
pub(crate) struct Connections {
    keeping: Keeping,
    pool: Pool,
    /// Whether the ends' estimates of round trips are kept: only timers that may end need them.
    is_timed: bool,
    all: Vec<Connection>,
    closed: Vec<Id>,
    /// Idle connections; the one used last is at the end.
    idle: Vec<Id>,
    /// Messages that have no connection yet, in the order of their numbers.
    waiting: VecDeque<Command>,
    /// Number of connections opened.
    pub(crate) opened: u64,
}

impl Connections {
    pub(crate) fn new(keeping: Keeping, pool: Pool, is_timed: bool) -> Self {
        Self {
            keeping,
            pool,
            is_timed,
            all: Vec::new(),
            closed: Vec::new(),
            idle: Vec::new(),
            waiting: VecDeque::new(),
            opened: 0,
        }
    }

    /// Takes an idle connection for a message, if there is one.
    #[inline]
    pub(crate) fn take(&mut self, now_ns: u64) -> Option<Id> {
        let id = self.idle.pop()?;
        if now_ns - self.all[id as usize].since_ns <= IDLE_MAX_NS {
            return Some(id);
        }
        // The connections below it have idled for longer.
        self.closed.push(id);
        self.closed.append(&mut self.idle);
        None
    }

    /// Adds a place for a message on the shared connection, which is already open.
    pub(crate) fn place(&mut self, now_ns: u64) -> Id {
        let id = self.add(u64::MAX, now_ns);
        self.all[id as usize].fresh = false;
        id
    }

    /// Starts to open a connection for a message, which waits meanwhile.
    pub(crate) fn open(&mut self, command: Command, now_ns: u64) -> Id {
        self.waiting.push_back(command);
        self.begin(command.seq, now_ns)
    }

    /// Starts to open a connection.
    pub(crate) fn begin(&mut self, opened_for: u64, now_ns: u64) -> Id {
        self.opened += 1;
        self.add(opened_for, now_ns)
    }

    fn add(&mut self, opened_for: u64, now_ns: u64) -> Id {
        let place = self.closed.pop();
        let before = place.map(|id| self.all[id as usize].turn);
        let connection = Connection {
            turn: before.map_or(0, |turn| turn.wrapping_add(1)),
            is_unheard: true,
            command: Command {
                seq: opened_for,
                t_send_ns: 0,
                u: 0.0.into(),
            },
            answer: None,
            opened_for,
            fresh: true,
            abandoned: false,
            since_ns: now_ns,
            acknowledger: Acknowledger::default(),
            acknowledged: Acknowledged::default(),
            request_lost: false,
            answer_lost: false,
            client: RoundTrip::first(0),
            plant: RoundTrip::first(0),
        };
        if let Some(id) = place {
            self.all[id as usize] = connection;
            return id;
        }
        self.all.push(connection);
        // A client has as many connections as messages under way, at most some thousands.
        u32::try_from(self.all.len() - 1).unwrap_or(u32::MAX)
    }

    /// A packet of the handshake is sent again: the round trip counts from now on.
    pub(crate) fn begins_again(&mut self, id: Id, now_ns: u64) {
        self.all[id as usize].since_ns = now_ns;
    }

    /// The connection is open. Returns the waiting message that it must carry at once, if any.
    pub(crate) fn on_open(&mut self, id: Id, now_ns: u64) -> Option<Command> {
        let connection = &mut self.all[id as usize];
        connection.is_unheard = false;
        let rtt_ns = now_ns - connection.since_ns;
        connection.client = RoundTrip::first(rtt_ns);
        connection.plant = RoundTrip::first(rtt_ns);
        let own = connection.opened_for;
        // Its own message may have taken another connection meanwhile, or been given up.
        match self.waiting.binary_search_by_key(&own, |one| one.seq) {
            Ok(place) => self.waiting.remove(place),
            Err(_) => self.on_free(id, now_ns),
        }
    }

    /// A message is sent on the connection.
    #[inline]
    pub(crate) fn sends(&mut self, id: Id, command: &Command, now_ns: u64, wheel: Wheel) {
        let connection = &mut self.all[id as usize];
        // Number by number: copied at once, they would wait until each has been written.
        connection.command.seq = command.seq;
        connection.command.t_send_ns = command.t_send_ns;
        connection.command.u.first = command.u.first;
        match command.u.second {
            None => connection.command.u.second = None,
            Some(second) => connection.command.u.second = Some(second),
        }
        connection.since_ns = now_ns;
        connection.turn = connection.turn.wrapping_add(1);
        connection.is_unheard = true;
        connection.request_lost = false;
        connection.answer_lost = false;
        if self.is_timed {
            let rtt_ns = connection.client.smoothed_ns();
            connection.acknowledged = connection.acknowledger.sends(now_ns, rtt_ns, wheel);
        }
    }

    /// Whether estimates of round trips are kept.
    #[inline]
    pub(crate) fn is_timed(&self) -> bool {
        self.is_timed
    }

    /// The connection's message, sent or resent at `now_ns`, gets through. Updates the plant's
    /// estimate of the round trip, which ended when the client acknowledged the last answer, with
    /// this message or before it.
    #[inline]
    pub(crate) fn gets_through(&mut self, id: Id, now_ns: u64, wheel: Wheel) {
        let connection = &mut self.all[id as usize];
        let waited_ns = match connection.acknowledged {
            Acknowledged::Never => return,
            Acknowledged::After(pause_ns) => pause_ns,
            Acknowledged::WithMessage { answered_ns } => {
                // If the acknowledgement was lost with the message, the plant may have resent its
                // answer meanwhile, and the client acknowledged that at once. No probe comes sooner
                // than the least timeout, and nearly every message does.
                let waited_ns = now_ns - answered_ns;
                let is_probed = waited_ns > VARIATION_MIN_NS && {
                    let probe_ns = connection.plant.probe_ns();
                    let probed_ns = wheel.rung_ns(answered_ns, probe_ns, now_ns);
                    probed_ns.is_some_and(|probed_ns| probed_ns < now_ns)
                };
                if is_probed { 0 } else { waited_ns }
            }
        };
        connection
            .plant
            .seen(connection.client.smoothed_ns() + waited_ns);
    }

    /// The message was answered. Returns the waiting message that the connection must carry at once, if any.
    #[inline]
    pub(crate) fn on_answer(&mut self, id: Id, now_ns: u64, wheel: Wheel) -> Option<Command> {
        let connection = &mut self.all[id as usize];
        connection.fresh = false;
        if self.is_timed {
            connection.notes_answer(now_ns, wheel);
        }
        if self.keeping == Keeping::New {
            self.close(id);
            return None;
        }
        self.on_free(id, now_ns)
    }

    #[inline]
    fn on_free(&mut self, id: Id, now_ns: u64) -> Option<Command> {
        let next = match self.pool {
            Pool::Shared => self.waiting.pop_front(),
            Pool::Own => None,
        };
        if next.is_none() {
            self.all[id as usize].since_ns = now_ns;
            self.idle.push(id);
        }
        next
    }

    /// Closes a connection that nothing is under way on.
    pub(crate) fn close(&mut self, id: Id) {
        self.closed.push(id);
    }

    /// The client gives up a message: the packet under way on its connection goes on without it, and
    /// a message that waits for a connection is dropped.
    pub(crate) fn give_up(&mut self, seq: u64, carrier: Option<Id>) {
        match carrier {
            Some(id) => self.all[id as usize].abandoned = true,
            None => self.waiting.retain(|command| command.seq != seq),
        }
    }

    /// Whether the message or its answer was lost.
    pub(crate) fn has_lost(&self, id: Id) -> bool {
        let connection = &self.all[id as usize];
        connection.request_lost || connection.answer_lost
    }

    /// Whether the client acknowledges an answer on this connection at once, with a packet of its own.
    #[inline]
    pub(crate) fn acknowledges_at_once(&self, id: Id) -> bool {
        self.is_timed && !self.all[id as usize].acknowledger.is_interactive()
    }

    /// An answer has reached the client's kernel.
    #[inline]
    pub(crate) fn hears(&mut self, id: Id) {
        self.all[id as usize].is_unheard = false;
    }

    /// Number of the handshake or message under way, if it has not been answered yet.
    pub(crate) fn turn(&self, id: Id) -> Option<u32> {
        let connection = &self.all[id as usize];
        connection.is_unheard.then_some(connection.turn)
    }

    /// The plant's or the client's estimate of this connection's round trip.
    pub(crate) fn round_trip(&self, id: Id, of_plant: bool) -> RoundTrip {
        let connection = &self.all[id as usize];
        if of_plant {
            connection.plant
        } else {
            connection.client
        }
    }

    /// The connection with this number.
    #[inline]
    pub(crate) fn get(&self, id: Id) -> &Connection {
        &self.all[id as usize]
    }

    /// The same, to change it.
    #[inline]
    pub(crate) fn get_mut(&mut self, id: Id) -> &mut Connection {
        &mut self.all[id as usize]
    }

    /// The answer or the request under way was lost.
    pub(crate) fn loses(&mut self, id: Id, is_answer: bool) {
        let connection = &mut self.all[id as usize];
        if is_answer {
            connection.answer_lost = true;
        } else {
            connection.request_lost = true;
        }
    }
}
