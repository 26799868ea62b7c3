//! Agreement with python-control 0.10.2 and scipy, through the fixtures that `fixtures/make.py`
//! writes.

use std::num::NonZeroUsize;

use control::preset::{self, motor, paper_gains, paper_pi};
use control::{
    Continuous, Discrete, Margins, Method, StateSpace, StepInfo, StepSettings, TransferFunction,
    discretise, largest_stable_round_trip_s, margins, step_info, step_response,
};
use serde::Deserialize;

/// Equal within `tolerance` of the larger of the expected value and `scale`.
fn assert_near(found: f64, expected: f64, scale: f64, tolerance: f64, what: &str) {
    let allowed = tolerance * expected.abs().max(scale);
    assert!(
        (found - expected).abs() <= allowed,
        "{what}: {found}, expected {expected} within {allowed:e}"
    );
}

/// `null` in a fixture is a figure that does not exist: not finite here.
fn assert_figure(found: f64, expected: Option<f64>, tolerance: f64, what: &str) {
    match expected {
        Some(expected) => assert_near(found, expected, 1e-3, tolerance, what),
        None => assert!(!found.is_finite(), "{what}: {found}, expected none"),
    }
}

fn read<T: for<'de> Deserialize<'de>>(json: &str) -> Vec<T> {
    serde_json::from_str(json).expect("fixtures are written by make.py")
}

#[derive(Deserialize)]
struct Sampled {
    name: String,
    num: Vec<f64>,
    den: Vec<f64>,
    method: String,
    h_s: f64,
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    c: Vec<f64>,
    d: f64,
}

#[test]
fn every_method_samples_every_system_matrix_by_matrix_as_scipy_does() {
    // Entries are sums of a few products of numbers near the largest entry; the stiff system, whose
    // entries reach 1e4 at h = 0.1 s, decides the tolerance: 1e-10 of the largest entry of its
    // matrix.
    const TOLERANCE: f64 = 1e-10;
    let cases: Vec<Sampled> = read(include_str!("../fixtures/sampled.json"));
    assert_eq!(cases.len(), 8 * 3 * 3);
    for case in cases {
        let method = match case.method.as_str() {
            "backward-euler" => Method::BackwardEuler,
            "zero-order-hold" => Method::ZeroOrderHold,
            "tustin" => Method::Tustin,
            other => panic!("unknown method {other} in a fixture"),
        };
        let system = TransferFunction::try_new(case.num, case.den, Continuous).expect("valid");
        let found = discretise(&StateSpace::from(&system), method, case.h_s).expect("regular");
        let what = format!("{}, {method:?}, h = {} s", case.name, case.h_s);
        let a: Vec<f64> = found.a().transpose().iter().copied().collect();
        let found = [
            a,
            found.b().as_slice().to_vec(),
            found.c().iter().copied().collect(),
            vec![found.d0()],
        ];
        let expected = [case.a.concat(), case.b, case.c, vec![case.d]];
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found.len(), expected.len(), "{what}");
            let scale = expected.iter().fold(1e-6, |max: f64, x| max.max(x.abs()));
            for (found, expected) in found.iter().zip(expected) {
                assert_near(*found, *expected, scale, TOLERANCE, &what);
            }
        }
    }
}

#[derive(Deserialize)]
struct MarginCase {
    name: String,
    num: Vec<f64>,
    den: Vec<f64>,
    h_s: Option<f64>,
    dead_time_s: f64,
    gm: Option<f64>,
    pm: Option<f64>,
    wpc: Option<f64>,
    wgc: Option<f64>,
}

#[test]
fn margins_are_python_control_s_for_continuous_sampled_and_delayed_loops() {
    // python-control finds crossovers of sampled loops as roots near multiple ones, good to about
    // eight digits, and those of delayed continuous loops on splines through a grid of 40 000
    // points a decade.
    const TOLERANCE: f64 = 1e-7;
    for case in read::<MarginCase>(include_str!("../fixtures/margins.json")) {
        let what = format!("{}, dead time {} s", case.name, case.dead_time_s);
        let found: Margins = match case.h_s {
            None => margins(
                &TransferFunction::try_new(case.num, case.den, Continuous).expect("valid"),
                case.dead_time_s,
            ),
            Some(h_s) => {
                let h = Discrete::try_new(h_s).expect("positive");
                margins(
                    &TransferFunction::try_new(case.num, case.den, h).expect("valid"),
                    case.dead_time_s,
                )
            }
        }
        .expect("a valid dead time");
        assert_figure(found.gain, case.gm, TOLERANCE, &format!("gm of {what}"));
        assert_figure(
            found.phase_deg,
            case.pm,
            TOLERANCE,
            &format!("pm of {what}"),
        );
        assert_figure(
            found.phase_crossover_rad_s,
            case.wpc,
            TOLERANCE,
            &format!("wpc of {what}"),
        );
        assert_figure(
            found.gain_crossover_rad_s,
            case.wgc,
            TOLERANCE,
            &format!("wgc of {what}"),
        );
    }
}

