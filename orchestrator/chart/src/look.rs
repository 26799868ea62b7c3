//! What distinguishes series: the colour of their tone, and a dash and a marker so that
//! print in grey can be read too.
//!
//! Series of one tone differ by their dashes. A name looks the same in all panels of a
//! chart; two names look alike only if no panel has both.

use std::collections::BTreeMap;

use crate::chart::{Chart, Guide, Mark, Series};
use crate::palette::Colour;
use crate::scene::{Marker, Stroke};

/// Lengths of stroke and gap, in points.
const DASHES: [&[f64]; 5] = [
    &[],
    &[4.5, 1.6],
    &[5.0, 1.6, 1.0, 1.6],
    &[1.2, 1.4],
    &[9.0, 2.2],
];

/// Dashes of guides, finer than those of series.
const GUIDE_DASHES: [&[f64]; 4] = [&[2.4, 1.6], &[0.8, 1.4], &[5.0, 1.4, 0.8, 1.4], &[7.0, 2.0]];

const MARKERS: [Marker; 4] = [
    Marker::Disc,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
];

/// How one series or one guide looks. Two that are equal look alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Look {
    pub(crate) colour: Colour,
    pub(crate) kind: Kind,
    /// Its index, from zero, among those that would look alike without it.
    pub(crate) turn: usize,
}

/// What a series or guide is drawn as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Line,
    Dots,
    Bars,
    Guide,
}

impl Look {
    /// The stroke of its line.
    pub(crate) fn stroke(&self, width: f64) -> Stroke {
        let dash = match self.kind {
            Kind::Guide => nth(&GUIDE_DASHES, self.turn, &[]),
            Kind::Line | Kind::Dots | Kind::Bars => {
                nth(&DASHES, self.first_turn() + self.turn, &[])
            }
        };
        Stroke {
            dash,
            opacity: if self.kind == Kind::Guide { 70 } else { 100 },
            ..Stroke::solid(self.colour, width)
        }
    }

    /// The marker of its dots.
    pub(crate) fn marker(&self) -> Marker {
        nth(&MARKERS, self.first_turn() + self.turn, Marker::Disc)
    }

    /// The index of its tone's first dash and marker.
    fn first_turn(&self) -> usize {
        match self.colour {
            Colour::Of(tone) => usize::from(tone.dash),
            Colour::Ink | Colour::Paper | Colour::Level(_) => 0,
        }
    }
}

/// The item at this index; after the last comes the first again.
fn nth<T: Copy>(list: &[T], turn: usize, otherwise: T) -> T {
    list.iter()
        .cycle()
        .nth(turn % list.len().max(1))
        .copied()
        .unwrap_or(otherwise)
}

/// The looks of everything in one chart.
#[derive(Debug, Clone, Default)]
pub(crate) struct Looks {
    /// Turns by the name of the colour, the kind, and the name of the series or guide.
    turns: BTreeMap<(&'static str, &'static str, String), usize>,
}

impl Looks {
    pub(crate) fn of(chart: &Chart) -> Looks {
        let mut looks = Looks::default();
        for panel in &chart.panels {
            let series = panel.series.iter().map(Look::first_of);
            let names = panel.series.iter().map(|series| series.name.as_str());
            looks.give(&series.zip(names).collect::<Vec<_>>());
            let guides = panel
                .guides
                .iter()
                .map(|guide| (GUIDE, guide.name.as_str()));
            looks.give(&guides.collect::<Vec<_>>());
        }
        looks
    }

    /// Gives each new name of a panel the first turn that no other of its colour in the panel has.
    fn give(&mut self, panel: &[(Look, &str)]) {
        for (look, name) in panel {
            if self.turns.contains_key(&key(*look, name)) {
                continue;
            }
            let taken: Vec<usize> = panel
                .iter()
                .filter(|(other, _)| other.colour == look.colour)
                .filter_map(|(other, name)| self.turns.get(&key(*other, name)).copied())
                .collect();
            let free = (0..=taken.len()).find(|turn| !taken.contains(turn));
            self.turns
                .insert(key(*look, name), free.unwrap_or_default());
        }
    }

    pub(crate) fn series(&self, series: &Series) -> Look {
        self.find(Look::first_of(series), &series.name)
    }

    pub(crate) fn guide(&self, guide: &Guide) -> Look {
        self.find(GUIDE, &guide.name)
    }

    fn find(&self, look: Look, name: &str) -> Look {
        let turn = self.turns.get(&key(look, name)).copied();
        Look {
            turn: turn.unwrap_or_default(),
            ..look
        }
    }
}

const GUIDE: Look = Look {
    colour: Colour::Ink,
    kind: Kind::Guide,
    turn: 0,
};

impl Look {
    fn first_of(series: &Series) -> Look {
        Look {
            colour: Colour::Of(series.tone),
            kind: match series.mark {
                Mark::Line | Mark::Steps => Kind::Line,
                Mark::Dots => Kind::Dots,
                Mark::Bars(_) | Mark::Area => Kind::Bars,
            },
            turn: 0,
        }
    }
}

fn key(look: Look, name: &str) -> (&'static str, &'static str, String) {
    let kind = match look.kind {
        Kind::Line => "line",
        Kind::Dots => "dots",
        Kind::Bars => "bars",
        Kind::Guide => "guide",
    };
    (look.colour.name(), kind, name.to_owned())
}
