//! A message's passage: packets that enter the link, are lost and sent again, come out, and wait
//! for a thread at either end.

use endpoint::Loss;
use link::Way;

use super::{Course, Waiting};
use crate::connection::Id;
use crate::record::Record;
use crate::retransmission::{handshake_pause_ns, pause_ns};

/// IP packets of a handshake: header, TCP header, options.
const HANDSHAKE_BYTES: u32 = 60;
/// A request, and an answer, with their HTTP heads.
const REQUEST_BYTES: u32 = 260;
const ANSWER_BYTES: u32 = 240;
/// Either as a text of a WebSocket.
const TEXT_BYTES: u32 = 120;

/// A packet, by what it does; what it carries is its connection's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packet {
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
pub(super) enum Event {
    /// A packet is with the program, or the kernel, that it is for.
    Arrived(Id, Packet),
    /// A lost packet is sent for another time.
    Again(Id, Packet, u16),
    /// The plant's thread is free for the next request.
    PlantFree,
    /// The client's thread is free for the next answer.
    ClientFree,
}

impl<R: Record> Course<'_, R> {
    /// Sends a packet for the `tries`-th time. What is lost is sent again when its sender's timer
    /// ends; a timer that ends although nothing was lost changes nothing.
    pub(super) fn transmit(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        let (way, bytes) = match (packet, &self.stream) {
            (Packet::Syn, _) => (Way::Up, HANDSHAKE_BYTES),
            (Packet::SynAck, _) => (Way::Down, HANDSHAKE_BYTES),
            (Packet::Request, None) => (Way::Up, REQUEST_BYTES),
            (Packet::Answer, None) => (Way::Down, ANSWER_BYTES),
            (Packet::Request, Some(_)) => (Way::Up, TEXT_BYTES),
            (Packet::Answer, Some(_)) => (Way::Down, TEXT_BYTES),
        };
        let crossed_ns = self.wire.cross(way, now_ns, bytes);
        if let Some(stream) = &mut self.stream {
            stream.sends(
                way,
                id,
                tries == 1,
                crossed_ns.map(|out_ns| out_ns - now_ns),
            );
        }
        if let Some(out_ns) = crossed_ns {
            let timing = self.timing;
            let takes_ns = match packet {
                Packet::Syn | Packet::SynAck => 0,
                Packet::Answer => timing.down_ns.draw(&mut self.random),
                Packet::Request => match self.connections.get(id).fresh {
                    true => timing.opened_up_ns.draw(&mut self.random),
                    false => timing.up_ns.draw(&mut self.random),
                },
            };
            // Whatever a machine takes over packets, it takes them in the order in which they come.
            let read_ns = self.wire.read_ns(way, out_ns, takes_ns);
            self.queue.push(read_ns, Event::Arrived(id, packet));
            return;
        }
        self.outcome.resent += 1;
        let pause_ns = match (packet, &self.stream) {
            (Packet::Syn | Packet::SynAck, _) => handshake_pause_ns(tries),
            (_, Some(stream)) => stream.pause_ns(),
            (Packet::Request, None) => pause_ns(self.connections.loses(id, false), tries),
            (Packet::Answer, None) => pause_ns(self.connections.loses(id, true), tries),
        };
        self.queue.push(
            now_ns + pause_ns,
            Event::Again(id, packet, tries.saturating_add(1)),
        );
    }

    pub(super) fn happens(&mut self, now_ns: u64, event: Event) {
        match event {
            Event::Arrived(id, Packet::Syn) => self.transmit(id, Packet::SynAck, 1, now_ns),
            Event::Arrived(id, Packet::SynAck) => {
                if let Some(command) = self.connections.is_open(id, now_ns) {
                    self.carries(id, command, now_ns);
                }
            }
            Event::Arrived(id, Packet::Request) => match &mut self.stream {
                None => self.reaches_plant(id, now_ns),
                Some(stream) => {
                    stream.arrives(Way::Up, id);
                    while let Some(id) = self.reads(Way::Up) {
                        self.reaches_plant(id, now_ns);
                    }
                }
            },
            Event::Arrived(id, Packet::Answer) => match &mut self.stream {
                None => self.reaches_client(id, now_ns),
                Some(stream) => {
                    stream.arrives(Way::Down, id);
                    while let Some(id) = self.reads(Way::Down) {
                        self.reaches_client(id, now_ns);
                    }
                }
            },
            Event::Again(id, packet, tries) => {
                if matches!(packet, Packet::Syn | Packet::SynAck) {
                    self.connections.begins_again(id, now_ns);
                }
                self.transmit(id, packet, tries, now_ns);
            }
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
                    self.attends(id, now_ns);
                }
                if !self.at_client.is_empty() {
                    let free_ns = self.client_free_ns.max(now_ns);
                    self.queue.push(free_ns, Event::ClientFree);
                }
            }
        }
    }

    fn reads(&mut self, way: Way) -> Option<Id> {
        self.stream.as_mut()?.reads(way)
    }

    /// A request is with the plant, whose thread may be at another.
    fn reaches_plant(&mut self, id: Id, now_ns: u64) {
        if now_ns >= self.plant_free_ns {
            self.serves(id, now_ns);
        } else {
            if self.at_plant.is_empty() {
                self.queue.push(self.plant_free_ns, Event::PlantFree);
            }
            self.at_plant.push_back(id);
        }
    }

    /// An answer is with the client, whose thread may be at another.
    fn reaches_client(&mut self, id: Id, now_ns: u64) {
        if now_ns >= self.client_free_ns {
            self.attends(id, now_ns);
        } else {
            if self.at_client.is_empty() {
                self.queue.push(self.client_free_ns, Event::ClientFree);
            }
            self.at_client.push_back(id);
        }
    }

    /// The client's thread turns to an answer.
    fn attends(&mut self, id: Id, now_ns: u64) {
        match self.connections.get(id).abandoned {
            true => self.connections.close(id),
            false => self.takes(id, now_ns),
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
    pub(super) fn runs_out(&mut self) {
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
