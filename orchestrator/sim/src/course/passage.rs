//! A message in transit: its packets enter the link, are lost and sent again, come out, and wait for
//! a thread at either end.

use endpoint::{Carriage, Loss, Model};
use link::Way;

use super::{Course, Waiting};
use crate::connection::Id;
use crate::record::Record;

/// Length of a handshake's IP packets: IP header, TCP header, options.
const HANDSHAKE_BYTES: u32 = 60;
/// Length of an IP packet that only acknowledges.
const ACKNOWLEDGEMENT_BYTES: u32 = 52;

/// A packet, by its purpose; its contents are in its connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packet {
    /// Opens a connection.
    Syn,
    /// The plant's kernel accepts the connection.
    SynAck,
    /// A command on its way up.
    Request,
    /// An answer on its way down.
    Answer,
}

/// An echo, by the number of its series and its own number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ping {
    pub(super) series: u8,
    pub(super) seq: u32,
}

/// An event in the queue that is not a packet's coming out of the link.
#[derive(Debug, Clone, Copy)]
pub(super) enum Event {
    /// A lost packet is sent again, for the `tries`-th time.
    Again(Id, Packet, u16),
    /// The timer of a packet that was not lost ends: its `tries`-th sending, in this turn of its connection.
    Unheard(Id, Packet, u16, u32),
    /// A duplicate of a packet that has already arrived comes out of the link this way.
    Twice(Way),
    /// The plant's thread is free for the next request.
    PlantFree,
    /// The client's thread is free for the next answer.
    ClientFree,
    /// An echo is due to be sent.
    EchoDue(Ping),
    /// An echo has reached the plant's kernel.
    EchoReached(Ping),
}

