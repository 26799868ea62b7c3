//! One panel: what is computed before it has its place, and then its layers.

use std::collections::BTreeMap;

use crate::axes::{self, Axes};
use crate::beyond;
use crate::chart::{Mark, Panel};
use crate::extent;
use crate::field::Field;
use crate::grid;
use crate::guide::{self, Label};
use crate::layout::{Frame, HEADING_SIZE, LABEL_SIZE, LEADING};
use crate::legend::{self, Entry};
use crate::level::Levels;
use crate::look::Looks;
use crate::mark::Drawn;
use crate::palette::Colour;
use crate::point::Point;
use crate::scene::{Anchor, Layer, Shape, Text};
use crate::strip::Strip;
use crate::text;
use crate::thin;

/// Gap between the legend and the box.
const OVER_BOX: f64 = 5.0;

/// A panel that is ready to be drawn.
pub(crate) struct Prepared<'a> {
    pub(crate) panel: &'a Panel,
    /// `None` if there is nothing to draw.
    pub(crate) axes: Option<Axes>,
    /// The legend of its map.
    pub(crate) strip: Option<Strip<'a>>,
    /// Whether all maps of the chart share that legend.
    shares_strip: bool,
    /// The points of each series that are drawn.
    pub(crate) points: Vec<Vec<Point>>,
}

impl<'a> Prepared<'a> {
    /// Computes axes and points of a panel, for a chart with this number of columns and these levels.
    pub(crate) fn of(
        panel: &'a Panel,
        columns: usize,
        height: f64,
        levels: &'a BTreeMap<&str, Levels>,
    ) -> Self {
        Prepared {
            panel,
            axes: Axes::of(panel, height),
            strip: Self::strip(panel, levels),
            shares_strip: levels.len() == 1,
            points: points(panel, columns),
        }
    }

