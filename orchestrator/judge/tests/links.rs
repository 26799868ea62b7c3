//! Messages made up from a link's own function of time, then tampered with: the right link is borne
//! out by them, and each thing that is done to it is found and named.

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow};
use judge::message::hold;
use judge::{LinkFault, Still, Terms};
use link::certificate::Pause;
use link::{Epoch, Profile, Timeline, Way};
use plan::Client;
use plan::evidence::Messages;
use proptest::prelude::*;

const MS: u64 = 1_000_000;
const EPOCH_NS: u64 = 1_000 * MS;
const START_NS: u64 = EPOCH_NS + 1_300 * MS;
/// What the client, the kernels and the plant take each way.
const COST_NS: u64 = 150_000;

fn profile(name: &str) -> Profile {
    let source = Profile::builtin(name).expect("a profile that is built in");
    read(source)
}

fn read(source: &str) -> Profile {
    let (profile, findings) = Profile::read(source, "test", &|_| Err("no trace".into()));
    profile.unwrap_or_else(|| panic!("{findings:?}"))
}

/// What is done to a way's packets.
#[derive(Clone, Copy, Default)]
struct Tampering {
    /// They do not go through the link at all.
    around: bool,
    /// So many more are lost, one in this number; 0 is none.
    one_in_lost: u64,
    /// They take so much longer.
    delay_ns: u64,
}

/// Two seconds of messages, one each h, over the link of `seed`.
fn messages(
    profile: &Profile,
    seed: u64,
    h_ns: u64,
    [up, down]: [Tampering; 2],
) -> (Vec<MessageRow>, Vec<ArrivalRow>) {
    const RESEND_NS: u64 = 224 * MS;
    let mut link = Timeline::new(profile, seed, Epoch::at_ns(EPOCH_NS));
    let mut cross = |way, tampering: Tampering, t_ns: u64, seq: u64| {
        if tampering.around {
            return t_ns + COST_NS;
        }
        let mut enters_ns = t_ns + COST_NS / 3;
        // By the number, so that the same are lost whatever the seed is.
        if tampering.one_in_lost > 0 && seq % tampering.one_in_lost == 7 {
            enters_ns += RESEND_NS;
        }
        // As `state_at` has it: packets of two messages may be asked for out of order.
        while link.state_at(way, enters_ns).lost {
            enters_ns += RESEND_NS;
        }
        enters_ns + link.state_at(way, enters_ns).delay_ns + 2 * COST_NS / 3 + tampering.delay_ns
    };
    let (mut rows, mut arrivals) = (Vec::new(), Vec::new());
    for seq in 0..2_000 * MS / h_ns {
        let t_send_ns = START_NS + seq * h_ns;
        let t_arrive_ns = cross(Way::Up, up, t_send_ns, seq);
        let t_receive_ns = cross(Way::Down, down, t_arrive_ns, seq);
        rows.push(MessageRow {
            seq,
            t_due_ns: t_send_ns,
            t_send_ns: Some(t_send_ns),
            t_receive_ns: Some(t_receive_ns),
            t_arrive_ns: Some(t_arrive_ns),
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome: MessageOutcome::Answered,
            y_seq: None,
        });
        arrivals.push(ArrivalRow {
            n: seq,
            seq,
            t_send_ns: Some(t_send_ns),
            t_arrive_ns,
            tick: 0,
            u: 0.0,
            outcome: ArrivalOutcome::Applied,
        });
    }
    (rows, arrivals)
}

/// As a client reads them that takes `each_ns` over an answer: one after the other, in the order in
/// which they come.
fn read_in_turn(rows: &mut [MessageRow], each_ns: u64) {
    let mut came: Vec<&mut u64> = rows
        .iter_mut()
        .filter_map(|row| row.t_receive_ns.as_mut())
        .collect();
    came.sort_unstable();
    let mut free_ns = 0;
    for t_ns in came {
        *t_ns = free_ns.max(*t_ns);
        free_ns = *t_ns + each_ns;
    }
}

