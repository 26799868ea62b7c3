//! What a sweep must be, whatever is swept.

use control::preset;
use plan::ProfileText;
use proptest::prelude::*;
use sim::Timing;
use sweep::{Bench, Cell, Instead, Limit, Row, SWEEPS, Sweep, borders, limit};
use system::System;

fn profile(name: &str) -> Result<ProfileText, String> {
    let source = link::Profile::builtin(name).ok_or(format!("there is no topology `{name}`"))?;
    Ok(ProfileText {
        source: source.to_owned(),
        ..ProfileText::default()
    })
}

fn resolve(source: &str) -> Sweep {
    Sweep::resolve(source, "test.toml", &Instead::default(), profile)
        .unwrap_or_else(|invalid| panic!("{invalid}"))
}

fn run_all(sweep: &Sweep) -> Vec<Row> {
    let mut bench = Bench::default();
    let runs = (0..sweep.runs()).map(|number| {
        let run = sweep.run(number);
        let point = sweep.grid.point(run.point);
        bench.run(sweep, run, &point, &Timing::IDEAL)
    });
    runs.collect::<Result<_, _>>()
        .expect("points that can be run")
}

#[test]
fn the_longest_stable_round_trip_is_within_one_sample_of_the_computed_one() {
    let sweep = resolve(
        "name = 'margin'\nduration = '10s'\n[axes]\nh = ['1ms', '3ms']\n\
         outstanding = ['unlimited', '1']\n\
         rtt = { from = '70ms', to = '100ms', steps = 31 }\n",
    );
    let cells = Cell::all(&sweep, &run_all(&sweep));
    let borders = borders(&sweep, &cells);
    assert_eq!(borders.len(), 4);
    for border in borders {
        assert_eq!(border.agrees(), Some(true), "{border:?}");
        assert!(
            border.found_ms.is_some() && border.lost_ms.is_some(),
            "{border:?}"
        );
    }
}

