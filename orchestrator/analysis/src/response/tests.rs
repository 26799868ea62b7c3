use std::num::NonZeroUsize;

use control::preset::{BARE_SETTLING_3MS_S, paper_pi, paper_plant};
use control::step_response;
use endpoint::Reference;
use plan::system::Band;

use super::*;
use crate::asked::{Asked, Task};

const H_S: f64 = 0.003;
const H_NS: u64 = 3_000_000;

/// The paper's loop at 333 Hz with a constant delay in ticks, over eight seconds.
fn paper(ticks: usize) -> Vec<f64> {
    let plant = paper_plant().sampled(3_000_000).expect("regular");
    let delay = NonZeroUsize::new(ticks).expect("not 0");
    step_response(&plant, paper_pi(), 1.0, delay, (8.0 / H_S) as usize)
}

/// Ticks that are due every h from 0 on: idle ones, the response's, each with a command of its own, and some that
/// hold the last command and this output.
fn rows(y: &[f64], before: usize, after: &[f64]) -> Vec<TickRow> {
    let idle = std::iter::repeat_n((0.0, None), before);
    let run = y.iter().enumerate().map(|(i, y)| (*y, Some(i as u64)));
    let held = after.iter().map(|held| (*held, Some(y.len() as u64 - 1)));
    let row = |(k, (y, seq))| TickRow {
        k: k as u64,
        t_due_ns: k as u64 * H_NS,
        t_tick_ns: k as u64 * H_NS,
        u: 0.0,
        y,
        seq,
        u_applied: None,
    };
    idle.chain(run).chain(held).enumerate().map(row).collect()
}

fn response(rows: &[TickRow]) -> Option<Response> {
    let mut trace = ResponseTrace::new(Aim::step(H_NS));
    rows.iter().for_each(|row| trace.push(row));
    trace.finish()
}

/// The finding on a response from rest to `r`, all of it under command.
fn found(y: &[f64], r: f64) -> Finding {
    let error: Vec<f64> = y.iter().map(|y| y - r).collect();
    let course = Course {
        error: &error,
        y,
        h_s: H_S,
        step: r,
        task: Task::Tracking,
        open: 0,
        overshoot_pct: None,
        effort: 0.0,
        silence: None,
    };
    judge(&course, &Asked::default())
}

fn verdict(y: &[f64], r: f64) -> LoopVerdict {
    found(y, r).verdict
}

#[test]
fn time_runs_from_the_step_to_the_planned_end_and_gives_the_bare_loop_its_settling() {
    let planned = Aim {
        start_ns: Some(500 * H_NS),
        duration_ns: Some(paper(2).len() as u64 * H_NS),
        ..Aim::step(H_NS)
    };
    let of = |aim: &Aim, rows: &[TickRow]| {
        let mut trace = ResponseTrace::new(aim.clone());
        rows.iter().for_each(|row| trace.push(row));
        trace.finish().expect("there are ticks")
    };
    let at_once = of(&planned, &rows(&paper(2), 500, &[99.0; 300]));
    assert_eq!(
        (at_once.verdict, at_once.reason),
        (LoopVerdict::Holds, None)
    );
    let settling_ms = at_once.settling_ms.expect("it settles");
    assert!(
        (settling_ms - BARE_SETTLING_3MS_S * 1e3).abs() < 1e-6,
        "{settling_ms}"
    );
    assert!((at_once.length_s - 8.0).abs() < H_S);
    assert!((at_once.final_value.expect("finite") - 1.0).abs() < 1e-3);
    // The same loop whose first command lands 300 ms late settles 300 ms later: the step does not wait for it.
    let late = of(&planned, &rows(&paper(2), 600, &[]));
    assert_eq!(late.settling_ms, Some(settling_ms + 300.0));
}

