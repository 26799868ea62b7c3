//! Panels of one figure share their axes, so that they can be compared, unless they differ tenfold.

use chart::{Axis, Mark, Panel, Scale};

/// Panels whose spans differ by more than this keep their own.
const TENFOLD: f64 = 10.0;

/// Room between what is drawn and the edge, as a part of the range; as a factor on a logarithmic axis.
const ROOM: f64 = 0.05;
const LOG_ROOM: f64 = 1.1;

/// Which axis of a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    X,
    Y,
}

/// Gives the panels at these places one range on an axis, in groups that differ less than tenfold.
pub(super) fn share(panels: &mut [Panel], which: Which, places: &[usize]) {
    let ranges: Vec<Option<(f64, f64)>> = places
        .iter()
        .map(|at| panels.get(*at).and_then(|panel| range(panel, which)))
        .collect();
    let scale = places
        .first()
        .and_then(|at| panels.get(*at))
        .map(|panel| axis(panel, which).scale);
    let shared = shared(&ranges, scale.unwrap_or(Scale::Linear));
    for (at, range) in places.iter().zip(shared) {
        let Some(panel) = panels
            .get_mut(*at)
            .filter(|panel| axis(panel, which).names.is_empty())
        else {
            continue;
        };
        let axis = match which {
            Which::X => &mut panel.x,
            Which::Y => &mut panel.y,
        };
        axis.range = range.or(axis.range);
    }
}

/// The same for all panels.
pub(super) fn share_all(panels: &mut [Panel], which: Which) {
    let places: Vec<usize> = (0..panels.len()).collect();
    share(panels, which, &places);
}

/// The ranges, each widened to all that differ less than tenfold from the smallest of its group.
pub(super) fn shared(ranges: &[Option<(f64, f64)>], scale: Scale) -> Vec<Option<(f64, f64)>> {
    let size = |(low, high): (f64, f64)| match scale {
        Scale::Linear => high - low,
        Scale::Log => high,
    };
    let mut sorted: Vec<(usize, (f64, f64))> = ranges
        .iter()
        .enumerate()
        .filter_map(|(at, range)| Some((at, (*range)?)))
        .collect();
    sorted.sort_by(|(_, one), (_, other)| size(*one).total_cmp(&size(*other)));
    let mut out = ranges.to_vec();
    let mut rest = sorted.as_slice();
    while let Some((_, smallest)) = rest.first() {
        let most = TENFOLD * size(*smallest);
        let (group, later) = rest.split_at(
            rest.partition_point(|(_, range)| size(*range) <= most)
                .max(1),
        );
        let all = group.iter().fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), (_, range)| (low.min(range.0), high.max(range.1)),
        );
        for (at, _) in group {
            out[*at] = Some(all);
        }
        rest = later;
    }
    out
}

fn axis(panel: &Panel, which: Which) -> &Axis {
    match which {
        Which::X => &panel.x,
        Which::Y => &panel.y,
    }
}

/// The range of an axis, or that of what is drawn with some room; upwards from zero, where it begins near zero.
fn range(panel: &Panel, which: Which) -> Option<(f64, f64)> {
    let axis = axis(panel, which);
    if axis.range.is_some() {
        return axis.range;
    }
    let points = panel.series.iter().flat_map(|series| {
        let ends = series.band.iter().flat_map(|(low, high)| [*low, *high]);
        let ends = ends.filter(|_| which == Which::Y && series.mark == Mark::Area);
        let points = series.points.iter().map(|(x, y)| match which {
            Which::X => *x,
            Which::Y => *y,
        });
        points.chain(ends)
    });
    let is_drawn = |value: &f64| value.is_finite() && (axis.scale == Scale::Linear || *value > 0.0);
    let (low, high) = points
        .filter(is_drawn)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low >= high {
        return None;
    }
    Some(match (axis.scale, which) {
        (Scale::Log, _) => (low / LOG_ROOM, high * LOG_ROOM),
        (Scale::Linear, Which::X) => (low, high),
        (Scale::Linear, Which::Y) => {
            let is_near_zero = low >= 0.0 && low < high / 2.0;
            let low = if is_near_zero { 0.0 } else { low };
            let room = ROOM * (high - low);
            (if low == 0.0 { 0.0 } else { low - room }, high + room)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_shared_unless_they_differ_tenfold() {
        let ranges = [
            Some((0.0, 1.2)),
            None,
            Some((-0.5, 3.0)),
            Some((0.0, 200.0)),
            Some((0.0, 150.0)),
        ];
        let low = Some((-0.5, 3.0));
        let high = Some((0.0, 200.0));
        assert_eq!(shared(&ranges, Scale::Linear), [low, None, low, high, high]);
        let logs = [Some((0.1, 5.0)), Some((1.0, 60.0)), Some((2.0, 40.0))];
        let own = [Some((0.1, 40.0)), Some((1.0, 60.0)), Some((0.1, 40.0))];
        assert_eq!(shared(&logs, Scale::Log), own);
    }
}
