//! Laws that both ends keep, whatever the network does.

use control::preset;
use endpoint::{
    Acknowledgement, Action, Answer, ArrivalOutcome, Command, Connection, ControllerEnd,
    ControllerSettings, Hold, Input, Integrate, Late, Loss, MessageOutcome, MessageRow, Mode,
    NoiseLaw, Output, Outstanding, PlantEnd, PlantSettings, Preset, Process, Reference, SampleTime,
    Schedule, Signals, State, Step, TickNoise, Transport,
};
use proptest::prelude::*;

const MS: u64 = 1_000_000;
const START_NS: u64 = 50 * MS;

fn h() -> SampleTime {
    SampleTime::try_new(3 * MS).expect("3 ms")
}

fn plant(late: Late) -> PlantEnd {
    let plant = preset::paper_plant()
        .sampled(h().ns())
        .expect("a stable model");
    PlantEnd::new(
        &PlantSettings {
            late,
            ..PlantSettings::new(h())
        },
        plant.stepper(),
        0,
    )
}

fn controller(settings: ControllerSettings, duration_ns: u64) -> ControllerEnd {
    ControllerEnd::try_new(
        settings,
        preset::paper_pi(),
        0.0,
        START_NS,
        START_NS + duration_ns,
    )
    .expect("valid settings")
}

fn settings() -> impl Strategy<Value = ControllerSettings> {
    (
        prop_oneof![Just(Mode::Open), Just(Mode::Closed)],
        prop_oneof![Just("1"), Just("2"), Just("8"), Just("unlimited")],
        prop_oneof![Just(Schedule::Absolute), Just(Schedule::Relative)],
        prop_oneof![Just(Integrate::H), Just(Integrate::Elapsed)],
        prop_oneof![Just(Late::Apply), Just(Late::Drop)],
    )
        .prop_map(
            |(mode, outstanding, schedule, integrate, late)| ControllerSettings {
                mode,
                h: h(),
                r: 1.0,
                outstanding: outstanding.parse().expect("a valid word"),
                transport: Transport::Http,
                connection: Connection::Keep,
                schedule,
                integrate,
                late,
                timeout_ns: 5_000 * MS,
            },
        )
}

/// A script of the outside: how long until the next thing happens, and what.
fn script() -> impl Strategy<Value = Vec<(u64, u8, u8)>> {
    prop::collection::vec((0..12 * MS, any::<u8>(), any::<u8>()), 1..200)
}

/// Polls until the end waits; gives what was sent and what was missed.
fn poll(
    end: &mut ControllerEnd,
    now_ns: u64,
    sent: &mut Vec<u64>,
    rows: &mut Vec<MessageRow>,
) -> Step {
    loop {
        match end.poll(now_ns) {
            Step::Send(command) => {
                assert_eq!(command.t_send_ns, now_ns);
                sent.push(command.seq);
            }
            Step::Missed(row) => {
                assert_eq!(row.outcome, MessageOutcome::Missed);
                rows.push(row);
            }
            wait => return wait,
        }
    }
}