#[test]
fn what_the_plant_does_after_its_last_command_is_the_answer() {
    let run = |length: usize, after: &[f64]| {
        let aim = Aim {
            start_ns: Some(0),
            duration_ns: Some(8_000_000_000),
            ..Aim::step(H_NS)
        };
        let mut trace = ResponseTrace::new(aim);
        rows(&paper(2)[..length], 0, after)
            .iter()
            .for_each(|row| trace.push(row));
        trace.finish().expect("there are ticks")
    };
    let rest = 2667 - 1000;
    // It stays where it is, it leaves, and it leaves within the last half second, each without a command.
    let still = run(1000, &vec![1.0; rest]);
    assert_eq!(still.verdict, LoopVerdict::Silent);
    let Some(Reason::Silence(silence)) = still.reason else {
        panic!("{still:?}");
    };
    assert!((silence.from_s - 2.997).abs() < 1e-9, "{silence:?}");
    let away = |k: usize| 1.0 - 0.01 * (0.02 * k as f64).exp();
    let gone = run(1000, &(0..rest).map(away).collect::<Vec<_>>());
    assert_eq!(
        (gone.verdict, gone.reason),
        (LoopVerdict::Lost, Some(Reason::Grows))
    );
    // Twice the step away, 0.01 e^0.02k is 2 after 265 samples.
    assert_eq!(gone.lost_s, Some((1000 + 265) as f64 * H_S));
    assert_eq!(gone.settling_ms, None);
    let leaving = run(2667 - 300, &(0..300).map(away).collect::<Vec<_>>());
    assert_eq!(leaving.verdict, LoopVerdict::Lost, "{leaving:?}");
    // Where no command ever came, the plant was on its own from the start.
    let mut never = ResponseTrace::new(Aim {
        start_ns: Some(0),
        duration_ns: Some(8_000_000_000),
        ..Aim::step(H_NS)
    });
    rows(&[], 2667, &[]).iter().for_each(|row| never.push(row));
    let never = never.finish().expect("there are ticks");
    assert_eq!(never.verdict, LoopVerdict::Silent, "{never:?}");
}

#[test]
fn without_a_tick_there_is_no_response() {
    assert_eq!(response(&[]), None);
}

#[test]
fn the_paper_s_loop_is_judged_as_jury_s_test_says_away_from_the_boundary() {
    // The stability boundary is at 32 ticks (control's fixtures). At 28 the oscillation dies out
    // within eight seconds; at 32 it hardly does, which eight seconds cannot show; at 40 it grows
    // beyond the step.
    let verdicts = [2, 19, 32, 40, 100].map(|ticks| verdict(&paper(ticks), 1.0));
    let [bare, vpn, boundary, beyond, far] = verdicts;
    assert_eq!([bare, vpn], [LoopVerdict::Holds; 2]);
    assert_eq!(boundary, LoopVerdict::Unsettled);
    assert_eq!([beyond, far], [LoopVerdict::Lost; 2]);
}

#[test]
fn a_stall_early_or_late_does_not_lose_a_loop_and_is_not_kept_from_the_reader() {
    // Early: the input of the first rise is held for half a second, with several hundred percent of
    // overshoot. Late: the settled output is 8 % off for 50 ms.
    let mut early = paper(2);
    for (k, y) in early.iter_mut().enumerate().take(400) {
        *y = 5.0 * (-(k as f64) / 100.0).exp() + 1.0;
    }
    assert_eq!(verdict(&early, 1.0), LoopVerdict::Holds);
    let overshot = response(&rows(&early, 0, &[])).expect("there are ticks");
    assert_eq!(overshot.verdict, LoopVerdict::HoldsBadly, "{overshot:?}");
    assert!(matches!(overshot.reason, Some(Reason::Overshoot(pct)) if pct > 400.0));
    let mut late = paper(2);
    let end = late.len() - 100;
    late[end..end + 17].fill(1.08);
    assert_eq!(verdict(&late, 1.0), LoopVerdict::HoldsBadly);
    // Worse and later stalls leave it unsettled, never lost.
    late[end..end + 17].fill(7.0);
    assert_eq!(verdict(&late, 1.0), LoopVerdict::Unsettled);
    // One in the middle, after which it settles again, is named.
    let mut middle = paper(2);
    middle[1200..1300].fill(1.5);
    let Finding {
        verdict, reason, ..
    } = found(&middle, 1.0);
    assert_eq!(verdict, LoopVerdict::HoldsBadly);
    assert_eq!(
        reason,
        Some(Reason::Left {
            at_s: 3.6,
            error: 0.5
        })
    );
}

#[test]
fn a_lasting_oscillation_is_not_settled_and_what_is_no_number_is_unstable() {
    let wave: Vec<f64> = (0..5000)
        .map(|k| 1.0 + (f64::from(k) / 50.0).sin())
        .collect();
    assert_eq!(verdict(&wave, 1.0), LoopVerdict::Unsettled);
    assert_eq!(verdict(&[0.0, 1.0, f64::INFINITY], 1.0), LoopVerdict::Lost);
    assert_eq!(verdict(&[1.0; 4], 1.0), LoopVerdict::Unsettled);
}

#[test]
fn a_negative_reference_is_judged_like_its_mirror_image() {
    for ticks in [2, 32, 40] {
        let y = paper(ticks);
        let mirrored: Vec<f64> = y.iter().map(|y| -y).collect();
        assert_eq!(verdict(&mirrored, -1.0), verdict(&y, 1.0));
    }
}

