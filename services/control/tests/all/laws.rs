//! What must hold for every system, gain and sample time.

use control::{
    AntiWindup, Complex, Continuous, Discrete, Gains, Law, Method, Pid, Plant, SampledPlant,
    Saturation, StateSpace, Stepper, Timebase, TransferFunction, discretise,
    largest_stable_blocking_round_trip_s, margins,
};
use nalgebra::DMatrix;
use proptest::prelude::*;

/// Factors with stable poles: real at -a, or a pair with natural frequency w and damping z.
fn stable_denominator() -> impl Strategy<Value = Vec<f64>> {
    let real = (0.01f64..100.0).prop_map(|a| vec![1.0, a]);
    let pair = (0.1f64..100.0, 0.05f64..1.0).prop_map(|(w, z)| vec![1.0, 2.0 * z * w, w * w]);
    prop::collection::vec(prop_oneof![real, pair], 1..3).prop_map(|factors| {
        factors.iter().fold(vec![1.0], |product, factor| {
            let mut out = vec![0.0; product.len() + factor.len() - 1];
            for (i, x) in product.iter().enumerate() {
                for (j, y) in factor.iter().enumerate() {
                    out[i + j] += x * y;
                }
            }
            out
        })
    })
}

fn sampled(system: &TransferFunction, method: Method, h_s: f64) -> StateSpace<Discrete> {
    discretise(&StateSpace::from(system), method, h_s)
        .expect("no pole where the method has its own")
}

/// 1/(s + a).
fn lag(a: f64) -> TransferFunction {
    TransferFunction::try_new([1.0], [1.0, a], Continuous).expect("valid")
}

/// Log-uniform sample times from a microsecond to ten seconds.
fn sample_time_s() -> impl Strategy<Value = f64> {
    (-6.0f64..1.0).prop_map(|decade| 10f64.powf(decade))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn a_dead_time_is_the_same_as_commands_under_way_and_as_states(
        den in stable_denominator(),
        delay_ticks in 0usize..25,
        (kp, ki) in (-2.0f64..2.0, 0.0f64..4.0),
    ) {
        // One path counts the commands that are under way, the other has a state for each tick of the dead time.
        let rest = *den.last().expect("not empty");
        let model = TransferFunction::try_new([rest], den, Continuous).expect("valid");
        let law = Law::from(Pid::try_new(Gains::pi(10f64.powf(kp), ki), None).expect("finite"));
        let mut plant = Plant::new(&model, Method::ZeroOrderHold).sampled(10_000_000).expect("sampled");
        plant.delay_ticks = delay_ticks;
        let states = SampledPlant { system: plant.state_space(), delay_ticks: 0 };
        let [one, other] = [&plant, &states].map(|plant| largest_stable_blocking_round_trip_s(plant, &law));
        match (one, other) {
            (Ok(one), Ok(other)) => prop_assert_eq!(one, other),
            (Err(_), _) | (_, Err(_)) => return Err(TestCaseError::reject("rounding would decide")),
        }
    }
}