proptest! {
    #[test]
    fn every_deadline_becomes_exactly_one_row(settings in settings(), script in script()) {
        let mut end = controller(settings, 600 * MS);
        let (mut now_ns, mut under_way, mut rows) = (0, Vec::new(), Vec::new());
        for (pause_ns, which, how) in script {
            now_ns += pause_ns;
            let wait = poll(&mut end, now_ns, &mut under_way, &mut rows);
            prop_assert!(under_way.len() <= settings.outstanding.limit());
            match wait {
                Step::Sleep { until_ns } => prop_assert!(until_ns > now_ns),
                Step::AwaitAnswer => prop_assert!(!under_way.is_empty()),
                _ => {}
            }
            let counts = end.counts();
            let ended = counts.answered + counts.timeout + counts.failed;
            prop_assert_eq!(counts.due, counts.sent + counts.missed);
            prop_assert_eq!(counts.sent, ended + under_way.len() as u64);
            if under_way.is_empty() || how == 255 {
                continue;
            }
            let seq = under_way.swap_remove(usize::from(which) % under_way.len());
            let row = match how % 4 {
                0 => end.lost(seq, Loss::Timeout, now_ns),
                1 => end.lost(seq, Loss::Failed, now_ns),
                _ => end.answered(&Answer::Acknowledgement(Acknowledgement { seq, t_arrive_ns: 1 }), now_ns),
            };
            rows.push(row.expect("it was under way"));
            prop_assert_eq!(end.lost(seq, Loss::Failed, now_ns), None, "a message ends once");
        }
        while let Some(seq) = end.oldest_under_way() {
            rows.extend(end.lost(seq, Loss::Failed, now_ns));
        }
        let mut numbers: Vec<u64> = rows.iter().map(|row| row.seq).collect();
        numbers.sort_unstable();
        prop_assert_eq!(numbers, (0..end.counts().due).collect::<Vec<_>>());
    }

    #[test]
    fn an_absolute_schedule_never_leaves_its_grid_and_never_sends_in_the_past(script in script()) {
        let settings = Preset::PaperPython.settings(Mode::Closed, h());
        let mut end = controller(settings, 600 * MS);
        let mut now_ns = 0;
        for (pause_ns, ..) in script {
            now_ns += pause_ns;
            loop {
                match end.poll(now_ns) {
                    Step::Send(Command { seq, .. }) => {
                        let due_ns = START_NS + seq * h().ns();
                        prop_assert!((due_ns..due_ns + h().ns()).contains(&now_ns));
                    }
                    Step::Missed(row) => {
                        prop_assert_eq!(row.t_due_ns, START_NS + row.seq * h().ns());
                        prop_assert!(now_ns >= row.t_due_ns + h().ns());
                    }
                    Step::Sleep { until_ns } => {
                        prop_assert_eq!((until_ns - START_NS) % h().ns(), 0);
                        break;
                    }
                    wait => {
                        prop_assert_eq!(wait, Step::Finished);
                        break;
                    }
                }
            }
        }
        // All deadlines before stop exist, and no other: 600 ms hold 200 of them.
        while end.poll(u64::MAX) != Step::Finished {}
        prop_assert_eq!(end.counts().due, 200);
    }

    #[test]
    fn applying_follows_arrival_and_dropping_follows_the_sequence(order in Just((0..20).collect::<Vec<u64>>()).prop_shuffle()) {
        let (mut applying, mut dropping) = (plant(Late::Apply), plant(Late::Drop));
        let mut newest = None;
        for (n, seq) in order.into_iter().enumerate() {
            let command = Command { seq, t_send_ns: seq, u: (seq as f64).into() };
            let (row, _) = applying.command(Mode::Closed, &command, 1);
            prop_assert_eq!((row.n, row.outcome), (n as u64, ArrivalOutcome::Applied));
            prop_assert_eq!(applying.observe(1).u, command.u);
            let (row, answer) = dropping.command(Mode::Closed, &command, 1);
            let fresh = newest.is_none_or(|newest| seq > newest);
            prop_assert_eq!(row.outcome == ArrivalOutcome::Applied, fresh);
            newest = newest.max(Some(seq));
            // A stale command is still answered, with the input that is held.
            prop_assert_eq!(answer.seq(), seq);
            prop_assert_eq!(dropping.observe(1).u.first, newest.unwrap_or_default() as f64);
        }
    }

    #[test]
    fn dropping_late_answers_keeps_the_output_of_the_newest_tick(ticks in prop::collection::vec(0..50_u64, 1..20)) {
        let settings = ControllerSettings {
            late: Late::Drop,
            ..Preset::PaperPython.settings(Mode::Closed, h())
        };
        let mut end = controller(settings, 600 * MS);
        let mut newest = (0, 0.0);
        for (k, tick) in ticks.into_iter().enumerate() {
            let now_ns = START_NS + k as u64 * h().ns();
            let Step::Send(Command { seq, .. }) = end.poll(now_ns) else {
                panic!("deadline {k} is due");
            };
            let state = State { seq, tick, t_arrive_ns: now_ns, y: (tick as f64).into(), u: 0.0.into() };
            let row = end.answered(&Answer::State(state), now_ns).expect("under way");
            prop_assert_eq!((row.y, row.e), (Some(newest.1), Some(1.0 - newest.1)));
            if tick >= newest.0 {
                newest = (tick, tick as f64);
            }
        }
    }
}

