//! The axes of a panel: lines, ticks, numbers, names and a faint grid.

use crate::chart::Panel;
use crate::layout::{self, Frame, LABEL_SIZE, TICK, TICK_SIZE};
use crate::palette::Colour;
use crate::scene::{Anchor, Layer, Place, Shape, Stroke, Text};
use crate::span::Span;
use crate::text;
use crate::tick::Ticks;

/// Between two numbers on the horizontal axis, at least.
const APART: f64 = 6.0;

/// From the horizontal axis to the base line of its numbers.
const NUMBERS_BELOW: f64 = TICK + 1.5 + TICK_SIZE * 0.78;

/// From the horizontal axis to the base line of its name.
const NAME_BELOW: f64 = NUMBERS_BELOW + 3.0 + LABEL_SIZE * 0.85;

/// How far everything below the box reaches.
pub(crate) const BELOW: f64 = NAME_BELOW + LABEL_SIZE * 0.25;

/// Beside the box, for the name of the vertical axis.
pub(crate) const NAME_BESIDE: f64 = LABEL_SIZE * 1.35;

/// Over the box, for what all numbers of the vertical axis are to be multiplied by.
pub(crate) const NOTE_ABOVE: f64 = TICK_SIZE + 2.0;

/// Both axes of a panel that has something to draw.
#[derive(Debug, Clone)]
pub(crate) struct Axes {
    pub(crate) x: Span,
    pub(crate) y: Span,
    x_ticks: Ticks,
    pub(crate) y_ticks: Ticks,
}

impl Axes {
    /// Axes for a box of this height; the horizontal one has no ticks yet, since its length follows
    /// from the width of the vertical one's numbers.
    pub(crate) fn of(panel: &Panel, height: f64) -> Option<Axes> {
        let (x, y) = Span::of(panel)?;
        Some(Axes {
            x,
            y,
            x_ticks: Ticks::default(),
            y_ticks: Ticks::of(&y, (height / 22.0) as usize),
        })
    }

    /// How wide the numbers beside the box are.
    pub(crate) fn numbers_beside(&self) -> f64 {
        let widths = self.y_ticks.labelled.iter().map(|(_, label)| number(label));
        widths.fold(0.0, f64::max) + TICK + 2.0
    }

    /// Gives the horizontal axis as many ticks as have room on this length.
    pub(crate) fn fit(&mut self, width: f64) {
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

    /// What is under the data.
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

    /// Ticks and numbers.
    fn marks(&self, frame: &Frame, shapes: &mut Vec<Shape>) {
        let mut ticks: Vec<Vec<Place>> = Vec::new();
        for (value, label) in &self.x_ticks.labelled {
            let Some(at) = self.x.fraction(*value) else {
                continue;
            };
            let (x, y) = frame.place((at, 0.0));
            ticks.push(vec![(x, y), (x, y + TICK)]);
            let number = Text::at((x, y + NUMBERS_BELOW), TICK_SIZE, label);
            shapes.push(Shape::Text(number.anchor(Anchor::Middle)));
        }
        for (value, label) in &self.y_ticks.labelled {
            let Some(at) = self.y.fraction(*value) else {
                continue;
            };
            let (x, y) = frame.place((0.0, at));
            ticks.push(vec![(x - TICK, y), (x, y)]);
            let base = (x - TICK - 2.0, y + TICK_SIZE * 0.34);
            shapes.push(Shape::Text(
                Text::at(base, TICK_SIZE, label).anchor(Anchor::End),
            ));
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
            let at = (frame.right(), frame.bottom() + NAME_BELOW);
            shapes.push(note(at, Anchor::End, &self.x_ticks.note));
        }
        if !self.y_ticks.note.is_empty() {
            let at = (frame.left - TICK, frame.top - 4.0);
            shapes.push(note(at, Anchor::Start, &self.y_ticks.note));
        }
    }
}

fn number(label: &str) -> f64 {
    text::width(label, TICK_SIZE, false)
}

/// What is over the data: the axes' lines and names, and if there are any, numbers. `numbers` is
/// how wide the numbers beside the boxes are.
pub(crate) fn layer(panel: &Panel, axes: Option<&Axes>, frame: &Frame, numbers: f64) -> Layer {
    let mut shapes = vec![Shape::Lines {
        lines: vec![frame.places(&[(0.0, 1.0), (0.0, 0.0), (1.0, 0.0)])],
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
        let name = Text::at((middle, frame.bottom() + NAME_BELOW), size, x_name);
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
