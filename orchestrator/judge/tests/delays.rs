//! How much delay of how many messages is found, and how often a clean run is called delayed.
//!
//! Runs are made in virtual time from what real clients and kernels took (`timings.toml` of the back-end, measured on
//! a quiet machine), then some messages are delayed. `cargo test -p webloop-judge --test delays -- --nocapture` prints
//! how many of each kind were found.
#![allow(clippy::print_stdout, reason = "its table is what it is for")]

use std::collections::BTreeMap;

use endpoint::{
    ArrivalRow, Connection, ControllerSettings, MessageOutcome, MessageRow, Outstanding, TickRow,
    Transport,
};
use judge::{Busy, Connecting, Hits, LinkFault, Still, Terms};
use link::{Profile, Timeline, Way};
use plan::evidence::{Messages, Watched};
use plan::system::System;
use plan::{Cell, Client, Instead, Plan, ProfileText};
use sim::{EPOCH, Record, Setup, Timing};

const MS: u64 = 1_000_000;
const LINKS: [&str; 4] = ["arima", "buccoo", "diego-lan", "diego-vpn"];

fn profile(name: &str) -> Profile {
    let source = Profile::builtin(name).expect("built in");
    let (profile, _) = Profile::read(source, name, &|_| Err("no trace".into()));
    profile.expect("a profile")
}

/// What a client and its machine took at a sample time.
fn timing(client: &str, h: &str) -> Timing {
    let text = include_str!("../../backend/src/timings.toml");
    let all: BTreeMap<String, BTreeMap<String, Timing>> = toml::from_str(text).expect("measured");
    let own = &all[client];
    own.get(h).expect("of this h").clone()
}

