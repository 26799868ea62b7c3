//! What a simulated run must be, whatever its setup; `loss` over links that lose packets, `fault` over
//! links with faults, `limit`
//! with echoes and over links with a rate limit.

mod fault;
mod limit;
mod loss;

use control::{
    Law, SampledPlant, largest_stable_blocking_round_trip_s, largest_stable_round_trip_s,
    loop_delay_ticks, preset, step_response,
};
use endpoint::{
    ArrivalOutcome, ArrivalRow, Connection, ControllerSettings, MessageOutcome, MessageRow, Mode,
    Outstanding, Preset, SampleTime, TickRow, Transport,
};
use link::{Epoch, Profile, Way};
use proptest::prelude::*;
use sim::{Echo, Outcome, Pool, Record, Setup, Spread, Timing, run};

const MS: u64 = 1_000_000;

#[derive(Default, PartialEq, Debug)]
struct Rows {
    ticks: Vec<TickRow>,
    arrivals: Vec<ArrivalRow>,
    messages: Vec<MessageRow>,
    echoes: Vec<(usize, Echo)>,
    packets: Vec<(Way, u64, u32)>,
}

impl Record for Rows {
    fn tick(&mut self, row: &TickRow) {
        self.ticks.push(*row);
    }

    fn arrival(&mut self, row: &ArrivalRow) {
        self.arrivals.push(*row);
    }

    fn message(&mut self, row: &MessageRow) {
        self.messages.push(*row);
    }

    fn echo(&mut self, series: usize, echo: &Echo) {
        self.echoes.push((series, *echo));
    }

    fn packet(&mut self, way: Way, t_ns: u64, bytes: u32) {
        self.packets.push((way, t_ns, bytes));
    }
}

impl Rows {
    /// The plant's output from the tick that took the first command.
    fn response(&self) -> Vec<f64> {
        let taken = self.ticks.iter().filter(|row| row.seq.is_some());
        taken.map(|row| row.y).collect()
    }
}

fn h(text: &str) -> SampleTime {
    text.parse().expect("a sample time")
}

fn profile(text: &str) -> Profile {
    let none = |name: &str| Err(format!("no trace {name}"));
    let (profile, findings) = Profile::read(text, "test", &none);
    profile.unwrap_or_else(|| panic!("{findings:?}"))
}

fn constant(rtt_ns: u64) -> Profile {
    let one_way_us = rtt_ns as f64 / 2e3;
    profile(&format!(
        "name = 'test'\nabout = 'x'\n[both.delay]\nbase = '{one_way_us}us'\n"
    ))
}

fn builtin(name: &str) -> Profile {
    profile(Profile::builtin(name).expect("built in"))
}

fn plant(h: SampleTime) -> SampledPlant {
    preset::paper_plant().sampled(h.ns()).expect("stable")
}

fn setup<'a>(
    profile: &'a Profile,
    settings: ControllerSettings,
    timing: &'a Timing,
    duration_ns: u64,
) -> Setup<'a> {
    let (plant, law) = (plant(settings.h).stepper(), preset::paper_pi().into());
    Setup {
        timing,
        epoch: Epoch::at_ns(1_000 * MS),
        plant_start_ns: 1_000 * MS + settings.h.ns() / 3,
        start_ns: 1_100 * MS,
        after_ns: 100 * MS,
        ..Setup::ideal(profile, settings, plant, law, duration_ns)
    }
}

fn closed(text: &str) -> ControllerSettings {
    Preset::PaperPython.settings(Mode::Closed, h(text))
}

fn simulate(setup: &Setup) -> (Rows, Outcome) {
    let mut rows = Rows::default();
    let outcome = run(setup, &mut rows).expect("a setup that can be simulated");
    (rows, outcome)
}

/// A machine that takes different times each time.
fn busy() -> Timing {
    let spread = |median: u32| {
        let mut times: Vec<u32> = (0..1000).map(|i| median / 2 + i * median / 1000).collect();
        Spread::of(&mut times)
    };
    Timing {
        late_ns: spread(30_000),
        up_ns: spread(80_000),
        down_ns: spread(90_000),
        opened_up_ns: spread(150_000),
        send_ns: 20_000,
        take_ns: 20_000,
        serve_ns: 15_000,
        clamp_ns: 0,
        player_ns: 30_000,
        hz: 250,
    }
}

#[test]
fn over_a_constant_round_trip_it_is_the_bare_loop_with_its_delay_in_ticks() {
    for (h_text, rtt_us) in [
        ("1ms", 500),
        ("1ms", 7_300),
        ("3ms", 2_000),
        ("3ms", 40_000),
    ] {
        let settings = closed(h_text);
        let h = settings.h;
        let link = constant(rtt_us * 1_000);
        let (rows, _) = simulate(&setup(&link, settings, &Timing::IDEAL, 4_000 * MS));
        let plant = plant(h);
        let delay = loop_delay_ticks(rtt_us * 1_000, h.ns());
        let ticks = 4_000 * MS / h.ns();
        let bare = step_response(&plant, preset::paper_pi(), 1.0, delay, ticks as usize);
        // Connections that have yet to be opened keep the first messages waiting, so the two are
        // alike from where the first round trips are over: in what they come to.
        let own = rows.response();
        let late = own.len().min(bare.len()) - 100;
        for k in late..late + 50 {
            assert!(
                (own[k] - bare[k]).abs() < 1e-3,
                "{h_text} {rtt_us} us, tick {k}: {} {}",
                own[k],
                bare[k]
            );
        }
    }
}