/// The response of the paper's loop to a reference that moves.
fn following(changes: &[(u64, f64)]) -> Response {
    let plant = paper_plant().sampled(3_000_000).expect("regular");
    let (mut stepper, mut law) = (plant.stepper(), paper_pi());
    let reference = Reference::try_from(changes.to_vec()).expect("times that rise");
    let mut y = 0.0;
    let response: Vec<f64> = (0..(8.0 / H_S) as u64)
        .map(|k| {
            let seen = y;
            y = stepper.step(law.update(reference.at(k * 3_000_000) - y, H_S));
            seen
        })
        .collect();
    let mut trace = ResponseTrace::new(Aim {
        r: reference.at(0),
        reference: Some(reference),
        ..Aim::step(H_NS)
    });
    rows(&response, 5, &[])
        .iter()
        .for_each(|row| trace.push(row));
    trace.finish().expect("commands came")
}

#[test]
fn figures_of_a_reference_that_moves_are_of_its_last_step() {
    let once = following(&[(0, 1.0)]);
    let down = following(&[(0, 1.0), (4_000_000_000, -1.0)]);
    assert_eq!(down.verdict, LoopVerdict::Holds);
    // A linear loop that rested has the same response to each step, up to what is left of the first.
    let of = |figure: Option<f64>| figure.expect("a step has it");
    let same = |a: Option<f64>, b: Option<f64>, by: f64| (of(a) - of(b)).abs() <= by;
    assert!(same(once.settling_ms, down.settling_ms, 3.0), "{down:?}");
    assert!(same(once.rise_ms, down.rise_ms, 3.0), "{down:?}");
    assert!(
        same(once.overshoot_pct, down.overshoot_pct, 0.1),
        "{down:?}"
    );
    // A step of 2 after one of 1 has three times the integral.
    assert!((of(down.iae) / of(once.iae) - 3.0).abs() < 0.05);
    assert!(same(down.final_value, Some(-1.0), 1e-3));
}

#[test]
fn without_a_last_step_the_verdict_is_on_how_the_output_follows() {
    let wave = |period_s: f64| -> Vec<(u64, f64)> {
        let turn = |k: u64| std::f64::consts::TAU * k as f64 * H_S / period_s;
        (0..2600).map(|k| (k * 3_000_000, turn(k).sin())).collect()
    };
    let slow = following(&wave(4.0));
    assert_eq!(slow.verdict, LoopVerdict::Holds, "{slow:?}");
    assert_eq!(
        (slow.settling_ms, slow.rise_ms, slow.overshoot_pct),
        (None, None, None)
    );
    // Far above the loop's bandwidth the output hardly moves.
    assert_eq!(following(&wave(0.05)).verdict, LoopVerdict::Unsettled);
    let y: Vec<f64> = (0..500).map(|k| 1.02f64.powi(k)).collect();
    let r: Vec<f64> = (0..500).map(|k| f64::from(k % 2)).collect();
    let error: Vec<f64> = y.iter().zip(&r).map(|(y, r)| y - r).collect();
    let course = Course {
        error: &error,
        y: &y,
        h_s: H_S,
        step: 1.0,
        task: Task::Tracking,
        open: 0,
        overshoot_pct: None,
        effort: 0.0,
        silence: None,
    };
    let growing = judge_following(&course, &r, &Asked::default());
    assert_eq!(growing.verdict, LoopVerdict::Lost);
}

#[test]
fn from_another_output_the_step_is_to_r_from_there() {
    let toward = |y0: f64, r: f64| {
        let y: Vec<f64> = paper(1).iter().map(|y| y0 + (r - y0) * y).collect();
        let mut trace = ResponseTrace::new(Aim {
            r,
            y0: Some(y0),
            first: Asked {
                band: Some(Band::OfStep(0.02)),
                ..Asked::default()
            },
            ..Aim::step(H_NS)
        });
        rows(&y, 5, &[]).iter().for_each(|row| trace.push(row));
        trace.finish().expect("commands came")
    };
    let (up, back) = (toward(0.0, 1.0), toward(0.5, 0.0));
    assert_eq!(back.verdict, LoopVerdict::Holds);
    assert_eq!(
        (up.settling_ms, up.rise_ms),
        (back.settling_ms, back.rise_ms)
    );
    let overshoots = (
        up.overshoot_pct.expect("some"),
        back.overshoot_pct.expect("some"),
    );
    assert!((overshoots.0 - overshoots.1).abs() < 1e-9, "{overshoots:?}");
    assert!(back.peak.is_some_and(|peak| peak > 0.49), "{back:?}");
}

/// A pendulum about upright, with errors of this size from `from` on: a response of eight seconds to r = 0.
fn regulated(aim: Aim, y: impl Fn(f64) -> f64) -> Response {
    let aim = Aim { r: 0.0, ..aim };
    let mut trace = ResponseTrace::new(aim);
    let y: Vec<f64> = (0..2667).map(|k| y(k as f64 * H_S)).collect();
    rows(&y, 0, &[]).iter().for_each(|row| trace.push(row));
    trace.finish().expect("there are ticks")
}