#[test]
fn open_loop_commands_leave_the_plant_alone() {
    let mut plant = plant(Late::Apply);
    let command = Command {
        seq: 0,
        t_send_ns: 0,
        u: 5.0.into(),
    };
    let (row, answer) = plant.command(Mode::Open, &command, 7);
    assert_eq!(row.outcome, ArrivalOutcome::Acknowledged);
    assert_eq!(answer.to_string(), "seq=0&t_arrive_ns=7");
    assert_eq!(
        (plant.tick(0).u, plant.observe(8).u),
        (0.0, Signals::from(0.0))
    );
}

#[test]
fn late_ticks_are_caught_up_so_that_the_model_keeps_to_real_time() {
    // Ticks 0 to 4 happen together at 12.5 ms: due at 0, 3, 6, 9 and 12 ms.
    let mut plant = plant(Late::Apply);
    let now_ns = 12 * MS + MS / 2;
    let mut due = Vec::new();
    while plant.next_due_ns() <= now_ns {
        let row = plant.tick(now_ns);
        assert_eq!(row.t_tick_ns, now_ns);
        due.push(row.t_due_ns / MS);
    }
    assert_eq!(due, [0, 3, 6, 9, 12]);
}

#[test]
fn a_blocking_client_waits_and_the_deadlines_it_waited_through_are_missed() {
    // A round trip of 10 ms over h = 3 ms: sent at 0, answered at 10; the
    // deadlines at 3, 6 and 9 are missed, and the next message goes at 12.
    let mut end = controller(Preset::Blocking.settings(Mode::Open, h()), 13 * MS);
    let mut sent_at = Vec::new();
    let mut answer_at = None;
    for t_ms in 0..30 {
        let now_ns = START_NS + t_ms * MS;
        if let Some((at_ms, seq)) = answer_at
            && at_ms == t_ms
        {
            let answer = Acknowledgement {
                seq,
                t_arrive_ns: now_ns,
            };
            end.answered(&Answer::Acknowledgement(answer), now_ns)
                .expect("under way");
            answer_at = None;
        }
        loop {
            match end.poll(now_ns) {
                Step::Send(Command { seq, .. }) => {
                    sent_at.push(t_ms);
                    answer_at = Some((t_ms + 10, seq));
                }
                Step::Missed(_) => {}
                _ => break,
            }
        }
    }
    assert_eq!(sent_at, [0, 12]);
    let counts = end.counts();
    assert_eq!(
        (counts.due, counts.sent, counts.missed, counts.answered),
        (5, 2, 3, 2)
    );
}

#[test]
fn a_relative_schedule_drifts_by_the_round_trip_and_misses_nothing() {
    // Sleep h = 3 ms, then a round trip of 4 ms: a message every 7 ms.
    let settings = ControllerSettings {
        schedule: Schedule::Relative,
        ..Preset::Blocking.settings(Mode::Open, h())
    };
    let mut end = controller(settings, 21 * MS);
    let mut now_ns = START_NS;
    let mut sent_at = Vec::new();
    loop {
        match end.poll(now_ns) {
            Step::Send(Command { seq, .. }) => {
                sent_at.push((now_ns - START_NS) / MS);
                assert_eq!(end.poll(now_ns), Step::AwaitAnswer);
                now_ns += 4 * MS;
                let answer = Acknowledgement {
                    seq,
                    t_arrive_ns: now_ns,
                };
                end.answered(&Answer::Acknowledgement(answer), now_ns)
                    .expect("under way");
            }
            Step::Sleep { until_ns } => now_ns = until_ns,
            Step::Finished => break,
            step => panic!("{step:?}"),
        }
    }
    assert_eq!(sent_at, [0, 7, 14]);
    assert_eq!(end.counts().missed, 0);
}