#[test]
fn on_loopback_it_is_the_bare_loop_bit_by_bit() {
    for h_text in ["1ms", "3ms"] {
        let settings = closed(h_text);
        let link = builtin("arima");
        let (rows, outcome) = simulate(&setup(&link, settings, &Timing::IDEAL, 2_000 * MS));
        let due = (2_000 * MS).div_ceil(settings.h.ns()) as usize;
        let bare = step_response(
            &plant(settings.h),
            preset::paper_pi(),
            1.0,
            loop_delay_ticks(0, settings.h.ns()),
            due,
        );
        assert_eq!(rows.response()[..due], bare[..]);
        assert_eq!(outcome.connections, 1);
    }
}

/// How the largest error of a response's end compares with that of its middle: below 1 it dies out.
fn growth(settings: ControllerSettings, rtt_ns: u64) -> f64 {
    let link = constant(rtt_ns);
    let (rows, _) = simulate(&setup(&link, settings, &Timing::IDEAL, 60_000 * MS));
    let y = rows.response();
    let part = |from: usize| {
        let part = &y[from..from + y.len() / 10];
        part.iter()
            .fold(0.0, |most: f64, y| most.max((y - 1.0).abs()))
    };
    part(y.len() * 4 / 5) / part(y.len() / 3)
}

#[test]
fn it_survives_as_long_a_constant_round_trip_as_the_margin_says() {
    for h_text in ["1ms", "3ms"] {
        let settings = closed(h_text);
        let (h_s, h_ns) = (settings.h.seconds(), settings.h.ns());
        let (plant, law) = (plant(settings.h), Law::from(preset::paper_pi()));
        let whole = plant
            .transfer_function()
            .and_then(|motor| motor.series(&law.transfer_function(h_s)?))
            .expect("finite and with the same h");
        let unlimited_s = largest_stable_round_trip_s(&whole).expect("stable without a network");
        let one_s = largest_stable_blocking_round_trip_s(&plant, &law)
            .expect("few states")
            .expect("stable without a network");
        for (outstanding, limit_s) in [
            (Outstanding::Unlimited, unlimited_s),
            (Outstanding::ONE, one_s),
        ] {
            let settings = ControllerSettings {
                outstanding,
                ..settings
            };
            let limit_ns = (limit_s * 1e9).round() as u64;
            let (inside, outside) = (
                growth(settings, limit_ns - h_ns / 2),
                growth(settings, limit_ns + h_ns / 2),
            );
            assert!(
                inside < 1.0,
                "{outstanding} at {h_text}: dies out, {inside}"
            );
            assert!(outside > 1.0, "{outstanding} at {h_text}: grows, {outside}");
        }
    }
}

#[test]
fn over_a_web_socket_nothing_overtakes_and_nothing_is_lost() {
    let lossy = profile(
        "name = \"lossy\"\nabout = \"loses\"\n[both.delay]\nbase = \"20ms\"\n\
         [both.loss.random]\nshare = \"5%\"\n",
    );
    let settings = ControllerSettings {
        transport: Transport::WebSocket,
        ..closed("3ms")
    };
    let (rows, outcome) = simulate(&setup(&lossy, settings, &busy(), 6_000 * MS));
    assert!(rows.arrivals.is_sorted_by_key(|row| row.seq));
    assert_eq!(rows.arrivals.len() as u64, outcome.counts.sent);
    assert_eq!(outcome.counts.answered, outcome.counts.sent);
    assert!(outcome.resent > 100);
    assert_eq!(outcome.connections, 1);
    // Some 40 ms and another round trip for what is lost: no timer of 200 ms has to end.
    let longest_ns = rows
        .messages
        .iter()
        .filter_map(|row| Some(row.t_receive_ns? - row.t_send_ns?))
        .max();
    assert!(longest_ns < Some(240 * MS), "{longest_ns:?}");
}

#[test]
fn a_datagram_goes_for_itself_and_what_is_lost_never_comes() {
    let lossy = profile(
        "name = \"lossy\"\nabout = \"loses\"\n[both.delay]\nbase = \"20ms\"\n\
         [both.loss.random]\nshare = \"5%\"\n",
    );
    let settings = ControllerSettings {
        transport: Transport::Udp,
        timeout_ns: 300 * MS,
        ..closed("3ms")
    };
    let (rows, outcome) = simulate(&setup(&lossy, settings, &Timing::IDEAL, 60_000 * MS));
    let counts = outcome.counts;
    assert_eq!((counts.sent, outcome.resent), (20_000, 0));
    assert_eq!(counts.answered + counts.timeout, counts.sent);
    // A twentieth each way: 5 % and 9.75 %, by three standard deviations.
    let lost_up = counts.sent - outcome.arrivals;
    assert!((907..=1093).contains(&lost_up), "{lost_up}");
    assert!((1824..=2076).contains(&counts.timeout), "{counts:?}");
    // None waits for another, nor for a handshake.
    let answered = rows.messages.iter().filter_map(|row| {
        let round_trip_ns = row.t_receive_ns? - row.t_send_ns?;
        Some(round_trip_ns)
    });
    assert!(answered.into_iter().all(|ns| ns == 40 * MS));
}