#[test]
fn a_balanced_pendulum_holds_and_a_fallen_one_is_lost_whatever_the_step_was() {
    // The step is 0.009 rad; the one stays within 0.0002, the other lies at 1.57.
    let aim = || Aim {
        y0: Some(0.009),
        ..Aim::step(H_NS)
    };
    let balanced = |t: f64| 0.009 * (-4.0 * t).exp() + 0.0002 * (40.0 * t).sin();
    let fallen = |t: f64| (0.009 * (3.0 * t).exp()).min(1.57);
    let held = regulated(aim(), balanced);
    assert_eq!((held.verdict, held.reason), (LoopVerdict::Holds, None));
    let lost = regulated(aim(), fallen);
    assert_eq!(lost.verdict, LoopVerdict::Lost, "{lost:?}");
    assert!(matches!(lost.reason, Some(Reason::Away(error)) if (error - 1.57).abs() < 1e-9));
    // With limits the crossing itself is the loss, also where y comes back.
    let limited = Aim {
        first: Asked {
            limits: (-0.3, 0.3),
            ..Asked::default()
        },
        ..aim()
    };
    let swings = |t: f64| {
        if (2.0..2.1).contains(&t) {
            0.31
        } else {
            balanced(t)
        }
    };
    assert!(matches!(
        regulated(limited, swings).reason,
        Some(Reason::Limits { at_s, y }) if (at_s - 2.001).abs() < 1e-9 && y == 0.31
    ));
    assert_eq!(regulated(aim(), |_| 0.0).verdict, LoopVerdict::Holds);
}

/// A program's plant begins where its first tick is: a pendulum that was let go 0.05 rad off comes back into its
/// band, and one that stands at 4.1 rad when its loop begins has 4.1 to go.
#[test]
fn what_no_model_says_of_the_start_the_first_tick_does() {
    let within = |limits| Aim {
        first: Asked {
            band: Some(Band::Absolute(0.01)),
            limits,
            ..Asked::default()
        },
        y0: None,
        ..Aim::step(H_NS)
    };
    let free = within((f64::NEG_INFINITY, f64::INFINITY));
    let caught = regulated(free, |t| 0.05 * (-4.0 * t).exp());
    assert_eq!((caught.verdict, caught.reason), (LoopVerdict::Holds, None));
    assert!(
        caught
            .settling_ms
            .is_some_and(|ms| (ms - 402.0).abs() < 4.0)
    );
    let fallen = regulated(within((-0.5, 0.5)), |_| 4.1);
    let words = fallen.reason.expect("it is lost").to_string();
    assert_eq!(words, "was beyond its limits from the start, y = 4.10");
}

#[test]
fn a_band_in_units_of_y_asks_it_to_stay_and_noise_widens_it() {
    let within = |band: f64, noise: f64| Aim {
        first: Asked {
            band: Some(Band::Absolute(band)),
            ..Asked::of(&plan::system::Holding::default(), 0, noise, 0.0)
        },
        y0: Some(0.001),
        ..Aim::step(H_NS)
    };
    let wave = |t: f64| 0.01 * (5.0 * t).sin();
    assert_eq!(
        regulated(within(0.012, 0.0), wave).verdict,
        LoopVerdict::Holds
    );
    assert_eq!(
        regulated(within(0.008, 0.0), wave).verdict,
        LoopVerdict::Unsettled
    );
    let noisy = regulated(within(0.008, 0.001), wave);
    assert_eq!(noisy.verdict, LoopVerdict::Holds);
    assert!((noisy.band.expect("one is asked") - 0.013).abs() < 1e-12);
    // It left once and came back: it did not stay.
    let bump = |t: f64| if (2.0..2.5).contains(&t) { 0.02 } else { 0.001 };
    let bumped = regulated(within(0.012, 0.0), bump);
    assert_eq!(bumped.verdict, LoopVerdict::HoldsBadly);
    assert_eq!(
        bumped.reason,
        Some(Reason::Left {
            at_s: 2.001,
            error: 0.02
        })
    );
    assert_eq!(bumped.excursion, Some(0.02));
}

#[test]
fn where_nothing_gives_a_scale_what_does_not_grow_holds() {
    let rests = || Aim::step(H_NS);
    assert_eq!(
        regulated(rests(), |t| 1e-5 * (9.0 * t).sin()).verdict,
        LoopVerdict::Holds
    );
    let grows = regulated(rests(), |t| 1e-9 * (3.0 * t).exp());
    assert_eq!(
        (grows.verdict, grows.reason),
        (LoopVerdict::Lost, Some(Reason::Grows))
    );
}
