//! Turns the points of a series into shapes: lines, steps, dots and bars, and their intervals.

use crate::chart::{Mark, Series};
use crate::clip;
use crate::layout::Frame;
use crate::look::Look;
use crate::point::Point;
use crate::scene::{Layer, Place, Shape, Stroke};
use crate::span::Span;

/// Lines with more points than this are drawn finer.
const DENSE: usize = 600;

/// Half the length of the bar across the end of a whisker.
const CAP: f64 = 1.6;

/// Opacity of the band about a line, and of a part of a stack, %.
const BAND: u8 = 20;
const FILLED: u8 = 85;

/// A series that is ready to be drawn.
pub(crate) struct Drawn<'a> {
    pub(crate) series: &'a Series,
    pub(crate) points: &'a [Point],
    pub(crate) look: Look,
    /// Whether the panel has other bars, which must show through.
    pub(crate) among_bars: bool,
}

impl Drawn<'_> {
    /// Its shapes in this box, with these axes.
    pub(crate) fn layer(&self, frame: &Frame, x: &Span, y: &Span) -> Layer {
        let mut shapes = Vec::new();
        match self.series.mark {
            Mark::Line => {
                self.band(frame, y, false, BAND, &mut shapes);
                self.lines(frame, false, &mut shapes);
            }
            Mark::Steps => {
                self.band(frame, y, true, BAND, &mut shapes);
                self.lines(frame, true, &mut shapes);
            }
            Mark::Area => self.band(frame, y, false, FILLED, &mut shapes),
            Mark::Dots => {
                self.whiskers(frame, y, &mut shapes);
                self.dots(frame, &mut shapes);
            }
            Mark::Bars(width) => {
                self.bars(frame, x, y, width, &mut shapes);
                self.whiskers(frame, y, &mut shapes);
            }
        }
        let name = (!self.series.name.is_empty()).then(|| self.series.name.clone());
        Layer { name, shapes }
    }

    /// The pieces of the series between gaps.
    fn pieces(&self) -> impl Iterator<Item = &[Point]> {
        self.points.chunk_by(|_, next| !next.after_gap)
    }

    fn lines(&self, frame: &Frame, steps: bool, shapes: &mut Vec<Shape>) {
        let mut lines = Vec::new();
        let mut lone = Vec::new();
        for piece in self.pieces() {
            match piece {
                [point] => lone.push(point.at),
                _ => {
                    let places: Vec<Place> = piece.iter().map(|point| point.at).collect();
                    let path = if steps { corners(&places) } else { places };
                    lines.extend(clip::line(&path).iter().map(|part| frame.places(part)));
                }
            }
        }
        let width = if self.points.len() > DENSE { 0.8 } else { 1.2 };
        if !lines.is_empty() {
            shapes.push(Shape::Lines {
                lines,
                stroke: self.look.stroke(width),
            });
        }
        // A line of one point would be invisible: it gets a marker.
        self.markers(frame, &lone, 2.4, shapes);
    }

    fn band(&self, frame: &Frame, y: &Span, steps: bool, opacity: u8, shapes: &mut Vec<Shape>) {
        let mut areas = Vec::new();
        for piece in self.pieces() {
            for part in piece.chunk_by(|a, b| a.band.is_some() == b.band.is_some()) {
                let edge = |choose: fn((f64, f64)) -> f64| -> Vec<Place> {
                    let edge: Vec<Place> = part
                        .iter()
                        .filter_map(|point| Some((point.at.0, y.fraction(choose(point.band?))?)))
                        .collect();
                    if steps { corners(&edge) } else { edge }
                };
                let mut outline = edge(|band| band.1);
                outline.extend(edge(|band| band.0).iter().rev());
                let inside = clip::area(&outline);
                if inside.len() > 2 {
                    areas.push(frame.places(&inside));
                }
            }
        }
        if !areas.is_empty() {
            shapes.push(Shape::Areas {
                areas,
                colour: self.look.colour,
                opacity,
            });
        }
    }

    fn whiskers(&self, frame: &Frame, y: &Span, shapes: &mut Vec<Shape>) {
        let cap = CAP / frame.width;
        let lines: Vec<Vec<Place>> = self
            .points
            .iter()
            .filter_map(|point| {
                let (low, high) = point.band?;
                Some((point.at.0, y.fraction(low)?, y.fraction(high)?))
            })
            .flat_map(|(x, low, high)| {
                [
                    [(x, low), (x, high)],
                    [(x - cap, low), (x + cap, low)],
                    [(x - cap, high), (x + cap, high)],
                ]
            })
            .flat_map(|line| clip::line(&line))
            .map(|line| frame.places(&line))
            .collect();
        if !lines.is_empty() {
            shapes.push(Shape::Lines {
                lines,
                stroke: Stroke {
                    dash: &[],
                    ..self.look.stroke(0.7)
                },
            });
        }
    }

    fn dots(&self, frame: &Frame, shapes: &mut Vec<Shape>) {
        let places: Vec<Place> = self.points.iter().map(|point| point.at).collect();
        let size = match places.len() {
            0..=60 => 4.0,
            61..=400 => 2.6,
            401..=1500 => 1.6,
            _ => 1.1,
        };
        self.markers(frame, &places, size, shapes);
    }

    fn markers(&self, frame: &Frame, places: &[Place], size: f64, shapes: &mut Vec<Shape>) {
        let inside = 0.0..=1.0;
        let places: Vec<Place> = places
            .iter()
            .filter(|at| inside.contains(&at.0) && inside.contains(&at.1))
            .map(|at| frame.place(*at))
            .collect();
        if places.is_empty() {
            return;
        }
        shapes.push(Shape::Markers {
            // The shape of a small dot cannot be seen, and a disc takes less room in the file.
            shape: if size < 2.0 {
                crate::scene::Marker::Disc
            } else {
                self.look.marker()
            },
            places,
            size,
            colour: self.look.colour,
            opacity: if size < 2.0 { 70 } else { 90 },
        });
    }

    fn bars(&self, frame: &Frame, x: &Span, y: &Span, width: f64, shapes: &mut Vec<Shape>) {
        let foot = y.fraction(y.floor()).unwrap_or_default();
        let areas: Vec<Vec<Place>> = self
            .points
            .iter()
            .filter_map(|point| {
                let half = (width / 2.0).abs();
                // On a logarithmic axis a bar may start at or below zero.
                let left = x.fraction(point.value.0 - half).unwrap_or_default();
                let right = x.fraction(point.value.0 + half)?;
                let top = point.at.1;
                let bar = clip::area(&[(left, foot), (right, foot), (right, top), (left, top)]);
                (bar.len() > 2 && top != foot).then(|| frame.places(&bar))
            })
            .collect();
        if !areas.is_empty() {
            shapes.push(Shape::Areas {
                areas,
                colour: self.look.colour,
                opacity: if self.among_bars { 50 } else { 80 },
            });
        }
    }
}

/// A line of steps through these places: each value holds until the next place.
fn corners(places: &[Place]) -> Vec<Place> {
    let mut corners = Vec::with_capacity(places.len() * 2);
    for (from, to) in places.iter().zip(places.iter().skip(1)) {
        corners.push(*from);
        corners.push((to.0, from.1));
    }
    corners.extend(places.last());
    corners
}
