//! The levels of a map's values: their round bounds, and their colours.
//!
//! Colours are in steps and not a ramp: a shade between two others could not be found again in a
//! legend, nor in print.

use std::collections::BTreeMap;

use crate::axis::Scale;
use crate::chart::Chart;
use crate::grid;
use crate::map::{Map, Tile};
use crate::palette::{Colour, MOST};
use crate::span::{Span, drawable};
use crate::tick::{Step, Ticks, written};

/// With fewer levels than this by powers of ten, even steps are better.
const FEWEST: usize = 4;

/// Leading digits of bounds by powers of ten, the finest first. After the last of them come steps of
/// several decades.
const DIGITS: [&[f64]; 4] = [
    &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 3.0],
    &[1.0],
];

/// The largest number of decades between two bounds.
const MOST_DECADES: i32 = 100;

/// The levels of all maps of a chart, by the label of their values.
pub(crate) fn all(chart: &Chart) -> BTreeMap<&str, Levels> {
    let mut maps: BTreeMap<&str, Vec<&Map>> = BTreeMap::new();
    for map in chart.panels.iter().filter_map(grid::map) {
        maps.entry(&map.value.label).or_default().push(map);
    }
    maps.into_iter()
        .map(|(label, maps)| (label, Levels::of(&maps)))
        .collect()
}

/// What the colours of one quantity mean.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Levels {
    /// Bounds in ascending order, with their labels; a level is from one to the next. Empty without
    /// values.
    pub(crate) bounds: Vec<(f64, String)>,
    /// Common factor and offset of all labels; often empty.
    pub(crate) note: String,
    /// Whether the first level includes everything below it.
    pub(crate) is_open_below: bool,
    /// Whether the last level includes everything above it.
    pub(crate) is_open_above: bool,
    /// The name of hatched tiles, if there are any.
    pub(crate) hatched: Option<&'static str>,
    /// Whether any tile is blank.
    pub(crate) has_blank: bool,
}

impl Levels {
    /// Levels for all values of these maps.
    fn of(maps: &[&Map]) -> Levels {
        let tiles = || maps.iter().flat_map(|map| map.all());
        let values: Vec<f64> = tiles()
            .filter_map(|tile| match tile {
                Tile::Value(value) => Some(value),
                Tile::Hatched | Tile::None => None,
            })
            .collect();
        let marks = maps
            .first()
            .and_then(|map| {
                Span::asked(&map.value)
                    .or_else(|| span(&values, map.value.scale))
                    .or_else(|| span(&values, Scale::Linear))
            })
            .filter(|_| !values.is_empty())
            .map(|span| bounds(&span))
            .unwrap_or_default();
        let bounds = marks.labelled;
        let least = bounds.first().map_or(f64::MIN, |(bound, _)| *bound);
        let most = bounds.last().map_or(f64::MAX, |(bound, _)| *bound);
        Levels {
            is_open_below: values.iter().any(|value| *value < least),
            is_open_above: values.iter().any(|value| *value > most),
            hatched: maps
                .iter()
                .find(|map| map.all().any(|tile| tile == Tile::Hatched))
                .map(|map| map.hatched),
            has_blank: tiles().any(|tile| tile == Tile::None),
            note: marks.note,
            bounds,
        }
    }

    /// Number of levels.
    pub(crate) fn count(&self) -> usize {
        self.bounds.len().saturating_sub(1)
    }

    /// The level of a value; if it is on a bound, the level above the bound.
    pub(crate) fn at(&self, value: f64) -> usize {
        let reached = self.bounds.partition_point(|(bound, _)| *bound <= value);
        let last = self.count().saturating_sub(1);
        reached.saturating_sub(1).min(last)
    }

    /// The colour of a level. Two or more levels use the full range from the lightest to the darkest.
    pub(crate) fn colour(&self, level: usize) -> Colour {
        let steps = self.count().saturating_sub(1);
        let at = match steps {
            0 => MOST / 2,
            _ => (level * (MOST - 1) + steps / 2) / steps,
        };
        Colour::Level(at)
    }