fn judged(
    profile: &Profile,
    seed: u64,
    rows: &(Vec<MessageRow>, Vec<ArrivalRow>),
    client: Client,
) -> (Messages, Vec<LinkFault>) {
    judged_on(0.0, Still::default(), profile, seed, rows, client)
}

/// On a machine whose player costs that much a way, and whose processors stood still then.
fn judged_on(
    cost_ms: f64,
    still: Still,
    profile: &Profile,
    seed: u64,
    rows: &(Vec<MessageRow>, Vec<ArrivalRow>),
    client: Client,
) -> (Messages, Vec<LinkFault>) {
    let terms = Terms {
        timeline: Timeline::new(profile, seed, Epoch::at_ns(EPOCH_NS)),
        run_ns: EPOCH_NS..EPOCH_NS + 20_000 * MS,
        before_ns: 0,
        fall_ns: 0,
        baseline_ms: [cost_ms; 2],
        allowance: client.spec().allowance,
        connecting: judge::Connecting::Pool { accepted: None },
        has_rate: profile.has_rate(),
        timeout_ms: 5_000.0,
        busy: judge::Busy::default(),
        h_ms: (rows.0[1].t_due_ns - rows.0[0].t_due_ns) as f64 * 1e-6,
        still,
        hits: judge::Hits::default(),
    };
    let messages = hold(&rows.0, &rows.1, &terms);
    let faults = judge::message::faults(&messages, &terms);
    (messages, faults)
}

const LINKS: [&str; 5] = ["arima", "buccoo", "couva", "diego-lan", "diego-vpn"];
const NOTHING: Tampering = Tampering {
    around: false,
    one_in_lost: 0,
    delay_ns: 0,
};

