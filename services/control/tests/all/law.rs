//! What laws must do, whatever their numbers.

use std::collections::VecDeque;
use std::num::NonZeroUsize;

use control::{
    Continuous, Discrete, Estimator, Gains, Law, Method, Pid, Plant, SampledPlant, Signals, Smith,
    StateFeedback, StateSpace, Stepper, Transfer, TransferFunction, Weights, discretise,
    step_response,
};
use nalgebra::DMatrix;
use proptest::prelude::*;

const H_NS: u64 = 10_000_000;
const H_S: f64 = 0.01;

fn plant(num: &[f64], den: &[f64], dead_time_ns: u64) -> SampledPlant {
    let model = TransferFunction::try_new(num, den, Continuous).expect("proper");
    let plant = Plant {
        dead_time_ns,
        ..Plant::new(&model, Method::ZeroOrderHold)
    };
    plant.sampled(H_NS).expect("sampled")
}

fn pid(kp: f64, ki: f64, kd: f64, filter_rad_s: f64) -> Pid {
    let gains = Gains {
        kp,
        ki,
        kd,
        filter_rad_s,
    };
    Pid::try_new(gains, None).expect("finite")
}

fn feedback(plant: &SampledPlant, delay: usize) -> StateFeedback {
    let weights = Weights {
        output: vec![10.0],
        input: vec![0.1],
    };
    let estimator = Estimator {
        disturbance: vec![1.0],
        noise: vec![0.01],
    };
    let model = &plant.system;
    let gains = weights.gains(model).expect("reached");
    let observer = estimator
        .observer(model, delay + plant.delay_ticks)
        .expect("seen");
    StateFeedback::try_new(model.clone(), gains, observer, Vec::new(), None).expect("fits")
}

/// One of each kind.
fn laws() -> Vec<Law> {
    let lag = plant(&[2.0], &[1.0, 1.5], 50_000_000);
    let cart = plant(&[1.0], &[1.0, 0.3, 0.0], 0);
    let lead = TransferFunction::try_new([3.0, 2.0], [0.1, 1.0], Continuous).expect("proper");
    let lead = discretise(&StateSpace::from(&lead), Method::Tustin, H_S).expect("stable");
    vec![
        pid(1.2, 0.7, 0.0, f64::INFINITY).into(),
        pid(1.2, 0.7, 0.2, 30.0).into(),
        pid(1.2, 0.0, 0.2, f64::INFINITY).into(),
        Law::Transfer(Transfer::try_new(lead, None).expect("no limits")),
        Law::Smith(Smith::new(
            pid(2.0, 3.0, 0.0, f64::INFINITY),
            lag.system.clone(),
            6,
        )),
        Law::Smith(Smith::new(pid(2.0, 3.0, 0.1, 20.0), lag.system, 0)),
        Law::StateFeedback(feedback(&cart, 3)),
    ]
}

proptest! {
    /// Running it, its state space and its transfer function are three ways to say the same.
    #[test]
    fn a_law_is_its_state_space_and_its_transfer_function(
        y in prop::collection::vec(-1.0f64..1.0, 60),
    ) {
        for mut law in laws() {
            let mut by_states = Stepper::new(&law.state_space(H_S).expect("finite"));
            let g = law.transfer_function(H_S).expect("finite");
            let mut by_ratio = Stepper::new(&StateSpace::from(&g));
            for y in &y {
                let u = law.update(0.0, *y, H_S).first;
                let scale = 1e-7 * u.abs().max(1.0);
                let (states, ratio) = (by_states.step(*y), by_ratio.step(-*y));
                prop_assert!((states - u).abs() < scale, "{law:?}: {states} {u}");
                prop_assert!((ratio - u).abs() < 1e3 * scale, "{law:?}: {ratio} {u}");
            }
        }
    }

    /// What is not finite changes nothing and repeats the last command.
    #[test]
    fn nonsense_passes_a_law_by(y in prop::collection::vec(-1.0f64..1.0, 30), at in 1usize..29) {
        for law in laws() {
            let (mut clean, mut bothered) = (law.clone(), law);
            for (k, y) in y.iter().enumerate() {
                let u = clean.update(1.0, *y, H_S);
                prop_assert_eq!(bothered.update(1.0, *y, H_S), u);
                if k == at {
                    for nonsense in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                        prop_assert_eq!(bothered.update(1.0, nonsense, H_S), u);
                        prop_assert_eq!(bothered.update(nonsense, *y, H_S), u);
                    }
                }
            }
        }
    }
}

