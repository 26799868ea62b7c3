//! Who may have a connection when there are more than places.
//!
//! A newcomer always gets a place: the one of the peer that has most, and of its connections one that has done
//! nothing for it, or not for long. A connection that moves the plant is never taken. So a controller gets in
//! beside a flood from another address, and beside one from its own.

use std::{
    cell::{Cell, RefCell},
    collections::{HashMap, VecDeque},
    net::{IpAddr, Ipv6Addr},
    rc::Rc,
};

use tokio::task::AbortHandle;

/// A connection moves the plant until its last command is this old.
const CONTROL_NS: u64 = 2_000_000_000;

/// All places.
pub(crate) struct Places {
    limit: usize,
    peers: RefCell<HashMap<IpAddr, Peer>>,
}

/// The connections of one address, in the order in which one is taken.
#[derive(Default)]
struct Peer {
    open: usize,
    queue: VecDeque<Rc<Place>>,
    /// When one of them last executed a command; all its places know it.
    commanded_ns: Rc<Cell<u64>>,
}

/// A connection's place.
#[derive(Default)]
pub(crate) struct Place {
    /// Whether a request was completed since it was last considered.
    is_used: Cell<bool>,
    /// When its last command was executed; 0 if none was.
    commanded_ns: Cell<u64>,
    peer_commanded_ns: Rc<Cell<u64>>,
    is_left: Cell<bool>,
    task: RefCell<Option<AbortHandle>>,
}

/// Gives the place back when it is dropped.
pub(crate) struct Seat {
    places: Rc<Places>,
    peer: IpAddr,
    pub(crate) place: Rc<Place>,
}

impl Places {
    pub(crate) fn new(limit: usize) -> Self {
        Self {
            limit,
            peers: RefCell::default(),
        }
    }

    /// A place for a connection from `address`; `None` if all others move the plant.
    pub(crate) fn enter(self: &Rc<Self>, address: IpAddr, now_ns: u64) -> Option<Seat> {
        let peer = network(address);
        let mut peers = self.peers.borrow_mut();
        let taken: usize = peers.values().map(|peer| peer.open).sum();
        if taken >= self.limit {
            let mut largest: Vec<_> = peers.values_mut().collect();
            largest.sort_unstable_by_key(|peer| std::cmp::Reverse(peer.open));
            let victim = largest.into_iter().find_map(|peer| peer.victim(now_ns))?;
            if let Some(task) = victim.task.take() {
                task.abort();
            }
        }
        let its = peers.entry(peer).or_default();
        let place = Rc::new(Place {
            peer_commanded_ns: Rc::clone(&its.commanded_ns),
            ..Place::default()
        });
        its.open += 1;
        its.queue.push_back(Rc::clone(&place));
        its.forget_left();
        drop(peers);
        Some(Seat {
            places: Rc::clone(self),
            peer,
            place,
        })
    }
}

impl Peer {
    /// Takes the place of the connection that can best be spared.
    fn victim(&mut self, now_ns: u64) -> Option<Rc<Place>> {
        // A connection that was used since is passed over once.
        for _ in 0..2 * self.queue.len() {
            let place = self.queue.pop_front()?;
            if place.is_left.get() {
                continue;
            }
            if place.is_used.take() || place.is_in_control(now_ns) {
                self.queue.push_back(place);
                continue;
            }
            place.is_left.set(true);
            self.open -= 1;
            return Some(place);
        }
        None
    }

    /// Forgets connections that have ended, so that the queue is at most twice as long as it must be.
    fn forget_left(&mut self) {
        if self.queue.len() > 2 * self.open + 16 {
            self.queue.retain(|place| !place.is_left.get());
        }
    }
}

impl Place {
    /// Whose task ends when the place is taken.
    pub(crate) fn belongs_to(&self, task: AbortHandle) {
        *self.task.borrow_mut() = Some(task);
    }

    /// A request was completed.
    pub(crate) fn on_answer(&self) {
        self.is_used.set(true);
    }

