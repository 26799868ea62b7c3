//! The points of a figure for zooming, thinned and packed.
//!
//! A coordinate is an integer number of steps, 65 536 per axis. A series is its first point and then
//! the difference of each point from the one before, which takes a fifth of the size of the numbers
//! as text. On a logarithmic axis the logarithms are packed. The figure's own files have every digit.

use chart::{Axis, Chart, GuideAt, Mark, Panel, Scale, Series};
use serde::Serialize;

use crate::figure::Figure;

/// Number of points of a figure, over all its series.
const POINTS: usize = 18_000;
/// The most points of a series, and the fewest to which it is thinned.
const MOST: usize = 2000;
const LEAST: usize = 400;
/// Number of steps of an axis.
const STEPS: f64 = 65_536.0;

/// Whether any panel can be zoomed into.
pub(super) fn is_zoomable(figure: &Figure) -> bool {
    figure.chart.panels.iter().any(is_panel_zoomable)
}

/// Whether there are points to zoom into. Zooming would show nothing more in bars and maps.
pub(super) fn is_panel_zoomable(panel: &Panel) -> bool {
    let traces = || panel.series.iter().filter(|series| is_trace(series));
    panel.map.is_none() && traces().any(|series| !series.points.is_empty())
}

fn is_trace(series: &Series) -> bool {
    !matches!(series.mark, Mark::Bars(_) | Mark::Area)
}

/// The chart's points as JSON that can be embedded in a page.
pub(super) fn json(chart: &Chart) -> String {
    let series = chart.panels.iter().flat_map(|panel| &panel.series);
    let traces = series.filter(|series| is_trace(series)).count().max(1);
    let most = (POINTS / traces).clamp(LEAST, MOST);
    let panels: Vec<PanelTrace<'_>> = chart
        .panels
        .iter()
        .map(|panel| PanelTrace::of(panel, most))
        .collect();
    // Plain data of strings and integers: serialising it cannot fail.
    let text = serde_json::to_string(&panels).unwrap_or_default();
    // `</script>` inside a string would end the element.
    text.replace('<', "\\u003c")
}

#[derive(Serialize)]
struct PanelTrace<'a> {
    title: String,
    x: AxisTrace<'a>,
    y: AxisTrace<'a>,
    series: Vec<SeriesTrace<'a>>,
    guides: Vec<GuideTrace<'a>>,
}

/// How to unpack coordinates: `from + steps * step`, and ten to the power of that if `log`.
#[derive(Serialize)]
struct AxisTrace<'a> {
    label: &'a str,
    log: bool,
    from: f64,
    step: f64,
}

#[derive(Serialize)]
struct SeriesTrace<'a> {
    name: &'a str,
    role: &'static str,
    mark: &'static str,
    x: Vec<i64>,
    y: Vec<i64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    low: Vec<i64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    high: Vec<i64>,
}

#[derive(Serialize)]
struct GuideTrace<'a> {
    name: &'a str,
    at: GuideAt,
}

impl<'a> PanelTrace<'a> {
    fn of(panel: &'a Panel, most: usize) -> PanelTrace<'a> {
        let drawn: Vec<(&Series, Vec<Point>)> = panel
            .series
            .iter()
            .filter(|series| is_trace(series))
            .map(|series| (series, thinned(&points(panel, series), most)))
            .collect();
        let all = || drawn.iter().flat_map(|(_, points)| points);
        let x = AxisTrace::of(&panel.x, all().map(|point| point.x));
        let y = AxisTrace::of(
            &panel.y,
            all()
                .flat_map(|point| [Some(point.y), point.low, point.high])
                .flatten(),
        );
        let series = drawn
            .iter()
            .map(|(series, points)| SeriesTrace {
                name: &series.name,
                role: series.tone.name,
                mark: match series.mark {
                    Mark::Steps => "steps",
                    Mark::Dots => "dots",
                    Mark::Line | Mark::Bars(_) | Mark::Area => "line",
                },
                x: x.packed(points.iter().map(|point| point.x)),
                y: y.packed(points.iter().map(|point| point.y)),
                low: y.packed(points.iter().filter_map(|point| point.low)),
                high: y.packed(points.iter().filter_map(|point| point.high)),
            })
            .collect();
        let title = match panel.letter.as_str() {
            "" => panel.title.clone(),
            letter => format!("({letter}) {}", panel.title),
        };
        PanelTrace {
            title,
            x,
            y,
            series,
            guides: panel
                .guides
                .iter()
                .map(|guide| GuideTrace {
                    name: &guide.name,
                    at: guide.at,
                })
                .collect(),
        }
    }
}

/// A point on its axes: with logarithms on logarithmic ones.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    x: f64,
    y: f64,
    low: Option<f64>,
    high: Option<f64>,
}

/// The points that can be drawn, from left to right; a band has both ends at every point or none.
fn points(panel: &Panel, series: &Series) -> Vec<Point> {
    let on = |axis: &Axis, value: f64| match axis.scale {
        Scale::Linear => value,
        Scale::Log => value.log10(),
    };
    let is_banded = series.band.len() == series.points.len();
    let mut points: Vec<Point> = series
        .points
        .iter()
        .enumerate()
        .filter_map(|(at, (x, y))| {
            let (x, y) = (on(&panel.x, *x), on(&panel.y, *y));
            let end = |value: f64| {
                Some(on(&panel.y, value))
                    .filter(|end| end.is_finite())
                    .or(Some(y))
            };
            let band = series.band.get(at).filter(|_| is_banded);
            (x.is_finite() && y.is_finite()).then(|| Point {
                x,
                y,
                low: band.and_then(|(low, _)| end(*low)),
                high: band.and_then(|(_, high)| end(*high)),
            })
        })
        .collect();
    points.sort_by(|one, other| one.x.total_cmp(&other.x));
    points
}

