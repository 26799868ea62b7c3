//! Drawn loops, of all laws, orders and sample times, against margins in 60 digits that
//! `fixtures/margins_reference.py` writes. `border` steps the same loops.

use std::num::NonZeroUsize;

use control::{Analysis, OpenLoop, SampledPlant, seconds, step_response};

use crate::table::{Drawn, drawn, named};

/// Within 0.1 %, or as far apart as `least`; where there is none, none.
fn is_near(found: f64, expected: Option<f64>, least: f64) -> bool {
    match expected {
        None => !found.is_finite(),
        Some(expected) => (found - expected).abs() <= (1e-3 * expected.abs()).max(least),
    }
}

fn faults(of: &Drawn) -> Vec<String> {
    let h_s = seconds(of.h_ns);
    let open = OpenLoop::new(&of.plant, &of.law, of.h_ns).expect("finite");
    let found = match Analysis::of(&open) {
        Ok(found) => found,
        Err(problem) => return vec![format!("line {}: {problem}", of.line)],
    };
    let ticks = found.longest_s.map(|s| (s / h_s + 1.0).round());
    let m = found.margins;
    let mut faults = Vec::new();
    for (figure, found, expected, least) in [
        ("gm", m.gain, of.gain, 0.0),
        ("pm", m.phase_deg, of.phase_deg, 1e-3),
        (
            "wpc",
            m.phase_crossover_rad_s,
            of.phase_crossover_rad_s,
            0.0,
        ),
        ("wgc", m.gain_crossover_rad_s, of.gain_crossover_rad_s, 0.0),
        ("delay", m.delay_s, of.delay_s, 1e-3 * h_s),
    ] {
        if !is_near(found, expected, least) {
            faults.push(format!(
                "line {}: {figure} {found} for {expected:?}",
                of.line
            ));
        }
    }
    if ticks != of.longest_ticks {
        faults.push(format!(
            "line {}: longest {ticks:?} for {:?}",
            of.line, of.longest_ticks
        ));
    }
    // One that rounding of the coefficients keeps from being cancelled exactly may be told too.
    if !(of.hidden..=of.hidden + of.nearly).contains(&open.hidden().len()) {
        faults.push(format!(
            "line {}: {} modes are cancelled for {}",
            of.line,
            open.hidden().len(),
            of.hidden
        ));
    }
    faults
}

fn assert_right(all: &[Drawn]) {
    let faults: Vec<String> = all.iter().flat_map(faults).collect();
    assert!(
        faults.is_empty(),
        "{} faults in {} loops:\n{}",
        faults.len(),
        all.len(),
        faults.join("\n")
    );
}

#[test]
fn margins_of_drawn_loops_are_those_in_sixty_digits_none_missing_and_none_invented() {
    assert_right(&drawn());
}

#[test]
fn loops_whose_coefficients_in_z_lose_their_digits_have_the_margins_in_sixty_digits() {
    assert_right(&named());
}

/// Whether the steps of the first output grow from the middle of a response to its end.
fn grows(of: &Drawn, plant: &SampledPlant, ticks: usize, length: usize) -> bool {
    let delay = NonZeroUsize::new(ticks).expect("two or more");
    let y = step_response(plant, of.law.clone(), 1.0, delay, length);
    let largest = |from: usize, to: usize| {
        let steps = y[from..to].windows(2).map(|pair| (pair[1] - pair[0]).abs());
        steps.fold(0.0, |most: f64, step| {
            if step.is_finite() {
                most.max(step)
            } else {
                f64::INFINITY
            }
        })
    };
    let (early, late) = (
        largest(length / 2, length * 5 / 8),
        largest(length * 7 / 8, length),
    );
    // Below that the response rests, and its steps are rounding.
    let all = largest(0, length);
    late.is_infinite() || (late > early && late > 1e-10 * all)
}

#[test]
fn a_delay_inside_the_border_holds_and_one_outside_does_not_as_the_loop_s_own_steps_say() {
    // Longer delays take too long to step, and nothing is other about them.
    const MOST_TICKS: f64 = 100.0;
    const MOST_LOOPS: usize = 150;
    let all = drawn();
    let told = all
        .iter()
        .filter_map(|of| Some((of, of.longest_ticks.filter(|ticks| *ticks < MOST_TICKS)?)));
    let mut parted = Vec::new();
    for (of, ticks) in told.take(MOST_LOOPS) {
        let (plant, ticks) = (of.plant.sampled(of.h_ns).expect("sampled"), ticks as usize);
        // A percent of the delay on either side, so that growth shows.
        let off = 1 + ticks / 100;
        let is_seen = |ticks: usize, grown: bool| {
            let mut lengths = (4..=8).map(|k| 4usize.pow(k) * (ticks + 2));
            lengths.any(|length| grows(of, &plant, ticks, length) == grown)
        };
        if ticks > off + 1 && !is_seen(ticks + 1 - off, false) {
            parted.push(format!("line {}: {ticks} ticks do not hold", of.line));
        }
        if !is_seen(ticks + off, true) {
            parted.push(format!("line {}: {} ticks hold", of.line, ticks + off));
        }
    }
    assert!(parted.is_empty(), "{}", parted.join("\n"));
}