#[test]
fn a_dead_link_ends_every_message_by_its_time_out() {
    let link = profile(
        "name = 'dead'\nabout = 'x'\n[both.delay]\nbase = '1ms'\n[both.loss.random]\nshare = '100%'\n",
    );
    let mut settings = closed("10ms");
    settings.timeout_ns = 300 * MS;
    let (rows, outcome) = simulate(&setup(&link, settings, &Timing::IDEAL, 2_000 * MS));
    assert_eq!(outcome.counts.due, 200);
    assert_eq!(outcome.counts.timeout, 200);
    assert!(rows.arrivals.is_empty());
    assert!(
        rows.messages
            .iter()
            .all(|row| row.outcome == MessageOutcome::Timeout)
    );
}

#[test]
fn the_python_client_s_messages_wait_for_their_own_connections() {
    // 30 ms around and a message every 3 ms: the first has a connection, and is back at 30 ms. The
    // second began to open one at 3 ms, which is open at 33: in a shared pool it goes at 30 on the
    // first's, in its own at 33.
    let link = constant(30 * MS);
    let arrivals_ms = |pool| {
        let alone = setup(&link, closed("3ms"), &Timing::IDEAL, 60 * MS);
        let (rows, _) = simulate(&Setup { pool, ..alone });
        let arrival = |seq| rows.arrivals.iter().find(|row| row.seq == seq);
        [0, 1, 10].map(|seq| (arrival(seq).expect("arrived").t_arrive_ns - 1_100 * MS) / MS)
    };
    assert_eq!(arrivals_ms(Pool::Shared)[..2], [15, 45]);
    // What is due at 30 finds the first's idle, and comes before those that are opening.
    assert_eq!(arrivals_ms(Pool::Own), [15, 48, 45]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_deadline_has_one_row_and_every_message_one_end(
        topology in prop::sample::select(vec!["arima", "buccoo", "couva", "diego-lan", "diego-vpn"]),
        seed in any::<u64>(),
        h_us in 500_u64..50_000,
        outstanding in prop::sample::select(vec!["1", "2", "unlimited"]),
        connection in prop::sample::select(Connection::ALL.to_vec()),
        floor_ms in prop::sample::select(vec![0, 10]),
    ) {
        let link = builtin(topology);
        let timing = busy();
        let mut settings = closed(&format!("{h_us}us"));
        settings.outstanding = outstanding.parse::<Outstanding>().expect("a word");
        settings.connection = connection;
        let mut setup = setup(&link, settings, &timing, 1_500 * MS);
        setup.seed = seed;
        setup.timer_floor_ns = floor_ms * MS;
        let (rows, outcome) = simulate(&setup);
        let (again, other) = simulate(&setup);
        prop_assert_eq!(&rows, &again);
        prop_assert_eq!(outcome, other);

        let counts = outcome.counts;
        prop_assert_eq!(counts.due, counts.sent + counts.missed);
        prop_assert_eq!(counts.sent, counts.answered + counts.timeout + counts.failed);
        prop_assert_eq!(counts.due as usize, rows.messages.len());
        let mut seqs: Vec<u64> = rows.messages.iter().map(|row| row.seq).collect();
        seqs.sort_unstable();
        prop_assert!(seqs.iter().enumerate().all(|(i, seq)| i as u64 == *seq));
        prop_assert_eq!(outcome.arrivals as usize, rows.arrivals.len());
        prop_assert!(counts.answered <= outcome.arrivals && outcome.arrivals <= counts.sent);

        prop_assert!(rows.ticks.windows(2).all(|pair| pair[1].k == pair[0].k + 1));
        prop_assert!(rows.arrivals.windows(2).all(|pair| pair[0].t_arrive_ns <= pair[1].t_arrive_ns));
        let is_applied = |row: &ArrivalRow| row.outcome == ArrivalOutcome::Applied;
        prop_assert!(rows.arrivals.iter().all(is_applied));
        for row in &rows.messages {
            let (Some(send), Some(arrive), Some(receive)) =
                (row.t_send_ns, row.t_arrive_ns, row.t_receive_ns)
            else {
                continue;
            };
            prop_assert!(row.t_due_ns <= send && send <= arrive && arrive <= receive);
        }
    }

    #[test]
    fn another_seed_is_another_run(seed in any::<u64>()) {
        let link = builtin("buccoo");
        let timing = busy();
        let mut one = setup(&link, closed("3ms"), &timing, 300 * MS);
        one.seed = seed;
        let mut other = one.clone();
        other.seed = seed ^ 1;
        prop_assert_ne!(simulate(&one).0, simulate(&other).0);
    }
}
