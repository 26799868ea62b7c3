//! Commands by UDP.

use std::{
    net::{SocketAddr, UdpSocket},
    time::Duration,
};

use endpoint::{Acknowledgement, Lease, PlantSettings, State, checksum};
use plant::{Config, Ready};
use proptest::{
    prelude::*,
    test_runner::{Config as Cases, TestRunner},
};

use crate::support::{PATIENCE, begin, config, observe, until, with_config, with_plant};

fn with_udp(out: &std::path::Path, lease: Lease) -> Config {
    let usual = config(out);
    Config {
        settings: PlantSettings {
            udp: true,
            lease,
            ..usual.settings
        },
        ..usual
    }
}

struct Peer(UdpSocket);

impl Peer {
    fn of(address: SocketAddr) -> Self {
        Self::from(1, address)
    }

    /// From 127.0.0.`host`, which is another address of this machine.
    fn from(host: u8, address: SocketAddr) -> Self {
        let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, host], 0))).expect("a socket");
        socket.connect(address).expect("an address");
        Self(socket)
    }

    fn say(&self, bytes: &[u8]) {
        self.0.send(bytes).expect("room");
    }

    /// What comes within a time.
    fn hear(&self, within: Duration) -> Option<String> {
        self.0.set_read_timeout(Some(within)).expect("a time");
        let mut room = [0; 2048];
        let bytes = self.0.recv(&mut room).ok()?;
        Some(String::from_utf8_lossy(&room[..bytes]).into_owned())
    }

    fn ask(&self, text: &str) -> String {
        self.say(text.as_bytes());
        self.hear(PATIENCE).expect("an answer")
    }
}

#[test]
fn both_modes_answer_as_over_http_and_what_is_no_command_gets_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with_udp(folder.path(), Lease::None);
    let report = with_config(config, |Ready { address, .. }| {
        let peer = Peer::of(address);
        let state = peer.ask("mode=closed&seq=7&t_send_ns=5&u=0.5");
        let state: State = state.parse().expect("a state");
        assert_eq!((state.seq, state.u.first), (7, 0.5));
        let answer = peer.ask("mode=open&seq=8&t_send_ns=5&u=9");
        let answer: Acknowledgement = answer.parse().expect("an answer");
        assert_eq!(answer.seq, 8);
        let signed = checksum::signed("seq=9&t_send_ns=5&u=0.5");
        let signed = peer.ask(&format!("mode=closed&{signed}"));
        assert!(checksum::checked(&signed, true).is_ok(), "{signed}");
        let long = format!("mode=closed&u=1&{}", "0".repeat(1024));
        let wrong: [&[u8]; 10] = [
            b"",
            b"\n",
            b"hello",
            b"u=1",
            b"mode=closed",
            b"mode=closed&u=NaN",
            b"mode=closed&u=1&crc=12345678",
            b"mode=closed&u=1\xff",
            b"GET /closed?u=1 HTTP/1.1\r\nHost: a\r\n\r\n",
            long.as_bytes(),
        ];
        for bytes in wrong {
            peer.say(bytes);
        }
        assert!(peer.hear(Duration::from_millis(300)).is_none());
        assert_eq!(observe(address).u, 0.5);
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.refused), (3, 10));
}

#[test]
fn the_lease_is_an_address_s_here_too_and_a_session_cannot_be_had() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with_udp(folder.path(), Lease::Address);
    with_config(config, |Ready { address, .. }| {
        let (first, second) = (Peer::of(address), Peer::from(2, address));
        assert!(first.ask("mode=closed&u=1").starts_with("seq="));
        second.say(b"mode=closed&u=2");
        assert!(second.hear(Duration::from_millis(200)).is_none());
        assert_eq!(observe(address).u, 1.0);
        until("the first has been silent", || {
            second.say(b"mode=closed&u=2");
            second.hear(Duration::from_millis(50)).is_some()
        });
        assert_eq!(observe(address).u, 2.0);
    })
    .expect("a run without errors");
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_config(with_udp(folder.path(), Lease::None), |facts| {
        let token = begin(facts.address, "a browser");
        let peer = Peer::of(facts.address);
        for text in ["u=3".to_owned(), format!("session={token}&u=3")] {
            peer.say(format!("mode=closed&{text}").as_bytes());
        }
        assert!(peer.hear(Duration::from_millis(200)).is_none());
        assert_eq!(observe(facts.address).u, 0.0);
    })
    .expect("a run without errors");
}

#[test]
fn a_plant_that_is_not_told_to_has_no_such_port() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        UdpSocket::bind(address).expect("nobody has it");
    })
    .expect("a run without errors");
}

#[test]
fn whatever_a_datagram_has_only_a_command_is_answered_and_shortly() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = with_udp(folder.path(), Lease::None);
    let report = with_config(config, |Ready { address, .. }| {
        let peer = Peer::of(address);
        let texts = prop_oneof![
            prop::collection::vec(any::<u8>(), 0..1400),
            "(mode=(open|closed)&)?((u|seq|t_send_ns|crc|mode)=[-0-9a-z.,]{0,9}&?){0,4}"
                .prop_map(String::into_bytes),
        ];
        let mut runner = TestRunner::new(Cases::with_cases(300));
        let ran = runner.run(&texts, |bytes| {
            peer.say(&bytes);
            // Its answer comes last.
            peer.say(b"mode=open&seq=18446744073709551615&u=0");
            let (mut answers, mut is_last) = (0, false);
            while !is_last {
                let answer = peer.hear(PATIENCE).expect("an answer");
                is_last = answer.starts_with("seq=18446744073709551615&");
                answers += 1;
                prop_assert!(
                    answer.starts_with("seq=") && answer.len() <= 512,
                    "{answer}"
                );
            }
            let is_command = bytes.starts_with(b"mode=");
            prop_assert!(answers == 1 || is_command, "{answers}");
            Ok(())
        });
        ran.expect("no answer to what is none");
    });
    report.expect("a run without errors");
}