impl<R: Record, M: Model + Clone> Course<'_, R, M> {
    /// Sends a packet for the `tries`-th time. If it is lost, it is sent again when its sender's timer ends.
    /// A timer that ends although nothing was lost has an effect only where packets queue.
    // Always inlined, since what is sent is then known: most of what is asked here is about that.
    #[inline(always)]
    pub(super) fn transmit(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        let (way, bytes) = self.shape(packet);
        let crossed = self.pass(way, now_ns, bytes);
        if let Some(stream) = &mut self.stream {
            let delay_ns = crossed.map(|out| out.t_ns - now_ns);
            stream.sends(way, id, tries == 1, delay_ns);
        }
        let Some(out) = crossed else {
            self.is_lost(id, packet, tries, now_ns);
            return;
        };
        if out.is_twice {
            self.queue.push(out.t_ns, Event::Twice(way));
        }
        if self.connections.is_timed() {
            if packet == Packet::Request {
                self.connections.gets_through(id, now_ns, self.wheel);
            }
            if self.wire.has_rate() {
                self.waits_to_hear(id, packet, tries, now_ns);
            }
        }
        let timing = self.timing;
        let takes_ns = match packet {
            Packet::Syn | Packet::SynAck => 0,
            Packet::Answer => timing.down_ns.draw(&mut self.random),
            Packet::Request => {
                if self.connections.get(id).fresh {
                    timing.opened_up_ns.draw(&mut self.random)
                } else {
                    timing.up_ns.draw(&mut self.random)
                }
            }
        };
        // However long a machine takes over packets, it takes them in the order of their arrival.
        let read_ns = self.wire.read_ns(way, out.t_ns, takes_ns);
        self.queue.push_packet(way, read_ns, (id, packet));
    }

    /// The same for packets that are rare: one function for all of them.
    #[inline(never)]
    pub(super) fn transmit_rarely(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        self.transmit(id, packet, tries, now_ns);
    }

    /// A packet is lost: it is sent again when its sender's timer ends, unless it is a datagram.
    #[cold]
    fn is_lost(&mut self, id: Id, packet: Packet, tries: u16, now_ns: u64) {
        if self.carriage == Carriage::Datagrams {
            // It never comes: its place is free when its message ends.
            self.connections.loses(id, packet == Packet::Answer);
            return;
        }
        self.outcome.resent += 1;
        let again_ns = match &self.stream {
            Some(stream) if matches!(packet, Packet::Request | Packet::Answer) => {
                stream.again_ns(now_ns, self.wheel)
            }
            _ => {
                self.connections.loses(id, packet == Packet::Answer);
                self.rings_again_ns(id, packet, tries, now_ns)
            }
        };
        let again = Event::Again(id, packet, tries.saturating_add(1));
        self.queue.push(again_ns, again);
    }

    /// A packet's direction and length.
    #[inline]
    pub(super) fn shape(&self, packet: Packet) -> (Way, u32) {
        let [up_bytes, down_bytes] = self.message_bytes;
        match packet {
            Packet::Syn => (Way::Up, HANDSHAKE_BYTES),
            Packet::SynAck => (Way::Down, HANDSHAKE_BYTES),
            Packet::Request => (Way::Up, up_bytes),
            Packet::Answer => (Way::Down, down_bytes),
        }
    }

    /// A packet has reached the program or the kernel that it is for, which may stand still.
    #[inline]
    pub(super) fn arrives(&mut self, way: Way, id: Id, packet: Packet, now_ns: u64) {
        let [controller, plant] = self.frozen;
        let over_ns = match packet {
            Packet::SynAck | Packet::Answer => controller.over_ns(now_ns),
            Packet::Request => plant.over_ns(now_ns),
            // The plant's kernel answers it.
            Packet::Syn => now_ns,
        };
        if over_ns > now_ns {
            self.queue.push_packet(way, over_ns, (id, packet));
            return;
        }
        match packet {
            Packet::Syn => self.transmit_rarely(id, Packet::SynAck, 1, now_ns),
            Packet::SynAck => {
                self.acknowledges(now_ns);
                if let Some(command) = self.connections.on_open(id, now_ns) {
                    self.carries(id, &command, now_ns);
                }
            }
            Packet::Request | Packet::Answer if self.stream.is_some() => {
                self.arrives_in_stream(way, id, now_ns);
            }
            Packet::Request => self.reaches_plant(id, now_ns),
            Packet::Answer => {
                self.connections.hears(id);
                self.reaches_client(id, now_ns);
            }
        }
    }

    /// A message is there on the connection that all share: it is read, and those that waited for it.
    #[inline(never)]
    fn arrives_in_stream(&mut self, way: Way, id: Id, now_ns: u64) {
        if let Some(stream) = &mut self.stream {
            stream.arrives(way, id);
        }
        while let Some(id) = self.stream.as_mut().and_then(|stream| stream.reads(way)) {
            match way {
                Way::Up => self.reaches_plant(id, now_ns),
                Way::Down => self.reaches_client(id, now_ns),
            }
        }
    }

    /// What becomes of an event now: it is put off if the end that it is for stands still.
    pub(super) fn happens(&mut self, now_ns: u64, event: Event) {
        let [controller, plant] = self.frozen;
        let over_ns = match event {
            Event::ClientFree => controller.over_ns(now_ns),
            Event::PlantFree => plant.over_ns(now_ns),
            // The rest is done by kernels.
            _ => now_ns,
        };
        if over_ns > now_ns {
            self.queue.push(over_ns, event);
            return;
        }
        match event {
            Event::Again(id, packet, tries) => {
                if matches!(packet, Packet::Syn | Packet::SynAck) {
                    self.connections.begins_again(id, now_ns);
                }
                self.transmit_rarely(id, packet, tries, now_ns);
            }
            Event::Unheard(id, packet, tries, turn) => {
                if self.connections.turn(id) == Some(turn) {
                    self.sends_in_vain(id, packet, tries, now_ns);
                }
            }
            Event::Twice(way) => self.acknowledges_twice(way, now_ns),
            Event::EchoDue(ping) => self.sends_echo(ping),
            Event::EchoReached(ping) => self.turns_echo(ping, now_ns),
            Event::PlantFree => {
                if let Some(id) = self.at_plant.pop_front() {
                    self.serves(id, now_ns);
                }
                if !self.at_plant.is_empty() {
                    self.plant_busy();
                }
            }
            Event::ClientFree => {
                if now_ns < self.client_free_ns {
                    // The client has sent something in between.
                    self.client_busy(self.client_free_ns);
                    return;
                }
                if let Some(id) = self.at_client.pop_front() {
                    self.attends(id, now_ns);
                }
                if !self.at_client.is_empty() {
                    self.client_busy(self.client_free_ns.max(now_ns));
                }
            }
        }
    }

    /// The client's kernel acknowledges something with a packet of its own. Its only effect is that
    /// it may delay other packets.
    #[inline]
    fn acknowledges(&mut self, now_ns: u64) {
        if self.wire.has_rate() {
            let _ = self.cross(Way::Up, now_ns, ACKNOWLEDGEMENT_BYTES);
        }
    }

    /// The plant's thread takes its next request when it is free.
    fn plant_busy(&mut self) {
        let free_ns = self.plant_free_ns;
        self.queue.push(free_ns, Event::PlantFree);
    }

    /// The client's thread takes its next answer when it is free.
    fn client_busy(&mut self, free_ns: u64) {
        self.queue.push(free_ns, Event::ClientFree);
    }

    /// A request has reached the plant, whose thread may be busy with another.
    #[inline]
    fn reaches_plant(&mut self, id: Id, now_ns: u64) {
        if now_ns >= self.plant_free_ns {
            self.serves(id, now_ns);
        } else {
            if self.at_plant.is_empty() {
                self.plant_busy();
            }
            self.at_plant.push_back(id);
        }
    }

    /// An answer has reached the client, whose thread may be busy with another.
    #[inline]
    fn reaches_client(&mut self, id: Id, now_ns: u64) {
        if now_ns >= self.client_free_ns {
            self.attends(id, now_ns);
        } else {
            if self.at_client.is_empty() {
                self.client_busy(self.client_free_ns);
            }
            self.at_client.push_back(id);
        }
    }

    /// The client's thread turns to an answer.
    fn attends(&mut self, id: Id, now_ns: u64) {
        if self.connections.get(id).abandoned {
            self.connections.close(id);
        } else {
            self.takes(id, now_ns);
        }
    }

    /// The plant takes a command and answers.
    fn serves(&mut self, id: Id, now_ns: u64) {
        self.plant_free_ns = now_ns + u64::from(self.timing.serve_ns);
        let connection = self.connections.get_mut(id);
        let (row, answer) = self.plant.command(self.mode, &connection.command, now_ns);
        self.outcome.arrivals += 1;
        self.record.arrival(&row);
        if connection.abandoned {
            self.connections.close(id);
        } else {
            connection.answer = Some(answer);
            self.transmit(id, Packet::Answer, 1, now_ns);
        }
    }

    /// The client takes an answer.
    fn takes(&mut self, id: Id, now_ns: u64) {
        self.client_free_ns = now_ns + u64::from(self.timing.take_ns);
        let answer = self.connections.get(id).answer.as_ref();
        if let Some(row) = answer.and_then(|answer| self.controller.answered(answer, now_ns)) {
            self.last_end_ns = now_ns;
            self.record.message(&row);
        }
        if self.connections.acknowledges_at_once(id) {
            self.acknowledges(now_ns);
        }
        if let Some(command) = self.connections.on_answer(id, now_ns, self.wheel) {
            self.carries(id, &command, now_ns);
        }
        if self.waiting == Waiting::Answer {
            self.wait(now_ns);
        }
    }

    /// The oldest timeout is due, and its message has timed out, unless it has ended.
    pub(super) fn runs_out(&mut self, now_ns: u64) {
        // Those of messages that have ended are dropped only here, many at once, not one by one as they end.
        let oldest = self.controller.oldest_under_way().unwrap_or(u64::MAX);
        while self.terms.front().is_some_and(|term| term.seq < oldest) {
            self.terms.pop_front();
        }
        self.term_ns = self.next_term_ns();
        if self.term_ns > now_ns {
            return;
        }
        let Some(term) = self.terms.pop_front() else {
            return;
        };
        self.term_ns = self.next_term_ns();
        if let Some(row) = self.controller.lost(term.seq, Loss::Timeout, now_ns) {
            self.last_end_ns = now_ns;
            self.record.message(&row);
            self.connections.give_up(term.seq, term.carrier);
            let lost = term.carrier.filter(|id| {
                self.carriage == Carriage::Datagrams && self.connections.has_lost(*id)
            });
            if let Some(id) = lost {
                self.connections.close(id);
            }
            if self.waiting == Waiting::Answer {
                self.wait(now_ns);
            }
        }
    }
}
