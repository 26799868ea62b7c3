//! A whole chart as a scene: title, legends, panels row by row, source.

use crate::axes::{Axes, BELOW, NAME_BESIDE};
use crate::chart::Chart;
use crate::layout::{self, EDGE, Frame, GAP, LEADING, ROW_GAP, SOURCE_SIZE, TITLE_SIZE};
use crate::legend::{self, Entry};
use crate::level;
use crate::look::Looks;
use crate::panel::Prepared;
use crate::point::Point;
use crate::scene::{Layer, Scene, Shape, Text};
use crate::text;

/// Lays out a chart; also the points of each series of each panel.
pub(crate) fn scene(chart: &Chart) -> (Scene, Vec<Vec<Vec<Point>>>) {
    let columns = columns(chart);
    let looks = Looks::of(chart);
    let levels = level::all(chart);
    let (width, height) = (layout::page_width(columns), layout::box_height(columns));
    let mut panels: Vec<Prepared> = chart
        .panels
        .iter()
        .map(|panel| Prepared::of(panel, columns, height, &levels))
        .collect();
    let boxes = Boxes::of(&panels, columns, height);
    let mut beside = Vec::new();
    for panel in &mut panels {
        if let Some(axes) = &mut panel.axes {
            axes.fit(boxes.unplaced.width);
        }
        beside.push(panel.labels(&looks, &boxes.unplaced).1);
    }
    let (shared, own) = legend::split(chart, &looks, &beside);
    let in_legend: Vec<Entry> = beside.into_iter().flatten().collect();

    let mut sheet = Sheet {
        layers: Vec::new(),
        top: EDGE,
        room: width - EDGE - layout::RIGHT_EDGE,
    };
    sheet.head(chart, &shared);
    let strip = panels.iter().find_map(|panel| panel.strip);
    if let Some(strip) = strip.filter(|_| levels.len() == 1) {
        sheet.layers.push(strip.draw((EDGE, sheet.top), sheet.room));
        sheet.top += strip.height(sheet.room) + 2.0;
    }
    let rows = panels.chunks(columns).zip(own.chunks(columns));
    for (index, (row, legends)) in rows.enumerate() {
        if index > 0 {
            sheet.top += ROW_GAP;
        }
        sheet.row(row, legends, &boxes, (&looks, &in_legend));
    }
    sheet.source(&chart.source);
    sheet.layers.retain(|layer| !layer.shapes.is_empty());
    let scene = Scene {
        width,
        height: (sheet.top + EDGE).ceil(),
        layers: sheet.layers,
    };
    (
        scene,
        panels.into_iter().map(|panel| panel.points).collect(),
    )
}

/// The panels' boxes, all of one size, so that panels can be compared.
struct Boxes {
    panel_width: f64,
    /// Width of the numbers beside the vertical axis that has the widest.
    numbers: f64,
    /// Distance from a panel's left edge to its box.
    gutter: f64,
    /// A box that has no place yet.
    unplaced: Frame,
}

impl Boxes {
    fn of(panels: &[Prepared<'_>], columns: usize, height: f64) -> Boxes {
        let numbers = panels
            .iter()
            .filter_map(|panel| panel.axes.as_ref())
            .map(Axes::numbers_beside)
            .fold(layout::TICK, f64::max);
        let named = panels.iter().any(|panel| !panel.panel.y.label.is_empty());
        let panel_width = layout::panel_width(columns);
        let gutter = numbers + if named { NAME_BESIDE } else { 0.0 };
        // Numbers that are too wide must not push a box off the page.
        let gutter = gutter.min(panel_width * 0.6);
        Boxes {
            panel_width,
            numbers,
            gutter,
            unplaced: Frame {
                left: 0.0,
                top: 0.0,
                width: panel_width - gutter,
                height,
            },
        }
    }
}

/// The page so far, and the place of the next element.
struct Sheet {
    layers: Vec<Layer>,
    top: f64,
    /// Width between the margins.
    room: f64,
}

impl Sheet {
    /// Adds the title and the legend of all panels.
    fn head(&mut self, chart: &Chart, shared: &[Entry]) {
        self.lines(&chart.title, TITLE_SIZE, true);
        if !chart.title.is_empty() {
            self.top += 3.0;
        }
        let legend = legend::draw(shared, (EDGE, self.top), self.room);
        self.layers.push(legend);
        if !shared.is_empty() {
            self.top += legend::height(shared, self.room) + 5.0;
        }
    }

    /// Adds panels side by side.
    fn row(
        &mut self,
        row: &[Prepared<'_>],
        legends: &[Vec<Entry>],
        boxes: &Boxes,
        (looks, in_legend): (&Looks, &[Entry]),
    ) {
        let header = row
            .iter()
            .zip(legends)
            .map(|(panel, legend)| panel.header_height(legend, boxes.panel_width))
            .fold(0.0, f64::max);
        for (column, (panel, legend)) in row.iter().zip(legends).enumerate() {
            let left = EDGE + column as f64 * (boxes.panel_width + GAP);
            let frame = Frame {
                left: left + boxes.gutter,
                top: self.top + header,
                ..boxes.unplaced
            };
            let headed = panel.header(legend, left, self.top, boxes.panel_width);
            self.layers.extend(headed);
            let drawn = panel.layers(looks, &frame, boxes.numbers, in_legend);
            self.layers.extend(drawn);
        }
        let below = row
            .iter()
            .filter_map(|panel| panel.axes.as_ref())
            .map(Axes::below)
            .fold(BELOW, f64::max);
        self.top += header + boxes.unplaced.height + below;
    }

    /// Adds where the chart came from, small and pale.
    fn source(&mut self, source: &str) {
        if source.is_empty() {
            return;
        }
        self.top += 6.0;
        self.lines(source, SOURCE_SIZE, false);
        for shape in self
            .layers
            .last_mut()
            .into_iter()
            .flat_map(|last| &mut last.shapes)
        {
            if let Shape::Text(text) = shape {
                text.opacity = 65;
            }
        }
    }

    /// Adds a text in as many lines as it needs.
    fn lines(&mut self, content: &str, size: f64, bold: bool) {
        let lines = text::lines(content, size, bold, self.room);
        let shapes = lines
            .iter()
            .enumerate()
            .map(|(row, line)| {
                let base = self.top + size * 0.85 + row as f64 * size * LEADING;
                let text = Text::at((EDGE, base), size, line);
                Shape::Text(if bold { text.bold() } else { text })
            })
            .collect();
        self.layers.push(Layer { name: None, shapes });
        self.top += lines.len() as f64 * size * LEADING;
    }
}

/// Number of panels side by side: as asked, but no more than there are, nor more than 6, so that they
/// can be read.
fn columns(chart: &Chart) -> usize {
    chart.columns.clamp(1, 6).min(chart.panels.len().max(1))
}
