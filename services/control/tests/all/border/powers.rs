//! A loop by the powers of its matrix, 2, 4, 8, .. steps at a time, from all states at once, in 32 digits.

use super::Fate;
use super::system::closed;
use crate::table::Drawn;
use crate::wide::Matrix;

/// By powers of the loop's matrix. Where a mode is hidden it may stay, so that the outputs alone can tell.
pub(super) fn by_powers(of: &Drawn, gain: f64, ticks: usize) -> Fate {
    // As many bits as states that are scaled badly can take; what grows exceeds twice that, and goes on.
    const BITS: f64 = 60.0;
    // What is pushed at the input takes its time to the output.
    const SEEN_AFTER: usize = 30;
    let [mut less_one, push, y] = closed(of, gain, ticks);
    let one = Matrix::identity(less_one.rows);
    let mut power = one.clone().plus(&less_one);
    // The power is `power` times 2^exponent. What became small or large has no digits in common with 1.
    let (mut exponent, mut is_near_one) = (0.0, true);
    for doubled in 1..=44 {
        if is_near_one {
            less_one = less_one.squared();
            power = one.clone().plus(&less_one);
            is_near_one = (0.5..1e6).contains(&power.norm());
        } else {
            power = power.times(&power);
            exponent *= 2.0;
        }
        let scale = power.norm();
        if scale == 0.0 {
            return Fate::DiesOut;
        }
        if !scale.is_finite() {
            return Fate::Open;
        }
        if !is_near_one {
            let bits = scale.log2().round();
            power = power.scaled(2f64.powf(-bits).into());
            exponent += bits;
        }
        if of.hidden > 0 && doubled < SEEN_AFTER {
            continue;
        }
        let size = match of.hidden {
            0 => power.norm(),
            _ => y.times(&power.times(&push)).norm() / (y.norm() * push.norm()),
        };
        match size.log2() + exponent {
            bits if bits < -BITS => return Fate::DiesOut,
            bits if bits > 4.0 * BITS => return Fate::Grows,
            _ => {}
        }
    }
    Fate::Open
}