#[test]
fn integrating_the_elapsed_time_makes_up_for_missed_deadlines() {
    // With e = 1 throughout, u = kp + ki t: after one message at 0 and one at
    // 30 ms the integral holds h + 30 ms, or twice h when it counts messages.
    let gains = preset::paper_gains();
    for (integrate, integral_s) in [(Integrate::Elapsed, 0.033), (Integrate::H, 0.006)] {
        let settings = ControllerSettings {
            integrate,
            ..Preset::PaperPython.settings(Mode::Closed, h())
        };
        let mut end = controller(settings, 600 * MS);
        assert!(matches!(end.poll(START_NS), Step::Send(_)));
        let command = loop {
            if let Step::Send(command) = end.poll(START_NS + 30 * MS) {
                break command;
            }
        };
        assert!(
            (command.u.first - gains.kp - gains.ki * integral_s).abs() < 1e-15,
            "{integrate}"
        );
    }
}

#[test]
fn settings_that_make_no_controller_are_refused() {
    let good = Preset::PaperPython.settings(Mode::Closed, h());
    for bad in [
        ControllerSettings {
            r: f64::NAN,
            ..good
        },
        ControllerSettings {
            r: f64::INFINITY,
            ..good
        },
        ControllerSettings {
            timeout_ns: 0,
            ..good
        },
    ] {
        assert!(ControllerEnd::try_new(bad, preset::paper_pi(), 0.0, 0, 1).is_err());
    }
    assert_eq!(good.outstanding, Outstanding::Unlimited);
}

proptest! {
    #[test]
    fn a_noisy_plant_ticks_in_order_never_early_and_steps_as_often_as_a_punctual_one(
        seed: u64, max_ms in 1u64..20, ticks in 1u64..300,
    ) {
        let law = NoiseLaw::Uniform { max_ns: max_ms * MS };
        let settings = |tick_noise| PlantSettings {
            tick_noise,
            ..PlantSettings::new(h())
        };
        let own = preset::paper_plant().sampled(h().ns()).expect("a stable model");
        let mut punctual = PlantEnd::new(&settings(None), own.stepper(), 0);
        let mut noisy = PlantEnd::new(&settings(Some(TickNoise { law, seed })), own.stepper(), 0);
        let mut last_ns = 0;
        for k in 0..ticks {
            prop_assert_eq!(punctual.next_tick_ns(), punctual.next_due_ns());
            let at_ns = noisy.next_tick_ns();
            prop_assert!(at_ns >= last_ns && at_ns >= noisy.next_due_ns());
            prop_assert!(at_ns <= last_ns.max(k * h().ns() + max_ms * MS));
            last_ns = at_ns;
            let (own, other) = (noisy.tick(at_ns), punctual.tick(k * h().ns()));
            prop_assert_eq!((own.t_tick_ns, own.t_due_ns, own.k), (at_ns, other.t_due_ns, k));
        }
    }
}

#[test]
fn a_plant_that_is_to_let_go_of_a_command_does_when_none_has_come_for_so_long() {
    let own = preset::paper_plant()
        .sampled(h().ns())
        .expect("a stable model");
    let settings = PlantSettings {
        hold: Hold::For {
            ns: 10 * MS,
            then: Action::Zero,
        },
        ..PlantSettings::new(h())
    };
    let mut plant = PlantEnd::new(&settings, own.stepper(), 0);
    let command = |seq| Command {
        seq,
        t_send_ns: 0,
        u: 2.0.into(),
    };
    let mut inputs = Vec::new();
    for k in 0..12 {
        if k == 1 || k == 7 {
            plant.command(Mode::Closed, &command(k), k * 3 * MS - MS);
        }
        // A tick that is caught up late is stepped as one in time.
        let row = plant.tick(k * 3 * MS + 100 * MS);
        let held = row.seq.map_or(0.0, |_| 2.0);
        assert_eq!(row.u, held, "the commanded input is told as it was");
        let is_safe = plant.observe(0).safe;
        inputs.push((
            row.u_applied.expect("it is told"),
            row.seq.filter(|_| !is_safe),
        ));
    }
    assert_eq!(plant.observe(0).trips, 2);
    let held = |seq| (2.0, Some(seq));
    let none = (0.0, None);
    // Set at 2 ms: held at 3, 6, 9 and 12 ms; set at 20 ms: at 21, 24, 27 and 30 ms.
    let expected = [
        none,
        held(1),
        held(1),
        held(1),
        held(1),
        none,
        none,
        held(7),
        held(7),
        held(7),
        held(7),
        none,
    ];
    assert_eq!(inputs, expected);
}