proptest! {
    #[test]
    fn a_stable_system_stays_stable_by_every_method_and_sample_time(
        den in stable_denominator(),
        h_s in 0.1f64..10.0,
    ) {
        // 1/(1 - hp), e^(hp) and (1 + hp/2)/(1 - hp/2) map the left half-plane into the unit
        // circle. The slowest pole stays 0.01 rad/s x 0.1 s = 1e-3 inside it, and four poles in one
        // place are known to eps^(1/4) = 1e-4.
        let system = TransferFunction::try_new([1.0], den, Continuous).expect("valid");
        for method in [Method::BackwardEuler, Method::ZeroOrderHold, Method::Tustin] {
            let sampled = sampled(&system, method, h_s);
            let timebase = sampled.timebase();
            prop_assert!(sampled.poles().into_iter().all(|p| timebase.is_stable(p)), "{method:?}");
        }
    }

    #[test]
    fn one_backward_euler_pole_is_where_the_substitution_puts_it(
        a in 1e-3f64..1e6,
        h_s in sample_time_s(),
    ) {
        let pole = sampled(&lag(a), Method::BackwardEuler, h_s).poles()[0];
        prop_assert!((pole.re - 1.0 / (1.0 + a * h_s)).abs() < 1e-14 && pole.im == 0.0);
        prop_assert!(pole.re > 0.0 && pole.re < 1.0, "monotone and stable for every h");
    }

    #[test]
    fn zero_order_hold_is_exact_at_the_samples(
        a in 0.01f64..50.0,
        h_s in 1e-4f64..1.0,
        u in -10.0f64..10.0,
    ) {
        // 1/(s + a) with u held from 0 is u (1 - e^(-a k h)) / a at sample k.
        let mut stepper = Stepper::new(&sampled(&lag(a), Method::ZeroOrderHold, h_s));
        for k in 0..50 {
            let exact = -u * (-a * f64::from(k) * h_s).exp_m1() / a;
            prop_assert!((stepper.step(u) - exact).abs() <= 1e-12 * (u / a).abs().max(1.0));
        }
    }

    #[test]
    fn tustin_keeps_the_response_on_a_warped_axis(
        den in stable_denominator(),
        h_s in 1e-3f64..0.5,
        part in 0.01f64..0.95,
    ) {
        // G_d(e^(jwh)) = G(j v) with v = 2/h tan(wh/2): an identity, so only rounding may differ.
        let continuous = TransferFunction::try_new([1.0], den, Continuous).expect("valid");
        let sampled = sampled(&continuous, Method::Tustin, h_s);
        let omega = part * std::f64::consts::PI / h_s;
        let warped = 2.0 / h_s * (omega * h_s / 2.0).tan();
        let expected = continuous.frequency_response(warped);
        let n = sampled.order();
        let z = sampled.timebase().point(omega);
        let pencil = DMatrix::identity(n, n) * z - sampled.a().map(Complex::from);
        let states = pencil.lu().solve(&sampled.b().map(Complex::from)).expect("no pole on the circle");
        let found = (sampled.c().map(Complex::from) * states)[0] + sampled.d0();
        // Near Nyquist the gain is the feed-through less nearly the same again; compare with the
        // size of both.
        let size = expected.norm() + sampled.d0().abs();
        prop_assert!((found - expected).norm() <= 1e-7 * size, "{found} {expected}");
    }

    #[test]
    fn the_dc_gain_survives_every_method(
        den in stable_denominator(),
        gain in -10.0f64..10.0,
        h_s in 1e-2f64..1.0,
    ) {
        let continuous = TransferFunction::try_new([gain], den, Continuous).expect("valid");
        for method in [Method::BackwardEuler, Method::ZeroOrderHold, Method::Tustin] {
            let sampled = sampled(&continuous, method, h_s);
            let n = sampled.order();
            let pencil = DMatrix::identity(n, n) - sampled.a();
            let rest = pencil.lu().solve(sampled.b()).expect("stable, so no pole at 1");
            let found = (sampled.c() * rest)[0] + sampled.d0();
            let expected = continuous.dc_gain();
            prop_assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{method:?}");
        }
    }

    #[test]
    fn the_pid_is_its_transfer_function_by_backward_euler(
        (kp, ki, kd) in (-5.0f64..5.0, -5.0f64..5.0, -1.0f64..1.0),
        filter_rad_s in 0.1f64..1e3,
        h_s in 1e-3f64..0.5,
        errors in prop::collection::vec(-10.0f64..10.0, 1..60),
    ) {
        let gains = Gains { kp, ki, kd, filter_rad_s };
        let law = gains.transfer_function().expect("filtered");
        let mut stepper = Stepper::new(&sampled(&law, Method::BackwardEuler, h_s));
        let mut pid = Pid::try_new(gains, None).expect("valid");
        for e in errors {
            let (expected, found) = (stepper.step(e), pid.update(e, h_s));
            // Terms up to kd N e = 1e4 cancel, so 1e-9 is thirteen digits of them.
            let size = 1.0 + kd.abs() * filter_rad_s;
            prop_assert!((found - expected).abs() <= 1e-9 * size, "{found} {expected}");
        }
    }

    #[test]
    fn without_limits_commands_add_as_errors_do(
        errors in prop::collection::vec((-9.0f64..9.0, -9.0f64..9.0), 1..50),
    ) {
        let gains = Gains { kp: 1.3, ki: 0.7, kd: 0.2, filter_rad_s: 40.0 };
        let new = || Pid::try_new(gains, None).expect("valid");
        let (mut first, mut second, mut both) = (new(), new(), new());
        for (x, y) in errors {
            let sum = first.update(x, 0.003) + second.update(y, 0.003);
            prop_assert!((both.update(x + y, 0.003) - sum).abs() < 1e-10);
        }
    }

    #[test]
    fn a_limited_command_keeps_its_limits_whatever_the_anti_windup(
        errors in prop::collection::vec(
            prop_oneof![-1e6f64..1e6, Just(f64::NAN), Just(f64::INFINITY)],
            1..100,
        ),
        gain_per_s in 0.01f64..1e4,
    ) {
        let back_calculation = AntiWindup::BackCalculation { gain_per_s };
        for anti_windup in [AntiWindup::Off, AntiWindup::Conditional, back_calculation] {
            let saturation = Saturation { min: -0.5, max: 2.0, anti_windup };
            let mut pid = Pid::try_new(Gains::pi(1.0, 3.0), Some(saturation)).expect("valid");
            for e in &errors {
                prop_assert!((-0.5..=2.0).contains(&pid.update(*e, 0.01)));
            }
        }
    }

    #[test]
    fn dead_time_as_long_as_the_delay_margin_leaves_none(k in 0.2f64..50.0, a in 0.1f64..20.0) {
        // k/(s (s + a)) has a single gain crossover; a dead time does not move it, and takes w T of
        // its phase.
        let system = TransferFunction::try_new([k], [1.0, a, 0.0], Continuous).expect("valid");
        let free = margins(&system, 0.0).expect("valid");
        let half = margins(&system, free.delay_s / 2.0).expect("valid");
        prop_assert!((half.delay_s - free.delay_s / 2.0).abs() < 1e-9 * free.delay_s.max(1.0));
        prop_assert!((half.phase_deg - free.phase_deg / 2.0).abs() < 1e-6);
        // At the margin itself the gain margin is 1 by definition.
        let spent = margins(&system, free.delay_s).expect("valid");
        prop_assert!((spent.gain - 1.0).abs() < 1e-6, "{spent:?}");
    }

    #[test]
    fn sampling_a_loop_ever_faster_leads_to_its_continuous_margins(k in 0.5f64..5.0, a in 0.5f64..5.0) {
        // A hold delays by h/2, so at the crossover the phase differs by w h/2, under 5 rad/s x 1
        // ms / 2 = 0.15 deg.
        let continuous = TransferFunction::try_new([k], [1.0, a, 0.0], Continuous).expect("valid");
        let sampled = sampled(&continuous, Method::ZeroOrderHold, 1e-3);
        let found = margins(&sampled.transfer_function().expect("finite"), 0.0).expect("valid");
        let expected = margins(&continuous, 0.0).expect("valid");
        let hold_deg = (expected.gain_crossover_rad_s * 0.5e-3).to_degrees();
        let off_deg = expected.phase_deg - hold_deg - found.phase_deg;
        prop_assert!(off_deg.abs() < 1e-2, "{expected:?} {found:?}");
    }
}

#[test]
fn a_sample_time_is_a_positive_finite_number() {
    assert!(Discrete::try_new(0.003).is_ok());
    assert!(Discrete::try_new(0.0).is_err() && Discrete::try_new(f64::NAN).is_err());
}
