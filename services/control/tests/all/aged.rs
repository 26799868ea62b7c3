//! State feedback that knows how old each output is, against a filter written apart from it, and against the law for
//! outputs that are always equally old.

use control::{
    AgedFeedback, AnswerFacts, Continuous, Discrete, Estimator, Law, LawInput, Method, Moment,
    Plant, SampledPlant, Signals, StateFeedback, StateSpace, Stepper, TransferFunction, Weights,
    discretise, seconds,
};
use nalgebra::DMatrix;
use proptest::prelude::*;
use serde::Deserialize;

const CASES: &str = include_str!("../fixtures/aged.json");

/// A loop as `aged_reference.py` has computed it.
#[derive(Deserialize)]
struct Case {
    name: String,
    plant: Matrices,
    method: String,
    h_ns: u64,
    r: Vec<f64>,
    weights: Pair,
    noise: Deviations,
    rows: Vec<Row>,
}

#[derive(Deserialize)]
struct Matrices {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    d: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Pair {
    output: Vec<f64>,
    input: Vec<f64>,
}

#[derive(Deserialize)]
struct Deviations {
    disturbance: Vec<f64>,
    measurement: Vec<f64>,
}

#[derive(Deserialize)]
struct Row {
    send_ns: u64,
    told: Option<ToldRow>,
    y: Vec<f64>,
    u: Vec<f64>,
}

#[derive(Deserialize)]
struct ToldRow {
    tick: u64,
    u: Vec<f64>,
    send_ns: u64,
}

fn signals(list: &[f64]) -> Signals {
    Signals {
        first: list[0],
        second: list.get(1).copied(),
    }
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    let entries = rows.iter().flatten().copied();
    DMatrix::from_row_iterator(rows.len(), rows[0].len(), entries)
}

/// The law for a model, and the same for outputs that are always `delay` ticks old.
fn laws(
    model: &StateSpace<Discrete>,
    weights: &Weights,
    estimator: &Estimator,
    others: Vec<f64>,
    (h_ns, delay): (u64, usize),
) -> (Law, Law) {
    let gains = weights.gains(model).expect("reached");
    let observer = estimator.observer(model, delay).expect("seen");
    let assumed = StateFeedback::try_new(model.clone(), gains, observer, others, None);
    let assumed = assumed.expect("fits");
    let noise = estimator.noise(model).expect("seen");
    let aged = AgedFeedback::try_new(assumed.clone(), &noise, h_ns).expect("fits");
    (Law::Aged(Box::new(aged)), Law::StateFeedback(assumed))
}

fn law_of(case: &Case) -> Law {
    let Matrices { a, b, c, d } = &case.plant;
    let model = StateSpace::try_new(matrix(a), matrix(b), matrix(c), matrix(d), Continuous);
    let method = match case.method.as_str() {
        "backward-euler" => Method::BackwardEuler,
        _ => Method::ZeroOrderHold,
    };
    let model = discretise(&model.expect("shapes fit"), method, seconds(case.h_ns));
    let weights = Weights {
        output: case.weights.output.clone(),
        input: case.weights.input.clone(),
    };
    let estimator = Estimator {
        disturbance: case.noise.disturbance.clone(),
        noise: case.noise.measurement.clone(),
    };
    let others = case.r[1..].to_vec();
    let model = model.expect("sampled");
    laws(&model, &weights, &estimator, others, (case.h_ns, 2)).0
}

#[test]
fn commands_by_outputs_of_any_age_are_those_of_a_filter_written_apart() {
    let cases: Vec<Case> = serde_json::from_str(CASES).expect("the fixture");
    for case in cases {
        let mut law = law_of(&case);
        let scale = case.rows.iter().flat_map(|row| &row.u);
        let scale = scale.fold(0.0_f64, |most, u| most.max(u.abs()));
        for (n, row) in case.rows.iter().enumerate() {
            let told = row.told.as_ref().map(|told| AnswerFacts {
                tick: told.tick,
                u: signals(&told.u),
                send_ns: told.send_ns,
            });
            let seen = LawInput {
                y: signals(&row.y),
                times: Some(Moment {
                    send_ns: row.send_ns,
                    told,
                }),
            };
            let found = law.update(case.r[0], seen, seconds(case.h_ns));
            for (found, u) in found.iter().zip(&row.u) {
                let off = (found - u).abs() / scale;
                assert!(off < 1e-8, "{}, message {n}: {found} {u}", case.name);
            }
        }
    }
}

/// The paper's motor, every 3 ms.
fn motor() -> SampledPlant {
    let model = TransferFunction::try_new([2029.826], [1.0, 28.586, 60.361_84], Continuous);
    let plant = Plant::new(&model.expect("proper"), Method::BackwardEuler);
    plant.sampled(H_NS).expect("sampled")
}

const H_NS: u64 = 3_000_000;
const H_S: f64 = 0.003;

fn motor_laws(delay: usize) -> (Law, Law) {
    let weights = Weights {
        output: vec![1.0],
        input: vec![100.0],
    };
    let estimator = Estimator {
        disturbance: vec![0.1],
        noise: vec![0.001],
    };
    laws(
        &motor().system,
        &weights,
        &estimator,
        Vec::new(),
        (H_NS, delay),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// Where every output is equally old and none is left out, both filters come to the same gain and know the same.
    #[test]
    fn outputs_that_are_always_equally_old_bring_the_commands_of_the_law_that_assumes_it(
        delay in 2_usize..9, noise in prop::collection::vec(-0.01..0.01, 600),
    ) {
        let (mut measured, mut assumed) = motor_laws(delay);
        let mut plants = [Stepper::new(&motor().system), Stepper::new(&motor().system)];
        let (mut outputs, mut sent) = (Vec::new(), Vec::new());
        let at = |k: usize| 1_000_000_000 + k as u64 * H_NS;
        for (k, noise) in noise.iter().enumerate() {
            let seen = k.checked_sub(delay).map(|tick| (tick, outputs[tick]));
            let [of_measured, of_assumed] = seen.map_or([0.0; 2], |(_, y)| y);
            let told = seen.map(|(tick, _)| AnswerFacts {
                tick: tick as u64,
                u: sent[tick + 1],
                send_ns: at(tick + 1),
            });
            let times = Some(Moment { send_ns: at(k), told });
            let u = measured.update(1.0, LawInput { y: of_measured.into(), times }, H_S);
            let other = assumed.update(1.0, of_assumed, H_S);
            sent.push(u);
            let y = [plants[0].step(u.first), plants[1].step(other.first)];
            outputs.push(y.map(|y| y + noise));
            if k > 450 {
                prop_assert!((u.first - other.first).abs() < 1e-9, "{k}: {u:?} {other:?}");
            }
        }
    }

    /// What is not finite changes nothing and repeats the last command, and no answer makes it panic.
    #[test]
    fn nonsense_passes_it_by(
        script in prop::collection::vec((any::<u64>(), any::<u64>(), any::<u64>(), -1.0..1.0_f64), 1..20),
    ) {
        let (law, _) = motor_laws(2);
        let (mut clean, mut bothered) = (law.clone(), law);
        for (tick, asked_ns, send_ns, y) in script {
            let seen = |y: f64, u: f64| LawInput {
                y: y.into(),
                times: Some(Moment {
                    send_ns,
                    told: Some(AnswerFacts { tick, u: u.into(), send_ns: asked_ns }),
                }),
            };
            let u = clean.update(1.0, seen(y, 0.1), H_S);
            prop_assert!(u.is_finite());
            for nonsense in [f64::NAN, f64::INFINITY] {
                let before = bothered.clone();
                bothered.update(1.0, seen(nonsense, 0.1), H_S);
                bothered.update(1.0, seen(y, nonsense), H_S);
                bothered.update(nonsense, seen(y, 0.1), H_S);
                prop_assert_eq!(&before, &bothered);
            }
            prop_assert_eq!(bothered.update(1.0, seen(y, 0.1), H_S), u);
        }
    }
}

#[test]
fn an_output_that_was_seen_before_and_one_that_is_older_teach_nothing() {
    let (mut law, _) = motor_laws(2);
    let seen = |tick: u64, y: f64, k: u64| LawInput {
        y: y.into(),
        times: Some(Moment {
            send_ns: 1_000_000_000 + k * H_NS,
            told: Some(AnswerFacts {
                tick,
                u: 0.0.into(),
                send_ns: 1_000_000_000 + tick * H_NS,
            }),
        }),
    };
    law.update(1.0, seen(10, 0.2, 12), H_S);
    let (mut same, mut older) = (law.clone(), law.clone());
    let u = law.update(1.0, seen(10, 0.2, 13), H_S);
    assert_eq!(same.update(1.0, seen(10, 9.0, 13), H_S), u);
    assert_eq!(older.update(1.0, seen(9, 9.0, 13), H_S), u);
}