    /// A command was executed.
    pub(crate) fn on_command(&self, now_ns: u64) {
        self.commanded_ns.set(now_ns);
        self.peer_commanded_ns.set(now_ns);
    }

    /// When this connection or another of its peer last executed a command; 0 if none did.
    pub(crate) fn peer_commanded_ns(&self) -> u64 {
        self.peer_commanded_ns.get()
    }

    pub(crate) fn is_in_control(&self, now_ns: u64) -> bool {
        let commanded_ns = self.commanded_ns.get();
        commanded_ns > 0 && now_ns.saturating_sub(commanded_ns) < CONTROL_NS
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        // It keeps the room of a task that has ended.
        self.place.task.take();
        if self.place.is_left.replace(true) {
            return;
        }
        let mut peers = self.places.peers.borrow_mut();
        if let Some(peer) = peers.get_mut(&self.peer) {
            peer.open -= 1;
            if peer.open == 0 {
                peers.remove(&self.peer);
            }
        }
    }
}

/// Whose an address is: with IPv6, one machine has all of the last 64 bits.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(last: u8) -> IpAddr {
        [10, 0, 0, last].into()
    }

    fn is_taken(seat: &Seat) -> bool {
        seat.place.is_left.get()
    }

    #[test]
    fn a_newcomer_takes_the_place_that_did_least_and_never_one_in_control() {
        let places = Rc::new(Places::new(4));
        let enter = |now_ns| places.enter(address(1), now_ns).expect("a place");
        let s = 1_000_000_000;
        let loaded = enter(s);
        loaded.place.on_command(s);
        let (idle, used, fresh) = (enter(s), enter(s), enter(s));
        used.place.on_answer();
        let first = enter(s);
        assert!(is_taken(&idle) && !is_taken(&used) && !is_taken(&fresh));
        let second = enter(s);
        assert!(is_taken(&fresh) && !is_taken(&used));
        let third = enter(s);
        assert!(is_taken(&first) || is_taken(&used));
        assert!(!is_taken(&loaded));
        let flood: Vec<_> = (0..100).map(|_| enter(2 * s)).collect();
        assert!(is_taken(&second) && is_taken(&third) && !is_taken(&loaded));
        assert_eq!(flood.iter().filter(|seat| !is_taken(seat)).count(), 3);
        // It has not moved the plant for long, so that it is as any other.
        let later: Vec<_> = (0..4).map(|_| enter(4 * s)).collect();
        assert!(is_taken(&loaded));
        assert!(!later.iter().any(is_taken));
    }

    #[test]
    fn the_peer_with_most_connections_loses_one() {
        let places = Rc::new(Places::new(10));
        let one = places.enter(address(1), 1).expect("a place");
        let many: Vec<_> = (0..50)
            .map(|_| places.enter(address(2), 1).expect("a place"))
            .collect();
        let other = places.enter(address(3), 1).expect("a place");
        assert!(!is_taken(&one) && !is_taken(&other));
        assert_eq!(many.iter().filter(|seat| !is_taken(seat)).count(), 8);
    }

    #[test]
    fn all_in_control_leave_no_place_and_who_ends_leaves_one() {
        let places = Rc::new(Places::new(3));
        let mut held: Vec<_> = (0..3).filter_map(|_| places.enter(address(1), 1)).collect();
        held.iter().for_each(|seat| seat.place.on_command(1));
        assert!(places.enter(address(2), 1).is_none());
        held.pop();
        assert!(places.enter(address(2), 1).is_some());
        for _ in 0..1_000 {
            drop(places.enter(address(3), 1));
        }
        held.clear();
        assert!(places.peers.borrow().is_empty());
    }

    #[test]
    fn a_machine_with_many_addresses_is_one_peer() {
        let network = |text: &str| network(text.parse().expect("an address"));
        assert_eq!(network("2001:db8::1"), network("2001:db8::ffff:1"));
        assert_ne!(network("2001:db8::1"), network("2001:db8:0:1::1"));
        assert_eq!(network("::ffff:10.0.0.1"), address(1));
        assert_ne!(network("10.0.0.1"), network("10.0.0.2"));
    }
}
