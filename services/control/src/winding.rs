//! How many poles of a closed loop are unstable, for any number of ticks around it, without computing one of them.
//!
//! F, the product of 1 - p/z over the open loop's poles times 1 + L (or det(1 + L)), has no pole outside the unit
//! circle, is 1 far away, and has its zeros at the closed loop's poles. So along the upper half of the circle its
//! angle falls by half a turn for each zero outside (A. L. Cauchy; H. Nyquist, 1932). Where |L| < 1 the angle is
//! that of the product and of 1 + L, which stays within a quarter turn; where |L| > 1 it is that of the product
//! times L, and of 1 + 1/L. So poles on the circle do not matter, and a delay adds its own angle, exactly.

use std::f64::consts::PI;

use nalgebra::Complex;

use crate::scan::{Node, Scan, Unsure, level, product};

/// The number of poles outside the unit circle with `ticks` more around the loop.
pub(crate) fn unstable_poles(scan: &Scan<'_>, ticks: usize) -> Result<u64, Unsure> {
    // At both ends F is real, so its angle is a whole number of half turns.
    const WHOLE: f64 = 0.1;
    let Some(h_s) = scan.of.h_s() else {
        return Err(Unsure::Border);
    };
    let dead_s = scan.of.dead_time_s() + ticks as f64 * h_s;
    let mut turned = 0.0;
    let mut start = None;
    let nodes: Vec<Node> = rest_node(scan).iter().chain(&scan.nodes).copied().collect();
    for pair in nodes.windows(2) {
        let Some([a, b]) = pair.first_chunk::<2>() else {
            continue;
        };
        let leads = leading_between(a, b);
        let ahead = leads.iter().filter(|leads| **leads).count() as f64;
        let by = (product(&b.at, leads) / product(&a.at, leads)).arg();
        let (first, next) = (rest(a, leads, dead_s), rest(b, leads, dead_s));
        start.get_or_insert_with(|| product(&a.at, leads).arg() - ahead * a.rad_s * dead_s + first);
        turned += by - ahead * (b.rad_s - a.rad_s) * dead_s + next - first;
    }
    let start = start.unwrap_or(0.0);
    let half_turns = (turned + start - (start / PI).round() * PI) / PI;
    let whole = half_turns.round();
    // A mode at z = 1 or a pole on the circle leaves F's angle between.
    if !((half_turns - whole).abs() < WHOLE && (start / PI - (start / PI).round()).abs() < WHOLE) {
        return Err(Unsure::Border);
    }
    Ok((-whole).max(0.0) as u64)
}

/// The loop at rest, where F is real however close to 0 it is; none with an integrator, whose branch alone is there.
fn rest_node(scan: &Scan<'_>) -> Option<Node> {
    const SAME: f64 = 0.5;
    let first = *scan.nodes.first()?;
    let rest = scan.beside(first, 0.0)?;
    let zero = Complex::new(0.0, 0.0);
    let mut both = rest.at.loci.iter().zip(&first.at.loci);
    both.all(|(a, b)| a == b || (*b != zero && (a / b - 1.0).norm() < SAME))
        .then_some(rest)
}

/// Which loci lead between two nodes; at a crossover the other end decides.
fn leading_between(a: &Node, b: &Node) -> [bool; 2] {
    [0, 1].map(|locus| {
        let [x, y] = [a, b].map(|node| level(node.at.loci[locus]));
        x + y > 0.0
    })
}

/// The angle of 1 + L, or of 1 + 1/L where L leads.
fn rest(node: &Node, leads: [bool; 2], dead_s: f64) -> f64 {
    let later = Complex::from_polar(1.0, -node.rad_s * dead_s);
    let angles = node.at.loci.iter().zip(leads).map(|(l, leads)| {
        let l = l * later;
        (1.0 + if leads { l.inv() } else { l }).arg()
    });
    angles.sum()
}