/// python-control's names, as it spells them.
#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Figures {
    rise_time: Option<f64>,
    settling_time: Option<f64>,
    settling_min: Option<f64>,
    settling_max: Option<f64>,
    overshoot: Option<f64>,
    undershoot: Option<f64>,
    peak: Option<f64>,
    peak_time: Option<f64>,
    steady_state_value: Option<f64>,
}

fn assert_figures(found: &StepInfo, expected: &Figures, tolerance: f64, what: &str) {
    let pairs = [
        ("RiseTime", found.rise_time, expected.rise_time),
        ("SettlingTime", found.settling_time, expected.settling_time),
        ("SettlingMin", found.settling_min, expected.settling_min),
        ("SettlingMax", found.settling_max, expected.settling_max),
        ("Overshoot", found.overshoot, expected.overshoot),
        ("Undershoot", found.undershoot, expected.undershoot),
        ("Peak", found.peak, expected.peak),
        ("PeakTime", found.peak_time, expected.peak_time),
        (
            "SteadyStateValue",
            found.steady_state_value,
            expected.steady_state_value,
        ),
    ];
    for (name, found, expected) in pairs {
        assert_figure(found, expected, tolerance, &format!("{name} of {what}"));
    }
}

#[derive(Deserialize)]
struct Step {
    name: String,
    t: Vec<f64>,
    y: Vec<f64>,
    final_value: Option<f64>,
    info: Figures,
}

#[test]
fn the_figures_of_a_given_response_are_python_control_s() {
    // The same samples go in, so only the rounding of a subtraction or two may differ.
    const TOLERANCE: f64 = 1e-12;
    for case in read::<Step>(include_str!("../fixtures/steps.json")) {
        let settings = StepSettings {
            final_value: case.final_value,
            ..StepSettings::default()
        };
        let found = step_info(&case.t, &case.y, &settings).expect("finite");
        assert_figures(&found, &case.info, TOLERANCE, &case.name);
    }
}

#[derive(Deserialize)]
struct ClosedLoop {
    h_s: f64,
    ticks: usize,
    largest_stable_ticks: usize,
    every: usize,
    y: Vec<f64>,
    info: Figures,
}

#[test]
fn the_paper_s_loop_runs_as_its_closed_transfer_function_does() {
    // The fixture filters with the expanded polynomial, whose poles near 1 amplify rounding of the
    // coefficients by 1/(1 - p)², about 2e5 at h = 1 ms, once for each of a few hundred samples:
    // 1e-8 holds that.
    const TOLERANCE: f64 = 1e-8;
    for case in read::<ClosedLoop>(include_str!("../fixtures/closed_loops.json")) {
        let what = format!("h = {} s, {} ticks", case.h_s, case.ticks);
        let sampled = |system: &TransferFunction| {
            discretise(&StateSpace::from(system), Method::BackwardEuler, case.h_s).expect("regular")
        };
        let plant = sampled(&motor());
        let controller = sampled(&paper_gains().transfer_function().expect("proper"));
        let open = plant
            .transfer_function()
            .and_then(|plant| plant.series(&controller.transfer_function()?))
            .expect("finite and sampled alike");
        let length = (3.0 / case.h_s).round() as usize;
        let plant = preset::paper_plant()
            .sampled((case.h_s * 1e9).round() as u64)
            .expect("regular");
        let y = match NonZeroUsize::new(case.ticks) {
            Some(delay) => step_response(&plant, paper_pi(), 1.0, delay, length),
            None => {
                let mut closed =
                    control::Stepper::new(&StateSpace::from(&open.feedback().expect("solvable")));
                (0..length).map(|_| closed.step(1.0)).collect()
            }
        };
        for (found, expected) in y.iter().step_by(case.every).zip(&case.y) {
            assert_near(*found, *expected, 1.0, TOLERANCE, &what);
        }
        let t: Vec<f64> = (0..length).map(|k| k as f64 * case.h_s).collect();
        let settings = StepSettings {
            final_value: Some(1.0),
            ..StepSettings::default()
        };
        let info = step_info(&t, &y, &settings).expect("finite");
        // Overshoot is a hundred times a difference of 0.03 between numbers near 1.
        assert_figures(&info, &case.info, 100.0 * TOLERANCE, &what);

        let longest_s = largest_stable_round_trip_s(&open).expect("stable");
        assert_eq!(
            (longest_s / case.h_s).round() as usize + 1,
            case.largest_stable_ticks,
            "{what}"
        );
    }
}