/// What comes out together, a slow reader takes in turn. How late that makes a message is known to some milliseconds, so
/// one run in some thousand is an alarm; asked is one in a hundred.
#[test]
fn a_stall_that_lets_go_of_hundreds_at_once_makes_no_link_late_nor_less_lossy() {
    const RUNS: u64 = 100;
    let profile = profile("couva");
    let alarms = (0..RUNS).filter_map(|seed| {
        let clients = [
            (Client::Native, 60),
            (Client::Python, 600),
            (Client::Chromium, 1_200),
        ];
        let faults = clients.map(|(client, each_us)| {
            let mut rows = messages(&profile, seed, 3 * MS, [NOTHING; 2]);
            read_in_turn(&mut rows.0, each_us * 1_000);
            judged(&profile, seed, &rows, client).1
        });
        let all = faults.concat();
        (!all.is_empty()).then(|| format!("seed {seed}: {all:?}"))
    });
    let alarms: Vec<String> = alarms.collect();
    assert!(alarms.len() as u64 * 100 <= RUNS, "{alarms:#?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn the_link_that_was_asked_for_is_borne_out(seed in any::<u64>(), which in 0..5_usize) {
        let profile = profile(LINKS[which]);
        let rows = messages(&profile, seed, 3 * MS, [NOTHING; 2]);
        let (messages, faults) = judged(&profile, seed, &rows, Client::Native);
        prop_assert!(faults.is_empty(), "{} {faults:?} {messages:?}", LINKS[which]);
        prop_assert_eq!(messages.up.quicker + messages.down.quicker, 0);
    }

    #[test]
    fn messages_that_go_around_are_found_on_each_way(seed in any::<u64>(), which in 1..5_usize, way in 0..3_usize) {
        let profile = profile(LINKS[which]);
        let around = Tampering { around: true, ..NOTHING };
        let ways = [[around, NOTHING], [NOTHING, around], [around, around]][way];
        let rows = messages(&profile, seed, 3 * MS, ways);
        let (_, faults) = judged(&profile, seed, &rows, Client::Firefox);
        prop_assert!(faults.iter().any(|fault| !fault.by_lateness && fault.words.contains("around it")), "{faults:?}");
    }

    #[test]
    fn another_seed_s_link_is_found(seed in any::<u64>(), which in 1..5_usize) {
        let profile = profile(LINKS[which]);
        let rows = messages(&profile, seed, 3 * MS, [NOTHING; 2]);
        let (messages, faults) = judged(&profile, seed.wrapping_add(1), &rows, Client::Native);
        prop_assert!(!faults.is_empty(), "{} {messages:?}", LINKS[which]);
    }

    #[test]
    fn one_packet_in_a_hundred_that_is_lost_beside_the_link_is_found(seed in any::<u64>(), which in 0..4_usize, client in 0..2_usize) {
        // Not couva: while it stalls, and it may for all of these two seconds, a resend is not seen.
        let which = [0, 1, 3, 4][which];
        let profile = profile(LINKS[which]);
        let lossy = Tampering { one_in_lost: 100, ..NOTHING };
        let rows = messages(&profile, seed, 3 * MS, [lossy; 2]);
        let (messages, faults) = judged(&profile, seed, &rows, [Client::Native, Client::Python][client]);
        prop_assert!(faults.iter().any(|fault| fault.words.contains("resent") || fault.words.contains("lost")),
            "{} {faults:?} {messages:?}", LINKS[which]);
    }

    #[test]
    fn a_page_whose_clock_is_a_millisecond_off_has_not_gone_around_its_link(seed in any::<u64>(), which in 0..5_usize, off_us in -1_000..1_000_i64) {
        let profile = profile(LINKS[which]);
        let (mut rows, arrivals) = messages(&profile, seed, 3 * MS, [NOTHING; 2]);
        for row in &mut rows {
            for t_ns in [&mut row.t_send_ns, &mut row.t_receive_ns].into_iter().flatten() {
                *t_ns = t_ns.saturating_add_signed(off_us * 1_000);
            }
        }
        let (_, faults) = judged(&profile, seed, &(rows, arrivals), Client::Firefox);
        prop_assert!(!faults.iter().any(|fault| fault.words.contains("quicker")), "{} {faults:?}", LINKS[which]);
    }

    #[test]
    fn two_milliseconds_more_are_found_for_a_program_and_ten_for_a_page(seed in any::<u64>(), which in 0..4_usize, way in 0..2_usize) {
        // Not couva, which may stall for all of these two seconds.
        let which = [0, 1, 3, 4][which];
        let profile = profile(LINKS[which]);
        for (client, delay_ms) in [(Client::Native, 2), (Client::Python, 2), (Client::Chromium, 10)] {
            let late = Tampering { delay_ns: delay_ms * MS, ..NOTHING };
            let ways = [[late, NOTHING], [NOTHING, late]][way];
            let rows = messages(&profile, seed, 3 * MS, ways);
            let (messages, faults) = judged(&profile, seed, &rows, client);
            // Nor another link in two seconds that are nearly one stall: then fewer messages say how late they are
            // than a tenth of them can be told by.
            prop_assume!([messages.up, messages.down][way].judged >= 15);
            prop_assert!(faults.iter().any(|fault| fault.words.contains("more than the link")),
                "{} {client} {faults:?} {messages:?}", LINKS[which]);
        }
    }
}

/// A link of 3 ms each way with a fault that comes again and again while messages cross.
fn faulty(fault: &str) -> Profile {
    read(&format!(
        "name = \"f\"\nabout = \"\"\n[both]\ndelay = {{ base = \"3ms\", hold = \"20ms\", spread.uniform = {{ min = \"0ms\", \
         max = \"2ms\" }} }}\n{fault}"
    ))
}

const WHEN: &str = "[[fault]]\nat = \"1500ms\"\nfor = \"150ms\"\nevery = \"400ms\"\n";
const FAULTS: [&str; 6] = [
    "down = true",
    "delay = \"40ms\"",
    "loss = \"60%\"",
    "duplicate = \"30%\"",
    "reorder = \"30%\"\nby = \"30ms\"",
    "corrupt = \"60%\"",
];