    /// The legend of the panel's map, if it has one; `levels` are those of the chart.
    fn strip(panel: &'a Panel, levels: &'a BTreeMap<&str, Levels>) -> Option<Strip<'a>> {
        let name = grid::map(panel)?.value.label.as_str();
        let levels = levels.get(name)?;
        Some(Strip { name, levels })
    }

    /// The shapes of its map.
    fn map(&self, axes: &Axes, frame: &Frame) -> Vec<Layer> {
        let (Some(map), Some(strip)) = (&self.panel.map, self.strip) else {
            return Vec::new();
        };
        let field = Field::of(map, strip.levels, frame, (&axes.x, &axes.y));
        let mut layers = field.layers();
        // Values under lines could not be read.
        if self.panel.series.is_empty() && self.panel.guides.is_empty() {
            layers.push(field.values());
        }
        layers
    }

    /// The legend of the map above its box, unless all maps of the chart share one.
    fn own_strip(&self) -> Option<Strip<'a>> {
        self.strip.filter(|_| !self.shares_strip)
    }

    /// The shapes of its series, the last on top.
    fn data(&self, axes: &Axes, looks: &Looks, frame: &Frame) -> Vec<Layer> {
        let bars = |mark: &Mark| matches!(mark, Mark::Bars(_));
        let many_bars = self.panel.series.iter().filter(|s| bars(&s.mark)).count() > 1;
        let series = || self.panel.series.iter().zip(&self.points);
        // A line that leaves the panel is seen to leave it.
        let leaves_unseen = |mark: Mark| matches!(mark, Mark::Dots | Mark::Bars(_));
        let beyond: Vec<(Colour, &[Point])> = series()
            .filter(|(series, _)| leaves_unseen(series.mark))
            .map(|(series, points)| (looks.series(series).colour, points.as_slice()))
            .collect();
        let beyond = beyond::layer(&beyond, frame, axes.y.scale);
        series()
            .map(|(series, points)| {
                let drawn = Drawn {
                    series,
                    points,
                    look: looks.series(series),
                    among_bars: many_bars,
                };
                self.over_map(drawn.layer(frame, &axes.x, &axes.y))
            })
            .chain([beyond])
            .filter(|layer| !layer.shapes.is_empty() || layer.name.is_some())
            .collect()
    }

    /// Adds a rim to a layer if it lies over a map.
    fn over_map(&self, layer: Layer) -> Layer {
        match self.strip {
            Some(_) => layer.rimmed(),
            None => layer,
        }
    }

    /// The guides' names that find room in the panel, and those that do not, for the legend.
    pub(crate) fn labels(&self, looks: &Looks, frame: &Frame) -> (Vec<Label>, Vec<Entry>) {
        let Some(axes) = &self.axes else {
            return (Vec::new(), Vec::new());
        };
        let data = self.data(axes, looks, frame);
        let (labels, beside) = guide::labels(&self.panel.guides, &data, frame, &axes.x, &axes.y);
        let beside = beside
            .into_iter()
            .map(|guide| Entry {
                name: guide.name.clone(),
                look: looks.guide(guide),
                band: false,
            })
            .collect();
        (labels, beside)
    }

    /// Everything in and around its box except the heading. `numbers` is the width of the numbers
    /// beside the boxes. Guides that a legend names are not named again.
    pub(crate) fn layers(
        &self,
        looks: &Looks,
        frame: &Frame,
        numbers: f64,
        in_legend: &[Entry],
    ) -> Vec<Layer> {
        let mut layers = Vec::new();
        match &self.axes {
            Some(axes) => {
                match self.strip {
                    Some(_) => layers.extend(self.map(axes, frame)),
                    None => layers.push(axes.grid(frame)),
                }
                let guides = guide::layer(&self.panel.guides, looks, frame, &axes.x, &axes.y);
                layers.push(self.over_map(guides));
                layers.extend(self.data(axes, looks, frame));
                let (labels, _) = self.labels(looks, frame);
                let unnamed = labels
                    .iter()
                    .filter(|label| in_legend.iter().all(|entry| entry.name != label.name()));
                layers.push(Layer {
                    name: None,
                    shapes: unnamed
                        .map(|label| label.shape(self.strip.is_some()))
                        .collect(),
                });
            }
            None => layers.push(self.nothing(frame)),
        }
        layers.push(axes::layer(self.panel, self.axes.as_ref(), frame, numbers));
        layers
    }

    fn nothing(&self, frame: &Frame) -> Layer {
        let lines = text::lines(&self.panel.empty, LABEL_SIZE, false, frame.width - 10.0);
        let step = LABEL_SIZE * LEADING;
        let first = frame.top + (frame.height - lines.len() as f64 * step) / 2.0 + LABEL_SIZE;
        let shapes = lines
            .iter()
            .enumerate()
            .map(|(row, line)| {
                let at = (frame.left + frame.width / 2.0, first + row as f64 * step);
                let text = Text::at(at, LABEL_SIZE, line);
                Shape::Text(text.anchor(Anchor::Middle).opacity(60))
            })
            .collect();
        Layer { name: None, shapes }
    }

    /// Height of heading and legends, down to the box.
    pub(crate) fn header_height(&self, legend: &[Entry], room: f64) -> f64 {
        let rows = heading(self.panel, room).len() as f64;
        let noted = self
            .axes
            .as_ref()
            .is_some_and(|axes| !axes.y_ticks.note.is_empty());
        rows * HEADING_SIZE * LEADING
            + legend::height(legend, room)
            + self.own_strip().map_or(0.0, |strip| strip.height(room))
            + OVER_BOX
            + if noted { axes::NOTE_ABOVE } else { 0.0 }
    }

    /// Heading and legends, from their top left corner.
    pub(crate) fn header(&self, legend: &[Entry], left: f64, top: f64, room: f64) -> Vec<Layer> {
        let mut shapes = Vec::new();
        let letter = letter(self.panel);
        let indent = text::width(&letter, HEADING_SIZE, true);
        let lines = heading(self.panel, room);
        let mut base = top + HEADING_SIZE * 0.85;
        if !letter.is_empty() {
            shapes.push(Shape::Text(
                Text::at((left, base), HEADING_SIZE, letter).bold(),
            ));
        }
        for line in &lines {
            shapes.push(Shape::Text(Text::at(
                (left + indent, base),
                HEADING_SIZE,
                line,
            )));
            base += HEADING_SIZE * LEADING;
        }
        let legend_top = top + lines.len() as f64 * HEADING_SIZE * LEADING;
        let strip_top = legend_top + legend::height(legend, room);
        let mut layers = vec![
            Layer { name: None, shapes },
            legend::draw(legend, (left, legend_top), room),
        ];
        let strip = self.own_strip();
        layers.extend(strip.map(|strip| strip.draw((left, strip_top), room)));
        layers
    }
}

/// The points of a panel that are drawn, series by series.
fn points(panel: &Panel, columns: usize) -> Vec<Vec<Point>> {
    let spans = extent::of(panel);
    panel
        .series
        .iter()
        .map(|series| spans.map_or_else(Vec::new, |(x, y)| thin::thin(series, &x, &y, columns)))
        .collect()
}

fn letter(panel: &Panel) -> String {
    if panel.letter.is_empty() {
        String::new()
    } else {
        format!("({})  ", panel.letter)
    }
}

/// The lines of the heading; one empty line if there is only a letter.
fn heading(panel: &Panel, room: f64) -> Vec<String> {
    let letter = letter(panel);
    let room = room - text::width(&letter, HEADING_SIZE, true);
    let mut lines = text::lines(&panel.title, HEADING_SIZE, false, room);
    if lines.is_empty() && !letter.is_empty() {
        lines.push(String::new());
    }
    lines
}
