//! Two axes that act on each other are found, whichever they are; two that do not, are not.

use analysis::sweep::{Figures, PointRuns, Row, findings};
use plan::sweep::{Axis, Sweep};
use proptest::prelude::*;

use crate::lab;

/// Three axes of three levels each.
fn sweep() -> Sweep {
    lab::resolve(
        "name = 'a'\n[sweep]\nduration = '1s'\nrtt = '5ms'\nh = ['1ms', '2ms', '3ms']\n\
         outstanding = ['unlimited', '2', '1']\nkp = [0.1, 0.2, 0.3]\n",
    )
}

/// Points that settle as `settling_ms` says of their places on the three axes.
fn points(sweep: &Sweep, settling_ms: impl Fn([usize; 3]) -> Option<f64>) -> Vec<PointRuns> {
    (0..sweep.grid.points())
        .map(|point| {
            let place = sweep.grid.place(point);
            let axes = sweep.grid.dimensions();
            let of = |axis| place[axes.iter().position(|d| d.axis == axis).expect("varied")];
            let at = [of(Axis::H), of(Axis::Outstanding), of(Axis::Kp)];
            let mut figures = Figures {
                stable: true,
                growth: Some(0.0),
                settling_ms: settling_ms(at),
                rise_ms: None,
                overshoot_pct: None,
                iae_s: None,
                cost_s: None,
                sent_pct: None,
                rtt_median_ms: None,
                rtt_p95_ms: None,
                rtt_max_ms: None,
            };
            figures.stable = figures.settling_ms.is_some();
            let run = sweep.run(point);
            PointRuns::of(&[Row { run, figures }])
        })
        .collect()
}

proptest! {
    #[test]
    fn factors_that_only_multiply_are_no_finding(
        h in prop::array::uniform3(0.5..3.0),
        outstanding in prop::array::uniform3(0.5..3.0),
        kp in prop::array::uniform3(0.5..3.0),
    ) {
        let sweep = sweep();
        let points = points(&sweep, |[a, b, c]| Some(100.0 * h[a] * outstanding[b] * kp[c]));
        prop_assert_eq!(findings(&sweep, &points), vec![]);
    }

    #[test]
    fn a_level_that_makes_another_s_effect_greater_is_found(
        level in 1_usize..3,
        by in 0_usize..3,
        factor in 2.0..10.0,
    ) {
        let sweep = sweep();
        let effect = |b: usize| [1.0, 1.2, 1.4][b];
        let points = points(&sweep, |[a, b, _]| {
            let more = if (b, a) == (level, by) { factor } else { 1.0 };
            Some(100.0 * effect(b) * more)
        });
        let found = findings(&sweep, &points);
        prop_assert!(!found.is_empty());
        let first = &found[0];
        let pair = [first.axis, first.by];
        prop_assert!(pair.contains(&Axis::H) && pair.contains(&Axis::Outstanding));
        prop_assert!((first.factor() / factor - 1.0).abs() < 0.5, "{first}");
    }
}

#[test]
fn what_does_not_settle_in_one_place_only_is_said_so() {
    let sweep = sweep();
    let points = points(&sweep, |[a, b, _]| ((a, b) != (2, 2)).then_some(100.0));
    let words: Vec<String> = findings(&sweep, &points)
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        words,
        [
            "With 1 request under way the step does not settle at h = 3 ms, though it does at h = 1 ms; \
             with unlimited requests under way 1.00 times as late."
        ]
    );
}
