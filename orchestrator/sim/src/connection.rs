//! The client's HTTP connections: which one takes a message, and when a new one is opened.
//!
//! As the pool of the native client does it: a message takes the connection that was used last
//! and is idle; where none is, one is opened for it, and it goes on whichever is free first. What
//! is known of a connection's round trip is here, packets are not.

use std::collections::VecDeque;

use endpoint::{Answer, Command, Connection as Keeping};

use crate::retransmission::RoundTrip;

/// How long a connection may idle before the client leaves it.
const IDLE_MAX_NS: u64 = 5_000_000_000;
/// How long Linux waits at most to acknowledge what nothing is sent back for (`TCP_DELACK_MIN`).
const ACKNOWLEDGE_NS: u64 = 40_000_000;

/// A connection's number; of one that was closed it is given again.
pub(crate) type Id = u32;

/// A connection, with one packet under way on it at most.
#[derive(Debug, Clone)]
pub(crate) struct Connection {
    /// The command that is under way on it, or was last.
    pub(crate) command: Command,
    /// The plant's answer to it, once it has one.
    pub(crate) answer: Option<Answer>,
    /// The message that it was opened for, until it is open.
    opened_for: u64,
    /// Whether it has carried nothing yet.
    pub(crate) fresh: bool,
    /// Whether the client has given up what is under way on it.
    pub(crate) abandoned: bool,
    /// When what is under way, or else idling, began.
    since_ns: u64,
    /// Whether what is under way was sent more than once.
    resent: bool,
    client: RoundTrip,
    plant: RoundTrip,
}

/// All connections of a client.
#[derive(Debug)]
pub(crate) struct Connections {
    keeping: Keeping,
    all: Vec<Connection>,
    closed: Vec<Id>,
    /// Those that idle, the one used last at the end.
    idle: Vec<Id>,
    /// Messages that have no connection yet.
    waiting: VecDeque<Command>,
    /// How many were opened.
    pub(crate) opened: u64,
}

impl Connections {
    pub(crate) fn new(keeping: Keeping) -> Self {
        Self {
            keeping,
            all: Vec::new(),
            closed: Vec::new(),
            idle: Vec::new(),
            waiting: VecDeque::new(),
            opened: 0,
        }
    }

    /// An idle connection for a message, if there is one.
    pub(crate) fn take(&mut self, now_ns: u64) -> Option<Id> {
        let id = self.idle.pop()?;
        if now_ns - self.all[id as usize].since_ns <= IDLE_MAX_NS {
            return Some(id);
        }
        // Those below it have idled for longer.
        self.closed.push(id);
        self.closed.append(&mut self.idle);
        None
    }

    /// A place for a message on a connection that all share, which is open.
    pub(crate) fn place(&mut self, now_ns: u64) -> Id {
        let id = self.add(u64::MAX, now_ns);
        self.all[id as usize].fresh = false;
        id
    }

    /// Begins to open one for a message, which waits.
    pub(crate) fn open(&mut self, command: Command, now_ns: u64) -> Id {
        self.waiting.push_back(command);
        self.begin(command.seq, now_ns)
    }

    /// Begins to open one.
    pub(crate) fn begin(&mut self, opened_for: u64, now_ns: u64) -> Id {
        self.opened += 1;
        self.add(opened_for, now_ns)
    }

    fn add(&mut self, opened_for: u64, now_ns: u64) -> Id {
        let connection = Connection {
            command: Command {
                seq: opened_for,
                t_send_ns: 0,
                u: 0.0,
            },
            answer: None,
            opened_for,
            fresh: true,
            abandoned: false,
            since_ns: now_ns,
            resent: false,
            client: RoundTrip::first(0),
            plant: RoundTrip::first(0),
        };
        if let Some(id) = self.closed.pop() {
            self.all[id as usize] = connection;
            return id;
        }
        self.all.push(connection);
        // A client has as many connections as messages under way, at most some thousands.
        u32::try_from(self.all.len() - 1).unwrap_or(u32::MAX)
    }

    /// A packet of its handshake is sent again: what it takes from now on is its round trip.
    pub(crate) fn begins_again(&mut self, id: Id, now_ns: u64) {
        self.all[id as usize].since_ns = now_ns;
    }

    /// It is open: the message that it shall carry at once, if one waits.
    pub(crate) fn is_open(&mut self, id: Id, now_ns: u64) -> Option<Command> {
        let connection = &mut self.all[id as usize];
        let rtt_ns = now_ns - connection.since_ns;
        connection.client = RoundTrip::first(rtt_ns);
        connection.plant = RoundTrip::first(rtt_ns);
        let own = connection.opened_for;
        // Its own message may have gone on another meanwhile, or been given up.
        match self.waiting.iter().position(|command| command.seq == own) {
            Some(place) => self.waiting.remove(place),
            None => self.is_free(id, now_ns),
        }
    }

    /// A message goes out on it.
    pub(crate) fn sends(&mut self, id: Id, command: Command, now_ns: u64) {
        let connection = &mut self.all[id as usize];
        connection.command = command;
        if !connection.fresh {
            // What the plant saw: its answer was acknowledged with this, or before.
            let idle_ns = now_ns.saturating_sub(connection.since_ns);
            let seen_ns = connection.client.smoothed_ns() + idle_ns.min(ACKNOWLEDGE_NS);
            connection.plant.seen(seen_ns);
        }
        connection.since_ns = now_ns;
        connection.resent = false;
    }

    /// Its message was answered: the next that it shall carry at once, if one waits.
    pub(crate) fn is_answered(&mut self, id: Id, now_ns: u64) -> Option<Command> {
        let connection = &mut self.all[id as usize];
        if !connection.resent {
            connection.client.seen(now_ns - connection.since_ns);
        }
        connection.fresh = false;
        if self.keeping == Keeping::New {
            self.close(id);
            return None;
        }
        self.is_free(id, now_ns)
    }

    fn is_free(&mut self, id: Id, now_ns: u64) -> Option<Command> {
        let next = self.waiting.pop_front();
        if next.is_none() {
            self.all[id as usize].since_ns = now_ns;
            self.idle.push(id);
        }
        next
    }

    /// It is not used any more, and nothing is under way on it.
    pub(crate) fn close(&mut self, id: Id) {
        self.closed.push(id);
    }

    /// The client gives up a message: what is under way on its connection goes on without it, and
    /// one that waits is forgotten.
    pub(crate) fn give_up(&mut self, seq: u64, carrier: Option<Id>) {
        match carrier {
            Some(id) => self.all[id as usize].abandoned = true,
            None => self.waiting.retain(|command| command.seq != seq),
        }
    }

    /// The plant has answered what is under way on it.
    pub(crate) fn answers(&mut self, id: Id, answer: Answer) {
        self.all[id as usize].answer = Some(answer);
    }

    /// A connection.
    pub(crate) fn get(&self, id: Id) -> &Connection {
        &self.all[id as usize]
    }

    /// What is under way on it was lost: how long its sender waits for an acknowledgement.
    pub(crate) fn loses(&mut self, id: Id, by_plant: bool) -> u64 {
        let connection = &mut self.all[id as usize];
        connection.resent = true;
        match by_plant {
            true => connection.plant.timeout_ns(),
            false => connection.client.timeout_ns(),
        }
    }
}