#[test]
fn it_is_so_for_every_built_in_system_that_a_sweep_takes() {
    let is_taken = |name: &&str| {
        let text = System::built_in(name).expect("built in");
        let system = System::read(text).expect("built in");
        system.is_single() && system.surroundings().is_none()
    };
    for name in System::built_in_names().filter(is_taken) {
        for outstanding in ["unlimited", "1"] {
            let of = |rtt: &str| {
                resolve(&format!(
                    "name = 'margin'\nduration = '120s'\n[axes]\nh = '10ms'\nsystem = '{name}'\n\
                     outstanding = '{outstanding}'\nrtt = {rtt}\n"
                ))
            };
            let Limit::Until(limit_ms) = limit(&of("'1ms'").grid.point(0)) else {
                panic!("{name} with {outstanding} is not stable at all");
            };
            let around = (-2..=2).map(|k| limit_ms + f64::from(k) * 10.0);
            let around = around.filter(|ms| *ms > 0.0);
            let rtts: Vec<String> = around.map(|ms| format!("'{ms}ms'")).collect();
            let sweep = of(&format!("[{}]", rtts.join(", ")));
            let cells = Cell::all(&sweep, &run_all(&sweep));
            for border in borders(&sweep, &cells) {
                assert_eq!(
                    border.agrees(),
                    Some(true),
                    "{name} {outstanding}: {border:?}"
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn it_is_so_for_other_gains_and_sample_times_too(
        kp in 0.1..0.4,
        ki in 0.1..1.0,
        h_ms in 2_u32..8,
        outstanding in prop::sample::select(vec!["1", "unlimited"]),
    ) {
        let of = |rtt: &str| resolve(&format!(
            "name = 'margin'\nduration = '20s'\n[axes]\nh = '{h_ms}ms'\nkp = {kp}\nki = {ki}\n\
             outstanding = '{outstanding}'\nrtt = {rtt}\n"
        ));
        let Limit::Until(limit_ms) = limit(&of("'1ms'").grid.point(0)) else {
            return Err(TestCaseError::reject("no stable loop"));
        };
        prop_assume!(limit_ms.is_finite());
        let around = (-3..=3).map(|k| limit_ms + f64::from(k) * f64::from(h_ms));
        let rtts: Vec<String> = around.filter(|ms| *ms > 0.0).map(|ms| format!("'{ms}ms'")).collect();
        let sweep = of(&format!("[{}]", rtts.join(", ")));
        let cells = Cell::all(&sweep, &run_all(&sweep));
        for border in borders(&sweep, &cells) {
            prop_assert_eq!(border.agrees(), Some(true), "{:?}", border);
        }
    }

    #[test]
    fn a_row_is_the_same_whatever_was_run_before_it(seed in any::<u32>(), first in 0_usize..16) {
        let sweep = resolve(&format!(
            "name = 'mixed'\nduration = '1s'\nrepeats = 2\nseed = {seed}\n[axes]\n\
             rtt = ['5ms', '20ms']\njitter = ['0ms', '4ms']\nloss = ['0%', '5%']\n"
        ));
        let all = run_all(&sweep);
        let run = sweep.run(first);
        let point = sweep.grid.point(run.point);
        let alone = Bench::default().run(&sweep, run, &point, &Timing::IDEAL);
        prop_assert_eq!(alone.expect("a point that can be run"), all[first]);
    }

    #[test]
    fn a_row_is_read_as_it_was_written(number in 0_usize..12) {
        let sweep = resolve(
            "name = 'rows'\nduration = '500ms'\nrepeats = 2\n[axes]\n\
             topology = ['arima', 'couva']\noutstanding = [1, 4, 'unlimited']\n",
        );
        let run = sweep.run(number);
        prop_assert_eq!(sweep.number(run), number);
        let point = sweep.grid.point(run.point);
        prop_assert_eq!(sweep.grid.number(&sweep.grid.place(run.point)), run.point);
        let row = Bench::default().run(&sweep, run, &point, &Timing::IDEAL).expect("it runs");
        let line = sweep.line(&row);
        prop_assert_eq!(line.split(',').count(), sweep.header().split(',').count());
        let read = sweep.read(&line).expect("what was written");
        prop_assert_eq!(sweep.line(&read), line.clone());
        for torn in 1..line.len() {
            if let Ok(read) = sweep.read(&line[..torn]) {
                // Only a last figure can be cut and still be one.
                prop_assert_eq!(read.run, row.run);
            }
        }
    }
}

#[test]
fn a_point_over_a_whole_link_has_the_seed_of_a_run() {
    let sweep = resolve("name = 'a'\nduration = '1s'\nseed = 7\n[axes]\ntopology = 'couva'\n");
    let point = sweep.grid.point(0);
    assert_eq!(sweep.link_seed(&point, 3), plan::link_seed(7, "couva", 3));
}

#[test]
fn the_built_in_sweeps_can_be_run_and_none_is_long() {
    for (name, source) in SWEEPS {
        let sweep = resolve(source);
        assert_eq!(sweep.name, *name);
        assert!(!sweep.about.is_empty());
        assert!((100..=20_000).contains(&sweep.runs()), "{name}");
    }
}

#[test]
fn the_plant_that_is_swept_is_the_paper_s() {
    let sweep = resolve("name = 'a'\nduration = '1s'\n[axes]\nrtt = '1ms'\n");
    let design = sweep.grid.point(0).design().expect("a loop");
    assert_eq!(design.law, preset::paper_pi().into());
    let own = design.plant.transfer_function().expect("finite");
    let paper = preset::paper_plant().sampled(3_000_000).expect("regular");
    assert_eq!(own, paper.transfer_function().expect("finite"));
}

#[test]
fn the_schema_beside_them_is_the_types_and_each_names_it() {
    let schema = include_str!("../../../sweeps/sweep.schema.json");
    assert_eq!(
        sweep::schema(),
        schema,
        "write `webloop sweep --schema` there"
    );
    for (name, text) in SWEEPS {
        assert!(text.starts_with("#:schema ./sweep.schema.json\n"), "{name}");
    }
}
