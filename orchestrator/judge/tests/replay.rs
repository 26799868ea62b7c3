//! Runs in virtual time, replayed by the plan: the ends that were asked for agree in every bit, and each that is
//! another one is found, with the first row that differs.

use endpoint::{
    ArrivalRow, Connection, ControllerSettings, Hold, Integrate, MessageRow, Mode, Outstanding,
    SampleTime, Schedule, SecondRow, Surrounded, TickRow, Transport,
};
use judge::replay::{Both, Other, replay};
use link::Profile;
use plan::evidence::Ends;
use plan::system::System;
use plan::{Cell, Client, End, Instead, Plan, ProfileText};
use proptest::prelude::*;
use sim::{EPOCH, Outcome, Record, Setup, Timing};

/// Systems that have what the built-in ones have not.
const OWN: [&str; 6] = [
    "name = \"noisy\"\n[plant]\nnum = [5.0]\nden = [1.0, 5.0]\nactuator = { min = -0.4, max = 3.0, rate = 40.0 }\n\
     sensor = { noise = 0.01, resolution = 0.001 }\n[controller]\nlaw = \"pid\"\nkp = 0.4\nki = 2.0\n",
    "name = \"late\"\n[plant]\nnum = [1.0]\nden = [0.3, 1.0]\ndead_time = \"60ms\"\ndisturbance = { size = 0.2, \
     from = \"700ms\" }\n[controller]\nlaw = \"pid\"\nkp = 0.5\nki = 1.0\nkd = 0.01\nfilter = 100.0\nlimits = { min = 0.0, max = 1.0 }\n",
    "name = \"upright\"\n[plant]\na = [[0.0, 1.0], [9.81, 0.0]]\nb = [0.0, 1.0]\nc = [1.0, 0.0]\nx0 = [0.05, 0.0]\n\
     sensor = { noise = 0.0005 }\n[controller]\nlaw = \"state-feedback\"\nweights = { output = 100.0, input = 1.0 }\n\
     noise = { disturbance = 1.0, measurement = 0.001 }\nround_trip = \"10ms\"\n",
    "name = \"two\"\n[plant]\na = [[-1.0, 0.2], [0.1, -2.0]]\nb = [[1.0, 0.0], [0.0, 1.0]]\nc = [[1.0, 0.0], [0.0, 1.0]]\n\
     sensor = { noise = 0.001 }\n[controller]\nlaw = \"state-feedback\"\nweights = { output = [10.0, 10.0], input = [0.1, 0.1] }\n\
     noise = { disturbance = [1.0, 1.0], measurement = [0.001, 0.001] }\nround_trip = \"10ms\"\n",
    "name = \"aged\"\n[plant]\ngain = 2029.826\npoles = [-26.29, -2.296]\nsampling = \"backward-euler\"\n\
     sensor = { noise = 0.001 }\n[controller]\nlaw = \"state-feedback\"\nage = \"measured\"\n\
     weights = { output = 1.0, input = 1.0 }\nnoise = { disturbance = 0.1, measurement = 0.001 }\n",
    "name = \"aged-two\"\n[plant]\na = [[-1.0, 0.2], [0.1, -2.0]]\nb = [[1.0, 0.0], [0.0, 1.0]]\n\
     c = [[1.0, 0.0], [0.0, 1.0]]\nsensor = { noise = 0.001 }\n[controller]\nlaw = \"state-feedback\"\n\
     age = \"measured\"\nweights = { output = [10.0, 10.0], input = [0.1, 0.1] }\n\
     noise = { disturbance = [1.0, 1.0], measurement = [0.001, 0.001] }\nlimits = { min = -3.0, max = 3.0 }\n",
];

fn systems() -> Vec<System> {
    let built_in = System::built_in_names().filter_map(System::built_in);
    let texts = built_in.chain(OWN);
    texts
        .map(|text| System::read(text).unwrap_or_else(|fault| panic!("{fault}: {text}")))
        .collect()
}

fn profile(name: &str) -> Profile {
    let source = Profile::builtin(name).expect("built in");
    let (profile, _) = Profile::read(source, name, &|_| Err("no trace".into()));
    profile.expect("a profile")
}