proptest! {
    #[test]
    fn an_end_that_goes_on_has_the_deadlines_and_numbers_of_one_from_the_start(now_ns in 0..4000 * MS) {
        let settings = ControllerSettings::new(Mode::Closed, h());
        let reference: Reference = serde_json::from_str("[[0, 1.0], [1500000000, -1.0]]").expect("one that moves");
        let mut whole = controller(settings, 3000 * MS).following(Some(reference));
        let mut again = whole.clone().resumed(now_ns);
        let due = |end: &mut ControllerEnd, now_ns| loop {
            match end.poll(now_ns) {
                Step::Send(Command { seq, .. }) => { end.lost(seq, Loss::Failed, now_ns); }
                Step::Missed(_) => {}
                other => break other,
            }
        };
        let next = due(&mut again, now_ns);
        prop_assert_eq!(next, due(&mut whole, now_ns));
        if let Step::Sleep { until_ns } = next {
            let row = |end: &mut ControllerEnd| match end.poll(until_ns) {
                Step::Send(Command { seq, .. }) => end.lost(seq, Loss::Failed, until_ns),
                other => panic!("{other:?}"),
            }.map(|row| (row.seq, row.t_due_ns, row.r));
            prop_assert_eq!(row(&mut again), row(&mut whole));
        }
    }

    #[test]
    fn no_number_comes_twice_in_however_many_lives(
        settings in settings(),
        lives in prop::collection::vec(prop::collection::vec(0..8 * MS, 0..20), 1..6),
    ) {
        let (mut now_ns, mut last) = (START_NS - 5 * MS, None);
        for waits in lives {
            let mut end = controller(settings, 10_000 * MS).resumed(now_ns);
            for wait_ns in waits {
                now_ns += wait_ns;
                let seq = match end.poll(now_ns) {
                    Step::Send(Command { seq, .. }) => {
                        end.lost(seq, Loss::Failed, now_ns + wait_ns / 2);
                        seq
                    }
                    Step::Missed(MessageRow { seq, .. }) => seq,
                    _ => continue,
                };
                prop_assert!(last < Some(seq), "{:?}, {}", last, seq);
                last = Some(seq);
            }
        }
    }

    #[test]
    fn a_plant_that_goes_on_ticks_on_the_grid_of_the_earlier_one(start_ns in 0..1000 * MS, passed_ns in 0..1000 * MS) {
        let settings = PlantSettings::new(h());
        let motor = preset::paper_plant().sampled(h().ns()).expect("a stable model").stepper();
        let now_ns = start_ns + passed_ns;
        let k = h().next_k(start_ns, now_ns);
        let mut again = Process::new(&settings, motor, start_ns).resumed(k);
        let before = again.output();
        let row = again.tick(Input::default(), now_ns);
        prop_assert_eq!((row.k, row.t_due_ns), (k, start_ns + k * h().ns()));
        prop_assert!(row.t_due_ns > now_ns && row.t_due_ns <= now_ns + h().ns());
        // It has forgotten all but the number of the tick.
        prop_assert_eq!(before, Output { tick: k - 1, ..Output::default() });
        prop_assert_eq!(again.next_due_ns(), row.t_due_ns + h().ns());
    }
}