    /// A colour of text that can be read on a level. Low levels are close to the paper, on a dark
    /// page too.
    pub(crate) fn colour_over(&self, level: usize) -> Colour {
        match self.colour(level) {
            Colour::Level(at) if at >= MOST / 2 => Colour::Paper,
            _ => Colour::Ink,
        }
    }

    /// A level in words: `0.5 to 1`.
    pub(crate) fn name(&self, level: usize) -> String {
        let written = |bound: usize| {
            self.bounds
                .get(bound)
                .map_or("", |(_, label)| label.as_str())
        };
        let (from, to) = (written(level), written(level + 1));
        let is_first = level == 0 && self.is_open_below;
        let is_last = level + 1 == self.count() && self.is_open_above;
        let name = match (is_first, is_last) {
            (false, false) => format!("{from} to {to}"),
            (true, false) => format!("below {to}"),
            (false, true) => format!("{from} and more"),
            (true, true) => "any".to_owned(),
        };
        format!("{name} {}", self.note).trim_end().to_owned()
    }
}

/// The range of the values that can be drawn on a scale.
fn span(values: &[f64], scale: Scale) -> Option<Span> {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (lo, hi) = values
        .iter()
        .filter(|value| drawable(**value, scale))
        .fold(none, |(lo, hi), value| (lo.min(*value), hi.max(*value)));
    (lo <= hi).then(|| Span { lo, hi, scale }.widened())
}

/// Levels between round numbers that enclose a span.
fn bounds(span: &Span) -> Ticks {
    let powers = match span.scale {
        Scale::Linear => None,
        Scale::Log => powers(span),
    };
    powers.unwrap_or_else(|| even(span))
}

fn even(span: &Span) -> Ticks {
    let length = (span.hi / 2.0 - span.lo / 2.0) / (MOST - 1) as f64 * 2.0;
    let step = Step::at_least(length);
    let length = step.times(1.0);
    // A value that misses a bound only by rounding is on it.
    let lo = step.times((span.lo / length + 1e-9).floor()).max(f64::MIN);
    let hi = step.times((span.hi / length - 1e-9).ceil()).min(f64::MAX);
    let around = Span {
        lo,
        hi,
        scale: Scale::Linear,
    };
    match lo < hi && length > 0.0 {
        true => Ticks::of(&around, ((hi - lo) / length).round() as usize),
        // The span is too short or too long for arithmetic: one level.
        false => Ticks {
            labelled: vec![(span.lo, String::new()), (span.hi, String::new())],
            ..Ticks::default()
        },
    }
}

/// Bounds by powers of ten; `None` if the span is so short that even steps are as good.
fn powers(span: &Span) -> Option<Ticks> {
    let finest = DIGITS.iter().map(|digits| (*digits, 1));
    let coarse = (2..=MOST_DECADES).map(|decades| (&[1.0][..], decades));
    let some = finest
        .chain(coarse)
        .filter_map(|(digits, decades)| enclosing(span, digits, decades))
        .find(|bounds| bounds.len() <= MOST + 1)
        .filter(|bounds| bounds.len() > FEWEST)?;
    Some(Ticks {
        labelled: written(&some),
        ..Ticks::default()
    })
}

