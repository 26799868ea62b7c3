//! The axes of a panel: lines, ticks, numbers, names and a faint grid.

use crate::chart::Panel;
use crate::extent;
use crate::grid;
use crate::layout::{self, Frame, LABEL_SIZE, TICK, TICK_SIZE};
use crate::palette::Colour;
use crate::scene::{Anchor, Layer, Place, Shape, Stroke, Text};
use crate::span::Span;
use crate::text;
use crate::tick::Ticks;

/// Least gap between two numbers on the horizontal axis.
const APART: f64 = 6.0;

/// Distance from the horizontal axis to the baseline of its numbers.
const NUMBERS_BELOW: f64 = TICK + 1.5 + TICK_SIZE * 0.78;

/// Distance from the horizontal axis to the baseline of its name.
const NAME_BELOW: f64 = NUMBERS_BELOW + 3.0 + LABEL_SIZE * 0.85;

/// Height of everything below the box, if there are numbers.
pub(crate) const BELOW: f64 = NAME_BELOW + LABEL_SIZE * 0.25;

/// Width beside the box for the name of the vertical axis.
pub(crate) const NAME_BESIDE: f64 = LABEL_SIZE * 1.35;

/// Greatest length of names on an axis: beside the box and, if they are upright, below it.
const NAME_LENGTH: f64 = 62.0;

/// Least gap between two names side by side.
const NAMES_APART: f64 = 4.0;

/// Least font size of names side by side. Names that need a smaller one are upright instead.
const LEAST_SIDE_BY_SIDE: f64 = 6.0;

/// Height above the box for the note to the numbers of the vertical axis, such as a common factor.
pub(crate) const NOTE_ABOVE: f64 = TICK_SIZE + 2.0;

/// Both axes of a panel that has something to draw.
#[derive(Debug, Clone)]
pub(crate) struct Axes {
    pub(crate) x: Span,
    pub(crate) y: Span,
    /// The names along the horizontal axis, if it has any.
    x_names: Vec<String>,
    x_ticks: Ticks,
    /// How much further down they reach than a line of numbers does; 0 unless they are upright.
    x_depth: f64,
    pub(crate) y_ticks: Ticks,
}

/// The names, which are at 0, 1, 2 and so on. None of them if the axis does not reach all of these:
/// then numbers say more.
fn shown<'a>(names: &'a [String], span: &Span) -> &'a [String] {
    let is_inside = |at: usize| {
        let part = span.fraction(at as f64);
        part.is_some_and(|part| (0.0..=1.0).contains(&part))
    };
    if (0..names.len()).all(is_inside) {
        names
    } else {
        &[]
    }
}

impl Axes {
    /// Axes for a box of this height; `None` if there is nothing to draw. The horizontal axis has no
    /// ticks yet, since its length depends on the width of the vertical axis's numbers.
    pub(crate) fn of(panel: &Panel, height: f64) -> Option<Axes> {
        let (x, y) = extent::of(panel)?;
        let none: &[String] = &[];
        let map = panel.map.as_ref();
        let own = shown(&panel.x.names, &x);
        let names = map.map_or((own, none), |map| {
            (shown(map.x.names(), &x), shown(map.y.names(), &y))
        });
        Some(Axes {
            x,
            y,
            x_names: names.0.to_vec(),
            x_ticks: Ticks::default(),
            x_depth: 0.0,
            y_ticks: match names.1 {
                [] => Ticks::of(&y, (height / 22.0) as usize),
                names => Ticks::named(names, (NAME_LENGTH, height / names.len() as f64)),
            },
        })
    }

    /// Width of the numbers beside the box, with their ticks.
    pub(crate) fn numbers_beside(&self) -> f64 {
        widest(&self.y_ticks) + TICK + 2.0
    }

    /// Height of everything below the box.
    pub(crate) fn below(&self) -> f64 {
        BELOW + self.x_depth
    }

    /// Gives the horizontal axis as many ticks as fit on this width.
    pub(crate) fn fit(&mut self, width: f64) {
        if !self.x_names.is_empty() {
            self.fit_names(width / self.x_names.len() as f64);
            return;
        }
        let fits = |ticks: &Ticks| {
            let spread: Vec<(f64, f64)> = ticks
                .labelled
                .iter()
                .filter_map(|(value, label)| {
                    Some((self.x.fraction(*value)? * width, number(label) / 2.0))
                })
                .collect();
            spread
                .iter()
                .zip(spread.iter().skip(1))
                .all(|(a, b)| a.0 + a.1 + APART <= b.0 - b.1)
        };
        let most = (width / 30.0).max(2.0) as usize;
        self.x_ticks = (1..=most)
            .rev()
            .map(|count| Ticks::of(&self.x, count))
            .find(fits)
            .unwrap_or_else(|| Ticks::of(&self.x, 1));
    }

    /// Puts the names on the horizontal axis, each on this width.
    fn fit_names(&mut self, room: f64) {
        let level = Ticks::named(&self.x_names, (room - NAMES_APART, f64::INFINITY));
        let is_whole = |((_, label), name): (&(f64, String), &String)| label == name;
        let fits = level.labelled.iter().zip(&self.x_names).all(is_whole);
        if fits && level.size >= LEAST_SIDE_BY_SIDE {
            self.x_ticks = level;
        } else {
            self.x_ticks = Ticks::named(&self.x_names, (NAME_LENGTH, room));
            self.x_depth = (widest(&self.x_ticks) - TICK_SIZE * 0.7).max(0.1);
        }
    }