/// What a reset or another port does to messages: those under way while a fault breaks connections are
/// lost, or sent again on a new connection some round trips later.
fn broken(profile: &Profile, seed: u64) -> (Vec<MessageRow>, Vec<ArrivalRow>) {
    let mut link = Timeline::new(profile, seed, Epoch::at_ns(EPOCH_NS));
    let (mut rows, mut arrivals) = messages(profile, seed, 3 * MS, [NOTHING; 2]);
    for row in &mut rows {
        let (Some(send_ns), Some(back_ns)) = (row.t_send_ns, row.t_receive_ns) else {
            continue;
        };
        if link.broken_ns(back_ns) < Some(send_ns) {
            continue;
        }
        if row.seq % 2 == 0 {
            (row.t_arrive_ns, row.t_receive_ns) = (None, None);
            row.outcome = MessageOutcome::Failed;
        } else {
            // Its first arrival stays in the plant's record.
            let again_ns = row.t_arrive_ns.unwrap_or_default() + 250 * MS;
            (row.t_arrive_ns, row.t_receive_ns) = (Some(again_ns), Some(again_ns + 6 * MS));
            arrivals.push(ArrivalRow {
                n: 0,
                seq: row.seq,
                t_send_ns: Some(send_ns),
                t_arrive_ns: again_ns,
                tick: 0,
                u: 0.0,
                outcome: ArrivalOutcome::Applied,
            });
        }
    }
    (rows, arrivals)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn a_link_with_faults_is_borne_out_and_one_without_them_is_not_taken_for_it(seed in any::<u64>(), which in 0..6_usize) {
        let (with, without) = (faulty(&format!("{WHEN}{}\n", FAULTS[which])), faulty(""));
        // So far apart that the slots of one say nothing of the next.
        let rows = messages(&with, seed, 10 * MS, [NOTHING; 2]);
        let (messages_of, faults) = judged(&with, seed, &rows, Client::Native);
        prop_assert!(faults.is_empty(), "{} {faults:?} {messages_of:?}", FAULTS[which]);
        let bare = messages(&without, seed, 10 * MS, [NOTHING; 2]);
        let (_, faults) = judged(&with, seed, &bare, Client::Native);
        // A duplicate is nothing to a message.
        prop_assert_eq!(faults.is_empty(), which == 3, "{}: {:?}", FAULTS[which], faults);
        let (_, faults) = judged(&without, seed, &rows, Client::Native);
        prop_assert_eq!(faults.is_empty(), which == 3, "{}: {:?}", FAULTS[which], faults);
    }

    #[test]
    fn a_message_whose_connection_a_fault_broke_is_no_evidence_and_others_are_as_ever(seed in any::<u64>(), rebinds in any::<bool>()) {
        let effect = if rebinds { "rebind = true" } else { "reset = true" };
        let profile = faulty(&format!("[[fault]]\nat = \"1700ms\"\nfor = \"50ms\"\nevery = \"5s\"\n{effect}\n"));
        let rows = broken(&profile, seed);
        let (messages_of, faults) = judged(&profile, seed, &rows, Client::Native);
        prop_assert!(faults.is_empty(), "{faults:?} {messages_of:?}");
        prop_assert_eq!(messages_of.unborne, 0);
        // Without such a fault they would be.
        let (_, faults) = judged(&faulty(""), seed, &rows, Client::Native);
        prop_assert!(!faults.is_empty());
        // And what is done to the link beside its fault is found.
        for tampering in [
            Tampering { around: true, ..NOTHING },
            Tampering { delay_ns: 3 * MS, ..NOTHING },
            Tampering { one_in_lost: 40, ..NOTHING },
        ] {
            let rows = messages(&profile, seed, 3 * MS, [tampering; 2]);
            let (messages_of, faults) = judged(&profile, seed, &rows, Client::Native);
            prop_assert!(!faults.is_empty(), "{effect} {messages_of:?}");
        }
    }
}