/// Who sends: a client of webloop's, or a program with and without rows of its own.
#[derive(Clone, Copy, Debug)]
enum Who {
    Webloop(Client),
    Stranger,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Delayed {
    Nothing,
    /// Of each packet of these ways, this share by this much.
    Share(f64, f64, &'static [Way]),
    /// The first packet of each handshake.
    Syn(f64),
    /// None, but this share of the answers never comes.
    Lost(f64),
    /// None, but a message is given up soon.
    Impatient,
    /// None, but the stream has no more messages under way unacknowledged than these.
    Window(usize),
}

#[derive(Default)]
struct Rows {
    messages: Vec<MessageRow>,
    arrivals: Vec<ArrivalRow>,
}

impl Record for Rows {
    fn tick(&mut self, _: &TickRow) {}
    fn arrival(&mut self, row: &ArrivalRow) {
        self.arrivals.push(*row);
    }
    fn message(&mut self, row: &MessageRow) {
        self.messages.push(*row);
    }
}

/// `SplitMix64` (Steele, Lea and Flood).
struct Draws(u64);

impl Draws {
    fn is_within(&mut self, share: f64) -> bool {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        ((z >> 11) as f64) < share * (1_u64 << 53) as f64
    }
}

#[derive(Clone, Copy)]
struct Kind {
    h: &'static str,
    who: Who,
    connection: Connection,
    transport: Transport,
    delayed: Delayed,
}

impl Kind {
    /// A cell of three seconds.
    fn cell(&self, seed: u64) -> Cell {
        let h = self.h;
        let source = format!(
            "name = \"t\"\n[[cells]]\ntopology = \"buccoo\"\nclient = \"native\"\nmode = \"closed\"\nh = \"{h}\"\n\
             duration = \"3s\"\n"
        );
        let text = |name: &str| {
            let source = Profile::builtin(name).expect("built in").to_owned();
            Ok(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        let plan = Plan::resolve(&source, "t.toml", &Instead::default(), text).expect("a plan");
        let cell = plan.cells.into_iter().next().expect("a cell");
        let (client, outstanding) = match self.who {
            Who::Webloop(client) => (client, Outstanding::Unlimited),
            Who::Stranger => (
                Client::Own("mine".parse().expect("a name")),
                Outstanding::ONE,
            ),
        };
        let settings = ControllerSettings {
            connection: self.connection,
            transport: self.transport,
            outstanding,
            timeout_ns: match self.delayed {
                Delayed::Impatient => 30 * MS,
                _ => cell.settings.timeout_ns,
            },
            ..cell.settings
        };
        Cell {
            client,
            settings,
            link_seed: seed,
            ..cell
        }
    }

    /// The evidence against a run over a link.
    fn faults(&self, link: &str, seed: u64) -> Vec<LinkFault> {
        let (messages, terms) = self.held(link, seed);
        judge::message::faults(&messages, &terms)
    }

    /// What the messages of a run over a link say, and what they are judged by.
    fn held(&self, link: &str, seed: u64) -> (Messages, Terms) {
        let (profile, cell) = (profile(link), self.cell(seed));
        let (system, timing) = (
            System::paper(),
            timing(
                match self.who {
                    Who::Webloop(client) => client.spec().name,
                    Who::Stranger => "python",
                },
                self.h,
            ),
        );
        let h = cell.settings.h;
        let start_ns = EPOCH.t_ns(plan::START_AT);
        let model = system
            .at(h)
            .expect("a plant")
            .plant
            .stepper_from(system.x0());
        let (law, _) = system.law_at(h).expect("a law");
        let mut rows = Rows::default();
        let setup = Setup {
            seed,
            epoch: EPOCH,
            start_ns,
            timing: &timing,
            ..Setup::ideal(&profile, cell.settings, model, law, cell.duration_ns)
        };
        let outcome = sim::run(&setup, &mut rows).expect("a run");
        self.delay(&mut rows, seed);
        if let Delayed::Window(window) = self.delayed {
            hold_back(&mut rows, window, Timeline::new(&profile, seed, EPOCH));
        }
        if matches!(self.who, Who::Stranger) {
            // The plant's rows of it.
            for row in rows
                .messages
                .iter_mut()
                .filter(|row| row.t_arrive_ns.is_some())
            {
                (row.t_receive_ns, row.outcome) = (None, MessageOutcome::Arrived);
            }
        }
        let watched = Watched {
            ran_ms: 160.0,
            ..Watched::default()
        };
        let h_ms = h.ns() as f64 * 1e-6;
        let terms = Terms {
            timeline: Timeline::new(&profile, seed, EPOCH),
            run_ns: 0..start_ns + 20_000 * MS,
            before_ns: 0,
            fall_ns: 0,
            baseline_ms: [f64::from(timing.player_ns) * 1e-6; 2],
            allowance: cell.client.spec().allowance,
            connecting: Connecting::of(cell.client, &cell.settings, Some(outcome.connections)),
            has_rate: false,
            timeout_ms: cell.settings.timeout_ns as f64 * 1e-6,
            busy: Busy::of(Some(&watched), &[], &[]),
            h_ms,
            still: Still::default(),
            hits: Hits::default(),
        };
        let messages = judge::message::hold(&rows.messages, &rows.arrivals, &terms);
        (messages, terms)
    }

    /// Makes messages late.
    fn delay(&self, rows: &mut Rows, seed: u64) {
        let mut draws = Draws(seed);
        let is_new = self.connection == Connection::New;
        for row in &mut rows.messages {
            let mut packets = |way: Way, count: u32| -> u64 {
                let Delayed::Share(share, ms, ways) = self.delayed else {
                    return 0;
                };
                let hit = (0..count).filter(|_| ways.contains(&way) && draws.is_within(share));
                hit.count() as u64 * (ms * MS as f64) as u64
            };
            let mut up_ns = packets(Way::Up, 1);
            if is_new {
                up_ns += packets(Way::Up, 1) + packets(Way::Down, 1);
                up_ns += match self.delayed {
                    Delayed::Syn(ms) => (ms * MS as f64) as u64,
                    _ => 0,
                };
            }
            let down_ns = packets(Way::Down, 1);
            row.t_arrive_ns = row.t_arrive_ns.map(|t_ns| t_ns + up_ns);
            row.t_receive_ns = row.t_receive_ns.map(|t_ns| t_ns + up_ns + down_ns);
            if let Delayed::Lost(share) = self.delayed
                && row.t_receive_ns.is_some()
                && draws.is_within(share)
            {
                (row.t_receive_ns, row.outcome) = (None, MessageOutcome::Timeout);
            }
        }
        let of_seq: BTreeMap<u64, u64> = rows
            .messages
            .iter()
            .filter_map(|row| Some((row.seq, row.t_arrive_ns?)))
            .collect();
        for row in &mut rows.arrivals {
            row.t_arrive_ns = of_seq.get(&row.seq).copied().unwrap_or(row.t_arrive_ns);
        }
    }

    /// In how many of so many runs, each over the next link, something is found.
    fn found(&self, times: u64) -> u64 {
        let found = (0..times).filter(|seed| {
            // Over the VPN a program that waits for each answer sends too few messages to say anything.
            let links = match self.who {
                Who::Stranger => &LINKS[..3],
                Who::Webloop(_) => &LINKS[..],
            };
            let link = links[*seed as usize % links.len()];
            let faults = self.faults(link, 1_000 + seed);
            let is_clean = matches!(self.delayed, Delayed::Nothing | Delayed::Impatient);
            if is_clean && !faults.is_empty() {
                println!("{:?} {link} {seed}: {faults:?}", self.who);
            }
            !faults.is_empty()
        });
        found.count() as u64
    }
}

/// Delays messages on the way up as TCP's sender does: while so many segments are under way, what comes next waits for
/// an acknowledgement and leaves with it in one segment.
fn hold_back(rows: &mut Rows, window: usize, mut link: Timeline) {
    let mut back = link.clone();
    let mut acknowledged_ns: Vec<u64> = Vec::new();
    let (mut enters_ns, mut last_ns) = (0, 0);
    for (row, arrival) in rows.messages.iter_mut().zip(&mut rows.arrivals) {
        let (Some(send_ns), Some(arrive_ns)) = (row.t_send_ns, row.t_arrive_ns) else {
            break;
        };
        let mut leaves_ns = |t_ns: u64| t_ns + link.passage(Way::Up, t_ns, 90).delay_ns;
        let own_ns = arrive_ns.saturating_sub(leaves_ns(send_ns));
        let is_new = send_ns > enters_ns;
        if is_new {
            let free = acknowledged_ns.len().checked_sub(window);
            enters_ns = send_ns.max(free.map_or(0, |at| acknowledged_ns[at]));
        }
        last_ns = (leaves_ns(enters_ns) + own_ns).max(last_ns);
        let mut back_ns = |t_ns: u64| t_ns + back.passage(Way::Down, t_ns, 90).delay_ns;
        let receive_ns = [back_ns(arrive_ns), back_ns(last_ns)];
        row.t_receive_ns = row
            .t_receive_ns
            .map(|t_ns| t_ns - receive_ns[0].min(t_ns) + receive_ns[1]);
        (row.t_arrive_ns, arrival.t_arrive_ns) = (Some(last_ns), last_ns);
        if is_new {
            acknowledged_ns.push(receive_ns[1]);
        }
    }
}

const CLIENTS: [Who; 4] = [
    Who::Webloop(Client::Native),
    Who::Webloop(Client::Python),
    Who::Webloop(Client::Chromium),
    Who::Stranger,
];

/// Clean runs of each client, with connections kept and new.
const CLEAN: u64 = 50;

#[test]
fn at_most_one_clean_run_in_a_hundred_is_called_delayed_whoever_sends() {
    let mut all = 0;
    for who in CLIENTS {
        for connection in [Connection::Keep, Connection::New] {
            let kind = Kind {
                h: "10ms",
                who,
                connection,
                transport: Transport::Http,
                delayed: Delayed::Nothing,
            };
            let found = kind.found(CLEAN);
            println!("{who:?} {connection}: {found} of {CLEAN} clean");
            all += found;
        }
    }
    assert!(all * 100 <= 8 * CLEAN, "{all} of {}", 8 * CLEAN);
}

#[test]
fn whatever_carries_them_clean_messages_are_not_called_delayed_and_delayed_or_lost_ones_are() {
    for transport in [
        Transport::Json,
        Transport::Tcp,
        Transport::Udp,
        Transport::WebSocket,
    ] {
        let clean = Kind {
            h: "10ms",
            who: Who::Webloop(Client::Native),
            connection: Connection::Keep,
            transport,
            delayed: Delayed::Nothing,
        };
        let found = clean.found(CLEAN);
        println!("{transport}: {found} of {CLEAN} clean");
        assert!(found <= 1, "{transport}: {found} of {CLEAN}");
        let delayed = Delayed::Share(0.2, 5.0, UP);
        let found = Kind { delayed, ..clean }.found(20);
        assert!(found >= 19, "{transport}: {found} of 20");
    }
    // Nothing that is not sent again is lost on a machine.
    let lost = Kind {
        h: "10ms",
        who: Who::Webloop(Client::Native),
        connection: Connection::Keep,
        transport: Transport::Udp,
        delayed: Delayed::Lost(0.1),
    };
    let found = lost.found(20);
    assert_eq!(found, 20, "lost");
    // An answer that came too late to be taken was not lost.
    let impatient = Kind {
        delayed: Delayed::Impatient,
        ..lost
    };
    let found = impatient.found(CLEAN);
    assert!(found <= 1, "impatient: {found} of {CLEAN}");
}

#[test]
fn what_waits_for_the_first_window_of_its_stream_is_not_called_delayed_and_what_waits_longer_is() {
    let stream = |window| Kind {
        h: "3ms",
        who: Who::Webloop(Client::Native),
        connection: Connection::Keep,
        transport: Transport::Tcp,
        delayed: Delayed::Window(window),
    };
    let found = |window| {
        let stream = stream(window);
        let runs = (0..20).filter(|seed| !stream.faults("diego-vpn", 1_000 + seed).is_empty());
        runs.count()
    };
    for window in [10, 14, 20] {
        let found = found(window);
        assert!(found <= 1, "{window} under way: {found} of 20");
    }
    let found = found(3);
    assert!(found >= 19, "3 under way: {found} of 20");
}

const UP: &[Way] = &[Way::Up];
const DOWN: &[Way] = &[Way::Down];
const BOTH: &[Way] = &[Way::Up, Way::Down];

/// Runs of each share, delay, way and sort of connection.
const TIMES: u64 = 2;

#[test]
fn a_twentieth_of_all_messages_delayed_by_a_millisecond_is_found_of_webloop_s_own_controller() {
    let (mut cells, mut all) = (0, 0);
    for connection in [Connection::Keep, Connection::New] {
        for ways in [UP, DOWN, BOTH] {
            for share in [0.05, 0.1, 0.5, 0.8] {
                for ms in [1.0, 2.0, 5.0, 9.0] {
                    let delayed = Delayed::Share(share, ms, ways);
                    let who = CLIENTS[0];
                    let found = Kind {
                        h: "3ms",
                        who,
                        connection,
                        transport: Transport::Http,
                        delayed,
                    }
                    .found(TIMES);
                    println!("native {connection} {share} {ms} ms {ways:?}: {found} of {TIMES}");
                    (cells, all) = (cells + TIMES, all + found);
                }
            }
        }
    }
    println!("native: {all} of {cells}");
    assert!(all * 20 >= cells * 19, "{all} of {cells}");
}

#[test]
fn each_kind_that_was_complete_before_is_found_in_twenty_of_twenty_runs() {
    let native = CLIENTS[0];
    let (keep, new) = (Connection::Keep, Connection::New);
    for (connection, delayed) in [
        (keep, Delayed::Share(0.5, 5.0, UP)),
        (keep, Delayed::Share(0.8, 9.0, UP)),
        (keep, Delayed::Share(0.1, 9.0, BOTH)),
        (new, Delayed::Share(1.0, 3.0, UP)),
        (new, Delayed::Share(1.0, 3.0, DOWN)),
        (new, Delayed::Syn(5.0)),
    ] {
        let found = Kind {
            h: "10ms",
            who: native,
            connection,
            transport: Transport::Http,
            delayed,
        }
        .found(20);
        println!("{connection} {delayed:?}: {found} of 20");
        assert_eq!(found, 20, "{connection} {delayed:?}");
    }
}

/// What a manifest says that it would have shown, in twice as many messages: of a share that is drawn, some are quicker
/// than the quickest tenth by themselves.
#[test]
fn what_is_said_to_show_is_found_whoever_sends() {
    for who in CLIENTS {
        let clean = Kind {
            h: "10ms",
            who,
            connection: Connection::Keep,
            transport: Transport::Http,
            delayed: Delayed::Nothing,
        };
        let found = (0..20).filter(|seed| {
            let link = LINKS[*seed as usize % 3];
            let (messages, _) = clean.held(link, 1_000 + seed);
            let shows = messages.up.shows.expect("enough of them");
            let (share, ms) = ((2.0 * shows.share).min(0.8), shows.later_ms);
            let delayed = Delayed::Share(share, ms, UP);
            !Kind { delayed, ..clean }
                .faults(link, 1_000 + seed)
                .is_empty()
        });
        let found = found.count();
        println!("{who:?}: {found} of 20");
        assert!(found >= 19, "{who:?}: {found} of 20");
    }
}

#[test]
fn what_python_a_page_and_a_program_of_one_s_own_do_not_explain_is_found_of_them_too() {
    for (who, ms) in [(CLIENTS[1], 3.0), (CLIENTS[2], 9.0), (CLIENTS[3], 3.0)] {
        for share in [0.2, 0.5, 0.8] {
            let delayed = Delayed::Share(share, ms, UP);
            let connection = Connection::Keep;
            let found = Kind {
                h: "10ms",
                who,
                connection,
                transport: Transport::Http,
                delayed,
            }
            .found(20);
            println!("{who:?} {share} {ms} ms: {found} of 20");
            assert!(found >= 19, "{who:?} {share} {ms} ms: {found} of 20");
        }
    }
}