/// A cell of the native client for two seconds.
fn cell(system: &System) -> Cell {
    let source = "name = \"t\"\n[[cells]]\ntopology = \"buccoo\"\nclient = \"native\"\nmode = \"closed\"\nh = \"10ms\"\n\
                  duration = \"2s\"\n";
    let text = |name: &str| {
        Ok(ProfileText {
            source: Profile::builtin(name).expect("built in").to_owned(),
            ..ProfileText::default()
        })
    };
    let plan = Plan::resolve(source, "t.toml", &Instead::default(), text).expect("a plan");
    let mut cell = plan.cells.into_iter().next().expect("a cell");
    cell.settings.r = system.r();
    cell
}

#[derive(Default)]
struct Rows {
    ticks: Vec<TickRow>,
    second: Vec<SecondRow>,
    arrivals: Vec<ArrivalRow>,
    messages: Vec<MessageRow>,
}

impl Record for Rows {
    fn tick(&mut self, row: &TickRow) {
        self.ticks.push(*row);
    }
    fn second(&mut self, row: &SecondRow) {
        self.second.push(*row);
    }
    fn arrival(&mut self, row: &ArrivalRow) {
        self.arrivals.push(*row);
    }
    fn message(&mut self, row: &MessageRow) {
        self.messages.push(*row);
    }
}

const START: link::LinkTime = plan::START_AT;

/// The rows of a cell whose plant and law are `system`'s, over a link.
fn run(cell: &Cell, system: &System, link: &str) -> Rows {
    run_each(cell, cell, system, system, link)
}

/// The same, with settings and a system of each end's own: the plant's first.
fn run_each(plant: &Cell, cell: &Cell, of_plant: &System, of_law: &System, link: &str) -> Rows {
    let (profile, h) = (profile(link), plant.settings.h);
    let start_ns = EPOCH.t_ns(START);
    let model = of_plant
        .at(h)
        .expect("a plant")
        .plant
        .stepper_from(of_plant.x0());
    let around = of_plant.surroundings().unwrap_or_default();
    let (law, _) = of_law.law_at(cell.settings.h).expect("a law");
    let mut rows = Rows::default();
    let setup = Setup {
        seed: cell.link_seed,
        plant_settings: plant.plant_settings(),
        reference: cell.moving_reference(),
        epoch: EPOCH,
        plant_start_ns: EPOCH.t_ns(link::LinkTime::from_ns(3_700_001)),
        start_ns,
        timing: &Timing::IDEAL,
        ..Setup::ideal(
            &profile,
            cell.settings,
            Surrounded::new(model, around, cell.link_seed, Some(start_ns)),
            law,
            cell.duration_ns,
        )
    };
    let _: Outcome = sim::run(&setup, &mut rows).expect("a run");
    rows
}

fn judged(rows: &Rows, cell: &Cell, system: &System) -> (Ends, Vec<Other>) {
    replay(&Both {
        cell,
        system,
        is_plant_own: false,
        start_ns: EPOCH.t_ns(START),
        end_faults: &[],
        ticks: &rows.ticks,
        second: &rows.second,
        arrivals: &rows.arrivals,
        messages: &rows.messages,
    })
}

