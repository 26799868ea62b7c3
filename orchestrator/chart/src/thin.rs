//! Leaves out points that could not be seen; all three forms of a chart share the rest.
//!
//! Paper is divided into cells of half a point (0.18 mm). Of a line's points in one column of cells,
//! the first, the lowest, the highest and the last are kept, so that the line covers the same area.
//! Of the dots in one cell the first is kept. Numbers that cannot be drawn are left out, with a gap
//! in a line.

use crate::beyond;
use crate::chart::{Mark, Series};
use crate::layout;
use crate::point::Point;
use crate::span::Span;

/// With more dots than this, cells are coarser.
const MOST_DOTS: usize = 9_000;

/// Cells of half a point.
const CELLS_PER_POINT: f64 = 2.0;

/// The points of a series that are drawn, in their order.
pub(crate) fn thin(series: &Series, x: &Span, y: &Span, columns: usize) -> Vec<Point> {
    let cells = layout::largest_box(columns);
    let (wide, high) = (cells.0 * CELLS_PER_POINT, cells.1 * CELLS_PER_POINT);
    let points = drawable(series, x, y);
    match series.mark {
        Mark::Line | Mark::Steps | Mark::Area => by_column(&points, wide),
        Mark::Bars(width) => {
            let per_axis = x.fraction(x.lo + width).unwrap_or_default();
            if per_axis * wide < 1.0 && points.iter().all(|point| point.at.0 >= 0.0) {
                by_column(&points, wide)
            } else {
                points
            }
        }
        Mark::Dots => {
            let beyond = beyond::farthest(&points, cells.0, y.scale);
            let inside: Vec<Point> = points.into_iter().filter(in_panel).collect();
            let mut coarse = 1.0;
            loop {
                let kept = by_cell(&inside, wide / coarse, high / coarse);
                if kept.len() <= MOST_DOTS {
                    return [kept, beyond].concat();
                }
                coarse *= 1.25;
            }
        }
    }
}

fn in_panel(point: &Point) -> bool {
    let inside = 0.0..=1.0;
    inside.contains(&point.at.0) && inside.contains(&point.at.1)
}

fn drawable(series: &Series, x: &Span, y: &Span) -> Vec<Point> {
    let bands = series.band.len() == series.points.len();
    let mut after_gap = false;
    let mut points = Vec::with_capacity(series.points.len());
    for (index, value) in series.points.iter().enumerate() {
        let (Some(right), Some(up)) = (x.fraction(value.0), y.fraction(value.1)) else {
            after_gap = !points.is_empty();
            continue;
        };
        let band = series.band.get(index).copied().filter(|(low, high)| {
            bands && y.fraction(*low).is_some() && y.fraction(*high).is_some()
        });
        points.push(Point {
            value: *value,
            band,
            at: (right, up),
            after_gap,
        });
        after_gap = false;
    }
    points
}

fn by_column(points: &[Point], wide: f64) -> Vec<Point> {
    let column = |point: &Point| (point.at.0 * wide).floor();
    points
        .chunk_by(|a, b| column(a) == column(b) && !b.after_gap)
        .flat_map(|run| {
            let level = |index: &usize| run.get(*index).map_or(0.0, |point| point.at.1);
            let lowest = (0..run.len()).min_by(|a, b| level(a).total_cmp(&level(b)));
            let highest = (0..run.len()).max_by(|a, b| level(a).total_cmp(&level(b)));
            let last = run.len().saturating_sub(1);
            run.iter().enumerate().filter_map(move |(index, point)| {
                let stays =
                    index == 0 || index == last || Some(index) == lowest || Some(index) == highest;
                stays.then_some(*point)
            })
        })
        .collect()
}

/// Of the points in a panel, the first in each cell.
fn by_cell(points: &[Point], wide: f64, high: f64) -> Vec<Point> {
    let (columns, rows) = (wide as usize + 1, high as usize + 1);
    let mut taken = vec![false; columns * rows];
    let mut is_first = |point: &&Point| {
        let cell = (point.at.1 * high) as usize * columns + (point.at.0 * wide) as usize;
        // Points of the panel have a cell each.
        let taken = taken.get_mut(cell);
        taken.is_some_and(|taken| !std::mem::replace(taken, true))
    };
    points
        .iter()
        .filter(|point| is_first(point))
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Scale;
    use crate::chart::Tone;
    use proptest::prelude::*;

    const UNIT: Span = Span {
        lo: 0.0,
        hi: 1.0,
        scale: Scale::Linear,
    };

    fn series(mark: Mark, points: Vec<(f64, f64)>) -> Series {
        Series {
            name: String::new(),
            mark,
            tone: Tone::nth(0),
            points,
            band: Vec::new(),
        }
    }

    fn dense() -> impl Strategy<Value = Vec<(f64, f64)>> {
        proptest::collection::vec(0.0..1.0_f64, 1..4000).prop_map(|levels| {
            let many = levels.len() as f64;
            (0..levels.len())
                .map(|n| n as f64 / many)
                .zip(levels)
                .collect()
        })
    }

    proptest! {
        #[test]
        fn a_line_keeps_its_ends_and_extremes(points in dense()) {
            let kept = thin(&series(Mark::Line, points.clone()), &UNIT, &UNIT, 1);
            let values: Vec<(f64, f64)> = kept.iter().map(|point| point.value).collect();
            prop_assert_eq!(values.first(), points.first());
            prop_assert_eq!(values.last(), points.last());
            let highest = |list: &[(f64, f64)]| list.iter().map(|p| p.1).fold(0.0, f64::max);
            let lowest = |list: &[(f64, f64)]| list.iter().map(|p| p.1).fold(1.0, f64::min);
            prop_assert_eq!(highest(&values), highest(&points));
            prop_assert_eq!(lowest(&values), lowest(&points));
            let columns = layout::largest_box(1).0 * CELLS_PER_POINT;
            prop_assert!(values.len() as f64 <= 4.0 * (columns + 1.0));
        }

        #[test]
        fn every_dot_is_near_one_that_stays(points in dense()) {
            let kept = thin(&series(Mark::Dots, points.clone()), &UNIT, &UNIT, 1);
            let (wide, high) = layout::largest_box(1);
            for (x, y) in points {
                let near = kept.iter().any(|dot| {
                    (dot.value.0 - x).abs() * wide <= 0.5 && (dot.value.1 - y).abs() * high <= 0.5
                });
                prop_assert!(near, "({}, {})", x, y);
            }
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_a_gap() {
        let points = vec![(0.0, 0.1), (0.5, f64::NAN), (0.9, 0.2), (1.0, 0.3)];
        let kept = thin(&series(Mark::Line, points), &UNIT, &UNIT, 1);
        let gaps: Vec<(f64, bool)> = kept.iter().map(|p| (p.value.0, p.after_gap)).collect();
        assert_eq!(gaps, [(0.0, false), (0.9, true), (1.0, false)]);
    }
}
