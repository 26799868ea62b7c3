//! A response in equal parts, and whether its error grows from one to the next.

use control::step_info::greatest;

/// Number of equal parts of a response whose largest errors are compared.
pub const PARTS: usize = 5;
/// A lost loop's error grows by more than this factor from one part to the next.
pub(super) const GROWTH: f64 = 1.1;

/// The largest error about `r` in each part; `None` with fewer samples than parts, or one that is not finite.
pub(super) fn worst_errors(y: &[f64], r: f64) -> Option<[f64; PARTS]> {
    if y.len() < PARTS || !y.iter().fold(true, |all, y| all & y.is_finite()) {
        return None;
    }
    let largest = |part: &[f64]| greatest(part, |y| (y - r).abs()).max(0.0);
    Some(std::array::from_fn(|i| largest(part(y, i))))
}

/// Whether each of the last three parts is worse than the one before it by a tenth.
pub(super) fn grows(worst: &[f64; PARTS]) -> bool {
    (PARTS - 3..PARTS).all(|i| worst[i] > GROWTH * worst[i - 1])
}

/// One of the equal parts of a response.
pub(crate) fn part(y: &[f64], i: usize) -> &[f64] {
    &y[y.len() * i / PARTS..y.len() * (i + 1) / PARTS]
}
