//! What a plant promises whatever it is sent: its input stays within its limits, what is not finite is said so,
//! and silence ends in the safe state.

use endpoint::{
    Action, ArrivalOutcome, Hold, Inbox, Late, Mode, Model, PlantSettings, Process, Request,
    SampleTime, Signals, Surrounded, Surroundings,
};
use proptest::prelude::*;

const MS: u64 = 1_000_000;

fn h() -> SampleTime {
    SampleTime::try_new(MS).expect("1 ms")
}

/// Random numbers that need no crate: splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// An input as a hostile or broken controller may write it.
    fn word(&mut self) -> String {
        const WORDS: [&str; 12] = [
            "NaN", "inf", "-inf", "1e308", "-1e308", "1e309", "5e-324", "-0", "", "1,2", "0x1",
            "0.5",
        ];
        match self.next() % 8 {
            0 => WORDS[(self.next() % 12) as usize].to_owned(),
            1 => format!("{}", f64::from_bits(self.next())),
            2 => format!("{:e}", f64::from_bits(self.next())),
            _ => format!("{}", (self.next() % 2001) as f64 / 100.0 - 10.0),
        }
    }
}

/// A pendulum that stands on its head: left alone it leaves the finite within seconds. Both of its states are
/// outputs, so that nothing hides.
struct Pendulum([f64; 2]);

impl Model for Pendulum {
    fn step(&mut self, u: Signals, _: u64) -> Signals {
        let [angle, speed] = self.0;
        let y = Signals::from(self.0);
        self.0 = [angle + 0.1 * speed, speed + 0.1 * (9.81 * angle + u.first)];
        y
    }

    fn at_rest(&self) -> Signals {
        [0.0, 0.0].into()
    }

    fn reset(&mut self) -> bool {
        self.0 = [0.0; 2];
        true
    }
}

/// In release ten million commands, in some seconds.
#[test]
fn whatever_is_commanded_the_input_keeps_its_limits_and_the_state_is_finite_or_said_not_to_be() {
    const LIMIT: f64 = 2.0;
    let commands = if cfg!(debug_assertions) {
        300_000
    } else {
        10_000_000
    };
    let settings = PlantSettings {
        late: Late::Drop,
        hold: "3ms then ramp 5ms".parse().expect("a hold"),
        max_age_ns: Some(2 * MS),
        ..PlantSettings::new(h())
    };
    let surroundings = Surroundings {
        limits: (-LIMIT, LIMIT),
        rate_per_s: 500.0,
        ..Surroundings::default()
    };
    let model = Surrounded::new(Pendulum([0.0; 2]), surroundings, 1, None);
    let mut inbox = Inbox::new(&settings, 1);
    let mut process = Process::new(&settings, model, 0);
    let mut random = Random(1);
    let (mut refused, mut applied, mut diverged, mut tripped) = (0, 0, 0, 0);
    let mut last = 0.0;
    for n in 0..commands {
        let now_ns = process.next_due_ns().saturating_sub(1);
        let seq = if random.next().is_multiple_of(9) {
            random.next() % (n + 1)
        } else {
            n
        };
        let sent_ns = now_ns.saturating_sub(random.next() % (3 * MS));
        let text = format!("u={}&seq={seq}&t_send_ns={sent_ns}", random.word());
        // As the plant does over HTTP: what is no request, or has two inputs, never comes so far.
        let request = text.parse::<Request>();
        match request.and_then(|request| request.check(1).map(|()| request)) {
            Ok(request) => {
                let (row, _) = inbox.command(Mode::Closed, &request, process.output(), now_ns);
                applied += u64::from(row.outcome == ArrivalOutcome::Applied);
            }
            Err(_) => refused += 1,
        }
        // Now and then nothing comes for a while.
        let ticks = if random.next().is_multiple_of(64) {
            9
        } else {
            1
        };
        for _ in 0..ticks {
            let held = inbox.input();
            assert!(held.u.is_finite(), "{text}: {held:?}");
            let row = process.tick(held, 0);
            let u = row.u_applied.expect("a tick tells it");
            assert!(u.abs() <= LIMIT, "{text}: {u}");
            assert!((u - last).abs() <= 0.5 + 1e-9, "{text}: from {last} to {u}");
            last = u;
            let Pendulum(state) = process.model().model();
            let was_finite = process.output().y.is_finite();
            if !was_finite {
                // It says so, and a reset helps.
                diverged += 1;
                inbox.reset();
                assert!(process.reset());
                last = 0.0;
            } else if !state.iter().all(|x| x.is_finite()) {
                // The step that left the finite is told at the next tick.
                process.tick(held, 0);
                assert!(!process.output().y.is_finite());
                assert!(process.reset());
                (last, diverged) = (0.0, diverged + 1);
            }
        }
        tripped = process.output().trips;
    }
    assert!(
        refused > commands / 50 && applied > commands / 4 && tripped > commands / 1000,
        "{refused} refused, {applied} applied, {tripped} trips"
    );
    assert!(
        diverged > 0,
        "the limits are too narrow to hold it for ever"
    );
    println!(
        "row 18: {commands} commands, {refused} of them refused: the input always finite and at most {LIMIT}; the state left the finite {diverged} times, each said"
    );
}