/// Settings of every sort.
fn settings() -> impl Strategy<Value = (ControllerSettings, Hold)> {
    let h_us = prop::sample::select(vec![1_000_u64, 3_000, 7_000, 10_000, 20_000]);
    let ways = (
        0..3_usize,
        0..3_usize,
        any::<bool>(),
        any::<bool>(),
        0..3_usize,
    );
    let hold = prop::sample::select(vec![
        "last",
        "15ms",
        "30ms then 0.3",
        "12ms then ramp 100ms",
    ]);
    (h_us, ways, hold).prop_map(|(h_us, (few, schedule, elapsed, keeps, mode), hold)| {
        let h = SampleTime::try_new(h_us * 1_000).expect("an h");
        let base = cell(&System::paper()).settings;
        let settings = ControllerSettings {
            h,
            mode: if mode == 0 { Mode::Open } else { Mode::Closed },
            outstanding: match few {
                0 => Outstanding::ONE,
                1 => Outstanding::Unlimited,
                _ => "3".parse().expect("a number"),
            },
            schedule: [Schedule::Absolute, Schedule::Relative, Schedule::SinceSend][schedule],
            integrate: if elapsed {
                Integrate::Elapsed
            } else {
                Integrate::H
            },
            connection: if keeps {
                Connection::Keep
            } else {
                Connection::New
            },
            transport: Transport::Http,
            ..base
        };
        (settings, hold.parse().expect("a hold"))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn the_plan_s_ends_agree_in_every_bit_whatever_the_system_the_settings_and_the_link(
        which in 0..16_usize, (settings, hold) in settings(), link in 0..5_usize, seed in any::<u64>(),
    ) {
        let systems = systems();
        let system = &systems[which % systems.len()];
        let links = ["arima", "buccoo", "couva", "diego-lan", "diego-vpn"];
        let mut cell = cell(system);
        cell.settings = ControllerSettings { r: system.r(), ..settings };
        if system.check(&cell.settings).is_err() {
            cell.settings.integrate = Integrate::H;
        }
        (cell.hold, cell.link_seed) = (hold, seed);
        prop_assume!(system.at(cell.settings.h).is_ok());
        let rows = run(&cell, system, links[link]);
        let (ends, others) = judged(&rows, &cell, system);
        prop_assert!(others.is_empty(), "{}: {}", system.name(), others[0]);
        let sent = rows.messages.iter().filter(|row| row.u.is_some()).count() as u64;
        prop_assert_eq!(ends.commands, sent);
        prop_assert!(ends.ticks >= cell.duration_ns / cell.settings.h.ns());
    }
}

/// The one end that was found, in twenty runs with other seeds over a link.
fn found(plan: &System, rows: impl Fn(&Cell) -> Rows) -> Vec<(End, String)> {
    let each = (0..20).map(|seed| {
        let cell = Cell {
            link_seed: seed,
            ..cell(plan)
        };
        let (_, others) = judged(&rows(&cell), &cell, plan);
        let [one] = &others[..] else {
            panic!("seed {seed}: {others:?}")
        };
        (one.end, one.to_string())
    });
    each.collect()
}

fn text(of: &str, from: &str, to: &str) -> System {
    assert!(of.contains(from), "{from} is not in {of}");
    System::read(&of.replace(from, to)).expect("a system")
}

fn built_in(name: &str) -> &'static str {
    System::built_in(name).expect("built in")
}

#[test]
fn another_plant_is_found_in_each_of_twenty_runs_at_the_first_tick_that_it_steps() {
    for (from, to) in [
        ("num = [1.0]", "num = [1.001]"),
        ("dead_time = \"200ms\"", "dead_time = \"210ms\""),
    ] {
        let plan = System::read(built_in("lag")).expect("a system");
        let other = text(built_in("lag"), from, to);
        let all = found(&plan, |cell| run_each(cell, cell, &other, &plan, "buccoo"));
        for (end, words) in all {
            assert_eq!(end, End::Plant, "{words}");
            assert!(
                words.contains("ticks.csv, k = ") && words.contains("y is "),
                "{words}"
            );
        }
    }
}

#[test]
fn an_input_limit_that_nobody_asked_for_is_found_in_each_of_twenty_runs() {
    let plan = System::read(OWN[1]).expect("a system");
    let other = text(
        OWN[1],
        "[controller]",
        "actuator = { max = 0.55 }\n[controller]",
    );
    let all = found(&plan, |cell| run_each(cell, cell, &other, &plan, "buccoo"));
    for (end, words) in all {
        assert_eq!(end, End::Plant, "{words}");
        assert!(words.contains("u_applied is 0.55"), "{words}");
    }
}

#[test]
fn another_law_another_r_and_another_h_of_the_controller_are_each_found_in_twenty_runs() {
    let plan = System::read(built_in("motor-load")).expect("a system");
    let other = text(built_in("motor-load"), "kp = 0.1701", "kp = 0.1702");
    let law = found(&plan, |cell| {
        run_each(cell, cell, &plan, &other, "diego-vpn")
    });
    let r = found(&plan, |cell| {
        let mut own = cell.clone();
        own.settings.r = 0.999_999;
        run_each(cell, &own, &plan, &plan, "diego-vpn")
    });
    let h = found(&plan, |cell| {
        let mut own = cell.clone();
        own.settings.h = SampleTime::try_new(10_010_000).expect("an h");
        // The plant's is the plan's: its rows are those of another run.
        let mut rows = run_each(&own, &own, &plan, &plan, "diego-vpn");
        let of_plan = run_each(cell, cell, &plan, &plan, "diego-vpn");
        (rows.ticks, rows.arrivals) = (of_plan.ticks, of_plan.arrivals);
        rows
    });
    for (name, all) in [
        ("u is ", law),
        ("r is 0.999999", r),
        ("by the plan it is", h),
    ] {
        for (end, words) in all {
            assert_eq!(end, End::Controller, "{words}");
            assert!(
                words.contains("messages.csv, seq = ") && words.contains(name),
                "{words}"
            );
        }
    }
}

#[test]
fn another_h_and_another_watchdog_of_the_plant_are_each_found_in_twenty_runs() {
    let plan = System::read(built_in("motor")).expect("a system");
    let with = |change: fn(&mut Cell)| {
        found(&plan, |cell| {
            let mut own = cell.clone();
            change(&mut own);
            run_each(&own, &own, &plan, &plan, "couva")
        })
    };
    let h = with(|cell| cell.settings.h = SampleTime::try_new(9_000_000).expect("an h"));
    let hold = with(|cell| cell.hold = "12ms".parse().expect("a hold"));
    for (name, all) in [("by the plan's h", h), ("u_applied is ", hold)] {
        for (end, words) in all {
            assert_eq!(end, End::Plant, "{words}");
            assert!(words.contains(name), "{words}");
        }
    }
}

#[test]
fn a_command_that_was_changed_on_its_way_is_found_and_so_is_an_output_that_no_answer_brought() {
    let plan = System::read(built_in("motor")).expect("a system");
    let cell = cell(&plan);
    let mut rows = run(&cell, &plan, "buccoo");
    rows.arrivals[50].u += 1e-9;
    let (_, others) = judged(&rows, &cell, &plan);
    assert_eq!(
        others.iter().map(|other| other.end).collect::<Vec<_>>(),
        [End::Plant, End::Controller]
    );
    // What a plant showed whose command nobody knows is not known either: its controller is not accused of it.
    let mut rows = run(&cell, &plan, "buccoo");
    rows.arrivals.remove(50);
    let (_, others) = judged(&rows, &cell, &plan);
    assert!(
        matches!(&others[..], [one] if one.end == End::Plant && one.what.contains("is held")),
        "{others:?}"
    );
    let mut rows = run(&cell, &plan, "buccoo");
    let known = rows
        .ticks
        .iter()
        .map(|row| row.y)
        .find(|y| *y > 0.5)
        .expect("it rises");
    rows.messages[3].y = Some(known);
    let (_, others) = judged(&rows, &cell, &plan);
    assert!(
        others[0].what.contains("which no answer brought"),
        "{}",
        others[0]
    );
}

#[test]
fn a_program_of_one_s_own_is_not_replayed_and_its_other_end_is() {
    let plan = System::read(built_in("motor-load")).expect("a system");
    let mut cell = cell(&plan);
    cell.client = Client::Own("mine".parse().expect("a name"));
    let other = text(built_in("motor-load"), "kp = 0.1701", "kp = 0.2");
    let rows = run_each(&cell, &cell, &plan, &other, "buccoo");
    let (ends, others) = judged(&rows, &cell, &plan);
    assert!(
        others.is_empty() && ends.commands == 0 && ends.ticks > 200,
        "{others:?} {ends:?}"
    );
    let both = Both {
        cell: &Cell {
            client: Client::Native,
            ..cell.clone()
        },
        system: &plan,
        is_plant_own: true,
        start_ns: EPOCH.t_ns(START),
        end_faults: &[],
        ticks: &rows.ticks,
        second: &[],
        arrivals: &rows.arrivals,
        messages: &rows.messages,
    };
    let (ends, others) = replay(&both);
    assert_eq!((ends.ticks, others[0].end), (0, End::Controller));
}