/// At most `most` points: the lowest and the highest of each stretch, and the first and the last of
/// all, so that a lone peak is kept.
fn thinned(points: &[Point], most: usize) -> Vec<Point> {
    if points.len() <= most {
        return points.to_vec();
    }
    let stretch = points.len().div_ceil((most / 2).saturating_sub(1).max(1));
    let mut kept: Vec<usize> = vec![0, points.len() - 1];
    for (nth, part) in points.chunks(stretch).enumerate() {
        let by_y = |one: &(usize, &Point), other: &(usize, &Point)| one.1.y.total_cmp(&other.1.y);
        let ends = [
            part.iter().enumerate().min_by(by_y),
            part.iter().enumerate().max_by(by_y),
        ];
        kept.extend(ends.into_iter().flatten().map(|(at, _)| nth * stretch + at));
    }
    kept.sort_unstable();
    kept.dedup();
    kept.iter()
        .filter_map(|at| points.get(*at))
        .copied()
        .collect()
}

impl<'a> AxisTrace<'a> {
    fn of(axis: &'a Axis, values: impl Iterator<Item = f64>) -> AxisTrace<'a> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let (from, step) = if high > low {
            (low, (high - low) / STEPS)
        } else {
            (if low.is_finite() { low } else { 0.0 }, 1.0)
        };
        AxisTrace {
            label: &axis.label,
            log: axis.scale == Scale::Log,
            from,
            step,
        }
    }

    fn packed(&self, values: impl Iterator<Item = f64>) -> Vec<i64> {
        let mut before = 0;
        values
            .map(|value| {
                let steps = ((value - self.from) / self.step).round() as i64;
                let difference = steps - before;
                before = steps;
                difference
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unpacked(axis: &AxisTrace<'_>, differences: &[i64]) -> Vec<f64> {
        let mut steps = 0;
        differences
            .iter()
            .map(|difference| {
                steps += difference;
                axis.from + steps as f64 * axis.step
            })
            .collect()
    }

    fn axis(scale: Scale) -> Axis {
        Axis {
            label: "y".to_owned(),
            scale,
            range: None,
            names: Vec::new(),
        }
    }

    proptest! {
        #[test]
        fn packing_moves_no_point_by_more_than_half_a_step(
            values in prop::collection::vec(-1e6f64..1e6, 1..300),
        ) {
            let axis = axis(Scale::Linear);
            let trace = AxisTrace::of(&axis, values.iter().copied());
            let back = unpacked(&trace, &trace.packed(values.iter().copied()));
            let span = values.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b))
                - values.iter().fold(f64::INFINITY, |a, b| a.min(*b));
            for (value, back) in values.iter().zip(back) {
                prop_assert!((value - back).abs() <= 0.501 * span / STEPS + 1e-9);
            }
        }

        #[test]
        fn thinning_keeps_both_extremes_and_both_ends_in_order(
            ys in prop::collection::vec(-1e3f64..1e3, 1..5000), most in 4usize..600,
        ) {
            let points: Vec<Point> = ys
                .iter()
                .enumerate()
                .map(|(x, y)| Point { x: x as f64, y: *y, low: None, high: None })
                .collect();
            let thin = thinned(&points, most);
            prop_assert!(thin.len() <= most.max(4) + 2);
            prop_assert!(thin.windows(2).all(|pair| pair[0].x < pair[1].x));
            prop_assert_eq!(thin.first(), points.first());
            prop_assert_eq!(thin.last(), points.last());
            let highest = |points: &[Point]| points.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
            let lowest = |points: &[Point]| points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(highest(&thin), highest(&points));
            prop_assert_eq!(lowest(&thin), lowest(&points));
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out_and_no_name_ends_the_script() {
        let series = Series {
            name: "</script><b>".to_owned(),
            mark: Mark::Line,
            tone: chart::Tone::nth(0),
            points: vec![(2.0, 100.0), (1.0, 1.0), (3.0, f64::NAN), (4.0, 0.0)],
            band: Vec::new(),
        };
        let panel = Panel {
            letter: "a".to_owned(),
            title: String::new(),
            x: axis(Scale::Linear),
            y: axis(Scale::Log),
            map: None,
            series: vec![series],
            guides: Vec::new(),
            empty: String::new(),
        };
        let drawn = points(&panel, &panel.series[0]);
        let at: Vec<(f64, f64)> = drawn.iter().map(|point| (point.x, point.y)).collect();
        assert_eq!(at, [(1.0, 0.0), (2.0, 2.0)]);
        let chart = Chart {
            tones: &[],
            name: "fig-0".to_owned(),
            title: String::new(),
            about: String::new(),
            source: String::new(),
            columns: 1,
            panels: vec![panel],
        };
        assert!(!json(&chart).contains('<'));
    }
}