/// A silence from a command at `at_ns` on, and when its plant is in the safe state.
fn silence(h: SampleTime, hold: Hold, at_ns: u64) -> u64 {
    let settings = PlantSettings {
        hold,
        ..PlantSettings::new(h)
    };
    let wire = Surrounded::new(Wire, Surroundings::default(), 0, None);
    let mut inbox = Inbox::new(&settings, 1);
    let mut process = Process::new(&settings, wire, 0);
    let request = "u=2".parse().expect("a request");
    let mut has_come = false;
    loop {
        let due_ns = process.next_due_ns();
        if !has_come && due_ns >= at_ns {
            inbox.command(Mode::Closed, &request, process.output(), at_ns);
            has_come = true;
        }
        process.tick(inbox.input(), due_ns);
        if process.output().is_safe {
            return due_ns - at_ns;
        }
        assert!(
            due_ns < at_ns + 100 * h.ns() + 10_000 * MS,
            "it never trips"
        );
    }
}

/// Gives its input back.
struct Wire;

impl Model for Wire {
    fn step(&mut self, u: Signals, _: u64) -> Signals {
        u
    }
}

#[test]
fn a_thousand_silences_end_in_the_safe_state_within_the_watchdog_s_time_and_two_ticks() {
    let mut random = Random(2);
    for n in 0..1000 {
        let h_ns = [100_000, MS, 3 * MS, 10 * MS, 100 * MS, 300 * MS][n % 6];
        let h = SampleTime::try_new(h_ns).expect("a sample time");
        let ns = 1 + random.next() % (20 * h_ns);
        let action = [
            Action::Zero,
            Action::Hold,
            Action::Value(0.5),
            Action::Ramp { ns: h_ns },
        ];
        let hold = Hold::For {
            ns,
            then: action[n % 4],
        };
        let silent_ns = silence(h, hold, 1 + random.next() % (30 * h_ns));
        assert!(
            silent_ns > ns && silent_ns <= ns + 2 * h_ns,
            "{hold} at {h}: {silent_ns} ns"
        );
    }
    println!("row 16: virtual time, 1000 of 1000 within the watchdog's time and two ticks");
}

fn plant(settings: PlantSettings) -> (Inbox, Process<Surrounded<Wire>>) {
    let wire = Surrounded::new(Wire, Surroundings::default(), 0, None);
    (Inbox::new(&settings, 1), Process::new(&settings, wire, 0))
}