#[test]
fn a_slow_machine_is_allowed_more_and_no_machine_three_milliseconds() {
    let profile = profile("buccoo");
    for (delay_us, cost_ms, is_found) in
        [(1_400, 0.02, true), (1_400, 0.1, false), (4_000, 1.0, true)]
    {
        let late = Tampering {
            delay_ns: delay_us * 1_000,
            ..NOTHING
        };
        let rows = messages(&profile, 1, 3 * MS, [late; 2]);
        let still = Still::default();
        let (_, faults) = judged_on(cost_ms, still, &profile, 1, &rows, Client::Native);
        let found = faults
            .iter()
            .any(|fault| fault.words.contains("more than the link"));
        assert_eq!(found, is_found, "{delay_us} us, {cost_ms} ms: {faults:?}");
    }
}

#[test]
fn what_waits_for_a_processor_that_stands_still_is_not_late() {
    let profile = profile("buccoo");
    let (mut rows, arrivals) = messages(&profile, 1, 3 * MS, [NOTHING; 2]);
    // Of both processors, at times the same.
    let ends_ns = [1, 2, 3, 4].map(|n| START_NS + n * 400 * MS);
    let gap = |t_ns, ns| Pause { t_ns, ns };
    let of_both = |t_ns| [gap(t_ns, 40 * MS), gap(t_ns - 5 * MS, 20 * MS)];
    let gaps: Vec<Pause> = ends_ns.into_iter().flat_map(of_both).collect();
    for t_ns in rows.iter_mut().filter_map(|row| row.t_receive_ns.as_mut()) {
        let held_until = ends_ns
            .into_iter()
            .find(|end_ns| (end_ns - 40 * MS..*end_ns).contains(t_ns));
        *t_ns = held_until.unwrap_or(*t_ns);
    }
    let rows = (rows, arrivals);
    let on = |still| judged_on(0.0, still, &profile, 1, &rows, Client::Native).1;
    let faults = on(Still::default());
    assert!(
        faults.iter().any(|fault| fault.words.contains("late")),
        "{faults:?}"
    );
    let faults = on(Still::of(&gaps));
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn an_answer_that_the_plant_knows_nothing_of_is_not_its_own() {
    let profile = profile("buccoo");
    let (rows, mut arrivals) = messages(&profile, 1, 3 * MS, [NOTHING; 2]);
    arrivals[10].t_arrive_ns += 5_000;
    arrivals.remove(20);
    let (messages, faults) = judged(&profile, 1, &(rows, arrivals), Client::Native);
    assert_eq!(messages.unborne, 2);
    assert!(
        faults
            .iter()
            .any(|fault| !fault.by_lateness && fault.words.contains("2 answers"))
    );
}

#[test]
fn stamps_from_anywhere_are_counted_and_end_in_no_panic() {
    for name in LINKS {
        let profile = profile(name);
        let (mut rows, mut arrivals) = messages(&profile, 1, 3 * MS, [NOTHING; 2]);
        for (n, t_ns) in [0, 1, u64::MAX, u64::MAX - 1].into_iter().enumerate() {
            rows[n].t_send_ns = Some(t_ns);
            rows[10 + n].t_receive_ns = Some(t_ns);
            rows[20 + n].t_arrive_ns = Some(t_ns);
            rows[30 + n].t_due_ns = t_ns;
            arrivals[40 + n].t_arrive_ns = t_ns;
        }
        let (messages, faults) = judged(&profile, 1, &(rows, arrivals), Client::Native);
        assert_eq!((messages.outside, messages.unborne), (12, 4), "{name}");
        assert!(
            faults
                .iter()
                .any(|fault| fault.words.contains("outside the time"))
        );
    }
}