#[test]
fn a_smith_predictor_that_knows_its_plant_does_as_if_there_were_no_dead_time_but_later() {
    // Without dead time the loop of model and PID has one tick, as the model is seen a tick late.
    for (dead_time_ns, rtt_ns) in [(200_000_000, 0), (200_000_000, 35_000_000), (0, 80_000_000)] {
        let own = plant(&[1.0], &[1.0, 1.0], dead_time_ns);
        let prompt = plant(&[1.0], &[1.0, 1.0], 0);
        let pi = pid(10.0, 10.0, 0.0, f64::INFINITY);
        let ticks = Smith::ticks(&own, rtt_ns, H_NS);
        let law = Law::Smith(Smith::new(pi.clone(), own.system.clone(), ticks));
        let delay = control::loop_delay_ticks(rtt_ns, H_NS);
        let late = step_response(&own, law, 1.0, delay, 400);
        let one = NonZeroUsize::MIN;
        let ideal = step_response(&prompt, pi, 1.0, one, 400);
        let behind = own.delay_ticks;
        for k in behind..400 {
            assert!(
                (late[k] - ideal[k - behind]).abs() < 1e-9,
                "{k}: {} {}",
                late[k],
                ideal[k - behind]
            );
        }
    }
}

#[test]
fn gains_by_weights_are_those_of_the_textbook() {
    // A mass, 1/s², in continuous time: q y² + r u² has the gains (sqrt(q/r), sqrt(2 sqrt(q/r))).
    // Sampled a thousand times as fast as that, it has nearly those.
    let model = TransferFunction::try_new([1.0], [1.0, 0.0, 0.0], Continuous).expect("proper");
    let plant = Plant::new(&model, Method::ZeroOrderHold)
        .sampled(1_000_000)
        .expect("sampled");
    let weights = Weights {
        output: vec![16.0],
        input: vec![1.0],
    };
    // The canonical form's states are rate and place.
    let gains = weights.gains(&plant.system).expect("reached");
    assert!((gains[0] / 8f64.sqrt() - 1.0).abs() < 5e-3, "{gains:?}");
    assert!((gains[1] / 4.0 - 1.0).abs() < 5e-3, "{gains:?}");
}

/// A system of `n` states from its rows, sampled.
fn matrices(n: usize, a: &[f64], b: &[f64], c: &[f64]) -> StateSpace<Discrete> {
    let (m, p) = (b.len() / n, c.len() / n);
    let model = StateSpace::try_new(
        DMatrix::from_row_slice(n, n, a),
        DMatrix::from_row_slice(n, m, b),
        DMatrix::from_row_slice(p, n, c),
        DMatrix::zeros(p, m),
        Continuous,
    );
    discretise(&model.expect("shapes fit"), Method::ZeroOrderHold, H_S).expect("sampled")
}

fn designed(model: &StateSpace<Discrete>, others: Vec<f64>) -> StateFeedback {
    let weights = Weights {
        output: vec![10.0; model.outputs()],
        input: vec![0.1; model.inputs()],
    };
    let estimator = Estimator {
        disturbance: vec![1.0; model.inputs()],
        noise: vec![0.01; model.outputs()],
    };
    let gains = weights.gains(model).expect("reached");
    let observer = estimator.observer(model, 3).expect("seen");
    StateFeedback::try_new(model.clone(), gains, observer, others, None).expect("fits")
}

