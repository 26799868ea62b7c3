//! Agreement with scipy on designs and with python-control on sampled loops with dead time, through the
//! fixtures that `fixtures/make.py` writes.

use control::{
    Continuous, Estimator, Gains, Method, Plant, StateSpace, TransferFunction, Weights, margins,
};
use nalgebra::DMatrix;
use serde::Deserialize;

#[derive(Deserialize)]
struct Design {
    name: String,
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    c: Vec<f64>,
    h_s: f64,
    delay: usize,
    output: f64,
    input: f64,
    disturbance: f64,
    noise: f64,
    gains: Vec<f64>,
    observer: Vec<f64>,
}

fn assert_near(found: &[f64], expected: &[f64], what: &str) {
    // Both solve the Riccati equation in their own way, to about the square root of the precision
    // where modes are slow; the largest entry sets the scale.
    const TOLERANCE: f64 = 1e-6;
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= TOLERANCE * scale,
            "{what}: {found} {expected}"
        );
    }
}

#[test]
fn gains_and_observers_are_scipy_s() {
    let cases: Vec<Design> =
        serde_json::from_str(include_str!("../fixtures/designs.json")).expect("by make.py");
    assert_eq!(cases.len(), 9);
    for case in cases {
        let n = case.b.len();
        let model = StateSpace::try_new(
            DMatrix::from_row_iterator(n, n, case.a.iter().flatten().copied()),
            DMatrix::from_column_slice(n, 1, &case.b),
            DMatrix::from_row_slice(1, n, &case.c),
            DMatrix::zeros(1, 1),
            Continuous,
        )
        .expect("shapes fit");
        let plant = Plant {
            model,
            dead_time_ns: 0,
            method: Method::ZeroOrderHold,
        };
        let sampled = plant
            .sampled((case.h_s * 1e9).round() as u64)
            .expect("sampled");
        let weights = Weights {
            output: vec![case.output],
            input: vec![case.input],
        };
        let gains = weights.gains(&sampled.system).expect("reached");
        assert_near(
            gains.as_slice(),
            &case.gains,
            &format!("gains of {}", case.name),
        );
        let estimator = Estimator {
            disturbance: vec![case.disturbance],
            noise: vec![case.noise],
        };
        let observer = estimator
            .observer(&sampled.system, case.delay)
            .expect("seen");
        assert_near(
            observer.as_slice(),
            &case.observer,
            &format!("observer of {}", case.name),
        );
    }
}

#[derive(Deserialize)]
struct Around {
    name: String,
    num: Vec<f64>,
    den: Vec<f64>,
    dead_time_s: f64,
    h_s: f64,
    kp: f64,
    ki: f64,
    kd: f64,
    filter_rad_s: Option<f64>,
    gm: f64,
    pm: f64,
    wpc: f64,
    wgc: f64,
}

#[test]
fn margins_of_a_sampled_loop_with_its_dead_time_and_two_ticks_are_python_control_s() {
    // Its margins are interpolated between 4000 frequencies.
    const TOLERANCE: f64 = 1e-4;
    let cases: Vec<Around> =
        serde_json::from_str(include_str!("../fixtures/loops.json")).expect("by make.py");
    assert_eq!(cases.len(), 3);
    for case in cases {
        let model = TransferFunction::try_new(case.num, case.den, Continuous).expect("proper");
        let plant = Plant {
            dead_time_ns: (case.dead_time_s * 1e9).round() as u64,
            ..Plant::new(&model, Method::ZeroOrderHold)
        };
        let sampled = plant
            .sampled((case.h_s * 1e9).round() as u64)
            .expect("sampled");
        let gains = Gains {
            kp: case.kp,
            ki: case.ki,
            kd: case.kd,
            filter_rad_s: case.filter_rad_s.unwrap_or(f64::INFINITY),
        };
        let around = sampled
            .transfer_function()
            .and_then(|plant| plant.series(&gains.sampled(case.h_s)?))
            .expect("finite");
        let found = margins(&around, 2.0 * case.h_s).expect("a short dead time");
        for (figure, found, expected) in [
            ("gm", found.gain, case.gm),
            ("pm", found.phase_deg, case.pm),
            ("wpc", found.phase_crossover_rad_s, case.wpc),
            ("wgc", found.gain_crossover_rad_s, case.wgc),
        ] {
            assert!(
                (found / expected - 1.0).abs() < TOLERANCE,
                "{} {figure}: {found}, expected {expected}",
                case.name
            );
        }
    }
}