    /// The grid, which is under the data.
    pub(crate) fn grid(&self, frame: &Frame) -> Layer {
        let lines = self
            .y_ticks
            .labelled
            .iter()
            .filter_map(|(value, _)| {
                let level = self.y.fraction(*value)?;
                Some(frame.places(&[(0.0, level), (1.0, level)]))
            })
            .collect();
        let stroke = Stroke {
            opacity: 12,
            ..Stroke::solid(Colour::Ink, 0.5)
        };
        Layer {
            name: None,
            shapes: vec![Shape::Lines { lines, stroke }],
        }
    }

    /// Adds ticks and numbers.
    fn marks(&self, frame: &Frame, shapes: &mut Vec<Shape>) {
        let mut ticks: Vec<Vec<Place>> = Vec::new();
        for (value, label) in &self.x_ticks.labelled {
            let Some(at) = self.x.fraction(*value) else {
                continue;
            };
            let (x, y) = frame.place((at, 0.0));
            ticks.push(vec![(x, y), (x, y + TICK)]);
            let size = self.x_ticks.size;
            let number = if self.x_depth > 0.0 {
                let end = (x + size * 0.34, y + TICK + 1.5);
                Text::at(end, size, label).anchor(Anchor::End).upright()
            } else {
                Text::at((x, y + NUMBERS_BELOW), size, label).anchor(Anchor::Middle)
            };
            shapes.push(Shape::Text(number));
        }
        for (value, label) in &self.y_ticks.labelled {
            let Some(at) = self.y.fraction(*value) else {
                continue;
            };
            let (x, y) = frame.place((0.0, at));
            ticks.push(vec![(x - TICK, y), (x, y)]);
            let size = self.y_ticks.size;
            let base = (x - TICK - 2.0, y + size * 0.34);
            shapes.push(Shape::Text(Text::at(base, size, label).anchor(Anchor::End)));
        }
        let minor_x = self
            .x_ticks
            .minor
            .iter()
            .filter_map(|v| self.x.fraction(*v));
        ticks.extend(minor_x.map(|at| {
            let (x, y) = frame.place((at, 0.0));
            vec![(x, y), (x, y + TICK * 0.55)]
        }));
        let minor_y = self
            .y_ticks
            .minor
            .iter()
            .filter_map(|v| self.y.fraction(*v));
        ticks.extend(minor_y.map(|at| {
            let (x, y) = frame.place((0.0, at));
            vec![(x - TICK * 0.55, y), (x, y)]
        }));
        shapes.push(Shape::Lines {
            lines: ticks,
            stroke: Stroke::solid(Colour::Ink, 0.6),
        });
        let note = |at: Place, anchor: Anchor, note: &str| {
            Shape::Text(Text::at(at, TICK_SIZE, note).anchor(anchor))
        };
        if !self.x_ticks.note.is_empty() {
            let at = (frame.right(), frame.bottom() + NAME_BELOW + self.x_depth);
            shapes.push(note(at, Anchor::End, &self.x_ticks.note));
        }
        if !self.y_ticks.note.is_empty() {
            let at = (frame.left - TICK, frame.top - 4.0);
            shapes.push(note(at, Anchor::Start, &self.y_ticks.note));
        }
    }
}

/// Width of the widest label of the ticks.
fn widest(ticks: &Ticks) -> f64 {
    let labels = ticks.labelled.iter();
    let widths = labels.map(|(_, label)| text::width(label, ticks.size, false));
    widths.fold(0.0, f64::max)
}

fn number(label: &str) -> f64 {
    text::width(label, TICK_SIZE, false)
}

/// What is drawn over the data: the axes' lines and names, and numbers if there are any. `numbers` is
/// the width of the numbers beside the boxes.
pub(crate) fn layer(panel: &Panel, axes: Option<&Axes>, frame: &Frame, numbers: f64) -> Layer {
    let sides = [(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    // A map has lines on all four sides, to show that blank tiles at its edge belong to it.
    let shown = if grid::map(panel).is_some() { 5 } else { 3 };
    let mut shapes = vec![Shape::Lines {
        lines: vec![frame.places(&sides[..shown])],
        stroke: Stroke::solid(Colour::Ink, 0.6),
    }];
    if let Some(axes) = axes {
        axes.marks(frame, &mut shapes);
    }
    let note = axes.map_or("", |axes| axes.x_ticks.note.as_str());
    let x_room = frame.width - 2.0 * number(note);
    let (x_name, y_name) = (&panel.x.label, &panel.y.label);
    if !x_name.is_empty() {
        let middle = frame.left + frame.width / 2.0;
        let size = layout::fitting(x_name, LABEL_SIZE, x_room);
        let depth = axes.map_or(0.0, |axes| axes.x_depth);
        let base = frame.bottom() + NAME_BELOW + depth;
        let name = Text::at((middle, base), size, x_name);
        shapes.push(Shape::Text(name.anchor(Anchor::Middle)));
    }
    if !y_name.is_empty() {
        let middle = frame.top + frame.height / 2.0;
        let size = layout::fitting(y_name, LABEL_SIZE, frame.height + 10.0);
        let name = Text::at(
            (frame.left - numbers - NAME_BESIDE * 0.3, middle),
            size,
            y_name,
        );
        shapes.push(Shape::Text(name.anchor(Anchor::Middle).upright()));
    }
    Layer { name: None, shapes }
}
