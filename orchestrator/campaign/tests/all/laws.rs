//! What a sweep must be, whatever is swept.

use analysis::sweep::{Limit, PointRuns, Row, borders, header, limit};
use campaign::Bench;
use control::preset;
use plan::EXPERIMENTS;
use plan::system::System;
use proptest::prelude::*;
use sim::Timing;

use crate::lab::{resolve, run_all};

#[test]
fn the_longest_stable_round_trip_is_within_one_sample_of_the_computed_one() {
    let sweep = resolve(
        "name = 'margin'\n[sweep]\nduration = '10s'\nh = ['1ms', '3ms']\n\
         outstanding = ['unlimited', '1']\n\
         rtt = '31 from 70ms to 100ms'\n",
    );
    let points = PointRuns::all(&sweep, &run_all(&sweep));
    let borders = borders(&sweep, &points);
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
        // Of a law that measures ages there is no limit by analysis.
        system.is_single() && system.surroundings().is_none() && !system.measures_age()
    };
    for name in System::built_in_names().filter(is_taken) {
        for outstanding in ["unlimited", "1"] {
            let of = |rtt: &str| {
                resolve(&format!(
                    "name = 'margin'\n[sweep]\nduration = '120s'\nh = '10ms'\nsystem = '{name}'\n\
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
            let points = PointRuns::all(&sweep, &run_all(&sweep));
            for border in borders(&sweep, &points) {
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
            "name = 'margin'\n[sweep]\nduration = '20s'\nh = '{h_ms}ms'\nkp = {kp}\nki = {ki}\n\
             outstanding = '{outstanding}'\nrtt = {rtt}\n"
        ));
        let Limit::Until(limit_ms) = limit(&of("'1ms'").grid.point(0)) else {
            return Err(TestCaseError::reject("no stable loop"));
        };
        prop_assume!(limit_ms.is_finite());
        let around = (-3..=3).map(|k| limit_ms + f64::from(k) * f64::from(h_ms));
        let rtts: Vec<String> = around.filter(|ms| *ms > 0.0).map(|ms| format!("'{ms}ms'")).collect();
        let sweep = of(&format!("[{}]", rtts.join(", ")));
        let points = PointRuns::all(&sweep, &run_all(&sweep));
        for border in borders(&sweep, &points) {
            prop_assert_eq!(border.agrees(), Some(true), "{:?}", border);
        }
    }

    #[test]
    fn a_row_is_the_same_whatever_was_run_before_it(seed in any::<u32>(), first in 0_usize..16) {
        let sweep = resolve(&format!(
            "name = 'mixed'\nseed = {seed}\n[sweep]\nduration = '1s'\nrepeats = 2\n\
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
            "name = 'rows'\n[sweep]\nduration = '500ms'\nrepeats = 2\n\
             topology = ['arima', 'couva']\noutstanding = [1, 4, 'unlimited']\n",
        );
        let run = sweep.run(number);
        prop_assert_eq!(sweep.number(run), number);
        let point = sweep.grid.point(run.point);
        prop_assert_eq!(sweep.grid.number(&sweep.grid.place(run.point)), run.point);
        let row = Bench::default().run(&sweep, run, &point, &Timing::IDEAL).expect("it runs");
        let line = row.line(&sweep);
        prop_assert_eq!(line.split(',').count(), header(&sweep).split(',').count());
        let read = Row::read(&line, &sweep).expect("what was written");
        prop_assert_eq!(read.line(&sweep), line.clone());
        for torn in 1..line.len() {
            if let Ok(read) = Row::read(&line[..torn], &sweep) {
                // Only a last figure can be cut and still be one.
                prop_assert_eq!(read.run, row.run);
            }
        }
    }
}

#[test]
fn a_point_over_a_whole_link_has_the_seed_of_a_run() {
    let sweep = resolve("name = 'a'\nseed = 7\n[sweep]\nduration = '1s'\ntopology = 'couva'\n");
    let point = sweep.grid.point(0);
    assert_eq!(sweep.link_seed(&point, 3), plan::link_seed(7, "couva", 3));
}

#[test]
fn the_built_in_sweeps_can_be_run_and_none_is_long() {
    let sweeps = EXPERIMENTS
        .iter()
        .filter(|(_, text)| text.contains("[sweep]"));
    let mut count = 0;
    for (name, source) in sweeps {
        let sweep = resolve(source);
        assert!(!sweep.about.is_empty());
        assert!((100..=20_000).contains(&sweep.runs()), "{name}");
        count += 1;
    }
    assert_eq!(count, 5);
}

#[test]
fn the_plant_that_is_swept_is_the_paper_s() {
    let sweep = resolve("name = 'a'\n[sweep]\nduration = '1s'\nrtt = '1ms'\n");
    let design = sweep.grid.point(0).design().expect("a loop");
    assert_eq!(design.law, preset::paper_pi().into());
    let own = design.plant.transfer_function().expect("finite");
    let paper = preset::paper_plant().sampled(3_000_000).expect("regular");
    assert_eq!(own, paper.transfer_function().expect("finite"));
}