#[test]
fn only_a_command_that_is_applied_arms_the_watchdog_again() {
    let (mut inbox, mut process) = plant(PlantSettings {
        late: Late::Drop,
        hold: "3ms".parse().expect("a hold"),
        ..PlantSettings::new(h())
    });
    let mut u = |command: Option<(Mode, &str)>| {
        if let Some((mode, text)) = command {
            let request = text.parse().expect(text);
            inbox.command(mode, &request, process.output(), process.next_due_ns());
        }
        process.tick(inbox.input(), 0);
        let output = process.output();
        (output.u_applied.first, output.is_safe, output.trips)
    };
    assert_eq!(u(None), (0.0, false, 0), "nothing to be silent about");
    let first = Some((Mode::Closed, "u=2&seq=1"));
    assert_eq!(u(first), (2.0, false, 0));
    // Neither one that is stale nor one of an open loop.
    assert_eq!(u(first), (2.0, false, 0));
    assert_eq!(u(Some((Mode::Open, "u=9&seq=2"))), (2.0, false, 0));
    assert_eq!(u(first), (2.0, false, 0));
    assert_eq!(u(first), (0.0, true, 1));
    assert_eq!(u(first), (0.0, true, 1));
    assert_eq!(u(Some((Mode::Closed, "u=3&seq=2"))), (3.0, false, 1));
    assert_eq!(
        [u(None), u(None), u(None), u(None)].map(|(u, ..)| u),
        [3.0, 3.0, 3.0, 0.0]
    );
    assert_eq!(u(None), (0.0, true, 2));
}

/// The outcome of a command that was sent and arrives at these times, ns.
fn outcome(inbox: &mut Inbox, seq: u64, sent_ns: u64, now_ns: u64) -> ArrivalOutcome {
    let request = format!("u=1&seq={seq}&t_send_ns={sent_ns}");
    let request = request.parse().expect("a request");
    let output = endpoint::Output::default();
    inbox
        .command(Mode::Closed, &request, output, now_ns)
        .0
        .outcome
}

proptest! {
    /// The clocks of both ends may differ by any constant.
    #[test]
    fn a_command_is_aged_if_it_was_longer_under_way_than_the_quickest_by_more_than_max_age(
        ahead_ns in 0..1_000_000_000_000_u64, behind: bool,
        ways_ms in prop::collection::vec(0..200_u64, 1..60),
    ) {
        let (mut inbox, _) = plant(PlantSettings { max_age_ns: Some(50 * MS), ..PlantSettings::new(h()) });
        let mut quickest_ms = u64::MAX;
        for (seq, way_ms) in (0..).zip(ways_ms) {
            let start_ns = 2_000_000_000_000 + seq * MS;
            let sent_ns = if behind { start_ns - ahead_ns } else { start_ns + ahead_ns };
            quickest_ms = quickest_ms.min(way_ms);
            let outcome = outcome(&mut inbox, seq, sent_ns, start_ns + way_ms * MS);
            let expected = if way_ms > quickest_ms + 50 { ArrivalOutcome::Aged } else { ArrivalOutcome::Applied };
            // What the clocks may have parted by meanwhile is let go.
            prop_assume!(way_ms != quickest_ms + 51);
            prop_assert_eq!(outcome, expected, "{} after {}", way_ms, quickest_ms);
        }
    }
}

#[test]
fn clocks_that_part_slowly_do_not_age_commands() {
    let (mut inbox, _) = plant(PlantSettings {
        max_age_ns: Some(10 * MS),
        ..PlantSettings::new(h())
    });
    for s in 0..36_000 {
        // The controller's clock is slow by 50 parts in a million: 1.8 s in ten hours.
        let now_ns = 1_000_000_000 * (s + 1);
        let sent_ns = now_ns - 50_000 * s;
        let outcome = outcome(&mut inbox, s, sent_ns, now_ns);
        assert_eq!(outcome, ArrivalOutcome::Applied, "after {s} s");
    }
}

#[test]
fn a_new_controller_has_numbers_of_its_own_and_no_way_around_its_age() {
    let (mut inbox, _) = plant(PlantSettings {
        late: Late::Drop,
        max_age_ns: Some(10 * MS),
        ..PlantSettings::new(h())
    });
    assert_eq!(
        outcome(&mut inbox, 5, 100 * MS, 101 * MS),
        ArrivalOutcome::Applied
    );
    assert_eq!(
        outcome(&mut inbox, 6, 100 * MS, 150 * MS),
        ArrivalOutcome::Aged
    );
    assert_eq!(
        outcome(&mut inbox, 5, 150 * MS, 151 * MS),
        ArrivalOutcome::Stale
    );
    inbox.welcome();
    assert_eq!(
        outcome(&mut inbox, 0, 100 * MS, 200 * MS),
        ArrivalOutcome::Aged
    );
    assert_eq!(
        outcome(&mut inbox, 0, 200 * MS, 201 * MS),
        ArrivalOutcome::Applied
    );
}