/// The numbers with these leading digits in every `decades`-th decade that enclose a span.
fn enclosing(span: &Span, digits: &[f64], decades: i32) -> Option<Vec<Step>> {
    let first = (span.lo.log10() / f64::from(decades)).floor() as i32 * decades - decades;
    let last = span.hi.log10().ceil() as i32 + decades;
    let numbers: Vec<Step> = (first..=last)
        .step_by(usize::try_from(decades).ok()?)
        .flat_map(|exponent| digits.iter().map(move |digit| Step::new(*digit, exponent)))
        .filter(|number| number.times(1.0).is_normal())
        .collect();
    let least = numbers
        .iter()
        .rposition(|number| number.times(1.0) <= span.lo * (1.0 + 1e-9))?;
    let most = numbers
        .iter()
        .position(|number| number.times(1.0) >= span.hi * (1.0 - 1e-9))?;
    numbers.get(least..=most).map(<[Step]>::to_vec)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::map::Along;
    use proptest::prelude::*;

    fn map(values: &[f64], scale: Scale, range: Option<(f64, f64)>) -> Map {
        Map {
            value: Axis {
                label: "settling/s".to_owned(),
                scale,
                range,
                names: Vec::new(),
            },
            x: Along::Numbers((0..values.len()).map(|n| n as f64).collect()),
            y: Along::Names(vec!["one".to_owned()]),
            tiles: values.iter().copied().map(Tile::Value).collect(),
            hatched: "",
        }
    }

    fn labels(levels: &Levels) -> Vec<&str> {
        let labels = levels.bounds.iter().map(|(_, label)| label.as_str());
        labels.collect()
    }

    #[test]
    fn bounds_are_round_numbers_about_the_values() {
        let of = |values: &[f64], scale| Levels::of(&[&map(values, scale, None)]);
        let even = of(&[0.13, 0.61], Scale::Linear);
        assert_eq!(
            labels(&even),
            ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7"]
        );
        let decades = of(&[0.03, 18.0], Scale::Log);
        assert_eq!(
            labels(&decades),
            [
                "0.02", "0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10", "20"
            ]
        );
        let one = of(&[1.0, 8.0], Scale::Log);
        assert_eq!(labels(&one), ["1", "1.5", "2", "3", "5", "7", "10"]);
        let short = of(&[1.0, 1.2], Scale::Log);
        assert_eq!(labels(&short), ["1.00", "1.05", "1.10", "1.15", "1.20"]);
        let many = of(&[1e-9, 1e9], Scale::Log);
        assert_eq!(labels(&many).first(), Some(&"10⁻⁹"));
        assert!(many.count() <= MOST);
    }

    #[test]
    fn what_is_beyond_a_range_is_in_open_levels() {
        let values = [0.0, 0.3, 4.0, 900.0];
        let levels = Levels::of(&[&map(&values, Scale::Log, Some((0.1, 100.0)))]);
        let expected = ["0.1", "0.2", "0.5", "1", "2", "5", "10", "20", "50", "100"];
        assert_eq!(labels(&levels), expected);
        assert_eq!(values.map(|value| levels.at(value)), [0, 1, 4, 8]);
        assert_eq!(levels.name(0), "below 0.2");
        assert_eq!(levels.name(4), "2 to 5");
        assert_eq!(levels.name(8), "50 and more");
    }

    proptest! {
        #[test]
        fn every_value_is_between_the_bounds_of_its_level(
            values in proptest::collection::vec(any::<f64>(), 1..30),
            is_log in any::<bool>(),
        ) {
            let scale = if is_log { Scale::Log } else { Scale::Linear };
            let levels = Levels::of(&[&map(&values, scale, None)]);
            prop_assert!(levels.count() <= MOST, "{:?}", levels);
            prop_assert!(levels.bounds.windows(2).all(|pair| pair[0].0 < pair[1].0));
            for value in values.into_iter().filter(|value| value.is_finite()) {
                let level = levels.at(value);
                prop_assert!(level < levels.count());
                let (from, to) = (levels.bounds[level].0, levels.bounds[level + 1].0);
                let is_within = from <= value && value <= to;
                let is_below = level == 0 && levels.is_open_below && value < from;
                let is_above = level + 1 == levels.count() && levels.is_open_above && value > to;
                prop_assert!(is_within || is_below || is_above, "{} in {:?}", value, levels);
            }
        }
    }
}