/// The outputs after `ticks` ticks in the loop with `law`, which sees them three ticks late.
fn held(model: &StateSpace<Discrete>, law: StateFeedback, r: f64, ticks: usize) -> Signals {
    let (mut plant, mut law) = (Stepper::new(model), Law::StateFeedback(law));
    let mut under_way = VecDeque::from(vec![Signals::zeros(model.outputs()); 3]);
    let mut y = Signals::default();
    for _ in 0..ticks {
        let seen = under_way.pop_front().expect("three of them");
        y = plant.step_all(law.update(r, seen, H_S));
        under_way.push_back(y);
    }
    y
}

#[test]
fn a_cart_goes_to_its_place_and_keeps_its_pendulum_upright() {
    // Place and angle of a pendulum of 1 m on a cart of 1 kg, with a bob of 0.1 kg; the force is the one input.
    let (g, of_bob) = (9.81, 0.1);
    let a = [
        0.0,
        1.0,
        0.0,
        0.0,
        0.0,
        0.0,
        -of_bob * g,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
        0.0,
        0.0,
        1.1 * g,
        0.0,
    ];
    let c = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let cart = matrices(4, &a, &[0.0, 1.0, 0.0, -1.0], &c);
    let y = held(&cart, designed(&cart, Vec::new()), 0.5, 2_000);
    assert!((y.first - 0.5).abs() < 1e-6, "{y:?}");
    assert!(y.second.expect("the angle").abs() < 1e-6, "{y:?}");
}

#[test]
fn two_inputs_hold_two_outputs_at_two_references() {
    // Two tanks, each with its pump, that exchange a third of what they differ by.
    let a = [-0.8, 0.3, 0.3, -0.5];
    let tanks = matrices(2, &a, &[1.0, 0.0, 0.0, 2.0], &[1.0, 0.0, 0.0, 1.0]);
    let y = held(&tanks, designed(&tanks, vec![-0.25]), 1.0, 2_000);
    assert!((y.first - 1.0).abs() < 1e-6, "{y:?}");
    assert!((y.second.expect("two") + 0.25).abs() < 1e-6, "{y:?}");
    // Without a second reference the inputs are the least that hold the first output.
    let y = held(&tanks, designed(&tanks, Vec::new()), 1.0, 2_000);
    assert!((y.first - 1.0).abs() < 1e-6, "{y:?}");
    // A law for two outputs takes no single one.
    let mut law = Law::StateFeedback(designed(&tanks, Vec::new()));
    assert_eq!(law.update(1.0, 0.0, H_S), Signals::zeros(2));
    assert_eq!(law.signals(), (2, 2));
}

#[test]
fn two_equal_loops_side_by_side_are_each_as_alone() {
    let alone = matrices(2, &[0.0, 1.0, 0.0, -0.3], &[0.0, 1.0], &[1.0, 0.0]);
    let both = matrices(
        4,
        &[
            0.0, 1.0, 0.0, 0.0, 0.0, -0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -0.3,
        ],
        &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    );
    for ticks in [10, 50, 300] {
        let one = held(&alone, designed(&alone, Vec::new()), 1.0, ticks).first;
        let two = held(&both, designed(&both, vec![1.0]), 1.0, ticks);
        for y in two.iter() {
            assert!((y - one).abs() < 1e-8, "{ticks}: {one} {two:?}");
        }
    }
}

#[test]
fn a_filter_makes_out_what_a_late_output_hides() {
    // An unstable pendulum, seen 5 ticks late, from rest to 0.1 rad.
    let pendulum = plant(&[1.0], &[1.0, 0.0, -9.81], 0);
    let law = Law::StateFeedback(feedback(&pendulum, 5));
    let delay = NonZeroUsize::new(5).expect("not 0");
    let y = step_response(&pendulum, law, 0.1, delay, 1_000);
    assert!((y[999] - 0.1).abs() < 1e-6, "{}", y[999]);
}
