//! Assigns each axis: to x, to y or to lines, or to panels.

use plan::sweep::{Axis, Dimension};

/// An axis is long if it has at least this many levels.
const LONG: usize = 6;
/// What each axis is drawn along, by its position among the dimensions.
pub(super) struct Layout {
    pub(super) form: Form,
    /// Along the horizontal axis.
    pub(super) x: usize,
    /// Along the vertical axis of a map, or as separate lines.
    pub(super) other: Option<usize>,
    /// In separate panels.
    pub(super) panels: Vec<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Tiles,
    Lines,
}

impl Layout {
    /// The layout of these axes; `None` if nothing is varied.
    pub(super) fn of(dimensions: &[Dimension<'_>]) -> Option<Layout> {
        let varied: Vec<usize> = (0..dimensions.len())
            .filter(|at| dimensions[*at].levels.len() > 1)
            .collect();
        let size = |at: &usize| dimensions[*at].levels.len();
        let without = |gone: &[usize]| -> Vec<usize> {
            let others = varied.iter().filter(|at| !gone.contains(at));
            others.copied().collect()
        };
        let mut long: Vec<usize> = varied.clone();
        long.retain(|at| size(at) >= LONG && is_numeric(&dimensions[*at]));
        // The longest first, in stable order.
        long.sort_by_key(|at| std::cmp::Reverse(size(at)));
        if let [one, two, ..] = long[..] {
            // The round trip goes along x, so that its limit crosses it.
            let is_rtt = |at: usize| dimensions[at].axis == Axis::Rtt;
            let (x, y) = if is_rtt(two) || !is_rtt(one) && two < one {
                (two, one)
            } else {
                (one, two)
            };
            return Some(Layout {
                form: Form::Tiles,
                x,
                other: Some(y),
                panels: without(&[x, y]),
            });
        }
        let ordered = varied
            .iter()
            .filter(|at| dimensions[**at].axis.is_ordered());
        let x = *ordered.max_by_key(|at| size(at)).or(varied.first())?;
        let rest = without(&[x]);
        // An axis of names becomes the lines; if there is none, the axis that changes fastest.
        let named = rest.iter().find(|at| !dimensions[**at].axis.is_ordered());
        let other = named.or(rest.last()).copied();
        Some(Layout {
            form: Form::Lines,
            x,
            other,
            panels: without(&[Some(x), other].into_iter().flatten().collect::<Vec<_>>()),
        })
    }
}

/// Whether each of its levels is a number.
pub(super) fn is_numeric(dimension: &Dimension<'_>) -> bool {
    dimension.levels.iter().all(|level| level.number.is_some())
}
