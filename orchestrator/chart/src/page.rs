//! A whole chart as a scene: title, legends, panels row by row, source.

use crate::axes::{Axes, BELOW, NAME_BESIDE};
use crate::chart::Chart;
use crate::layout::{self, EDGE, Frame, GAP, LEADING, ROW_GAP, SOURCE_SIZE, TITLE_SIZE};
use crate::legend;
use crate::level;
use crate::look::Looks;
use crate::panel::Prepared;
use crate::scene::{Layer, Scene, Shape, Text};
use crate::text;

/// Lays a chart out.
pub(crate) fn scene(chart: &Chart) -> Scene {
    let columns = columns(chart);
    let looks = Looks::of(chart);
    let levels = level::all(chart);
    let (width, height) = (layout::page_width(columns), layout::box_height(columns));
    let room = width - EDGE - layout::RIGHT_EDGE;

    let mut panels: Vec<Prepared> = chart
        .panels
        .iter()
        .map(|panel| Prepared::of(panel, columns, height, &levels))
        .collect();
    // All boxes are of one size, so that panels can be compared.
    let numbers = panels
        .iter()
        .filter_map(|panel| panel.axes.as_ref())
        .map(Axes::numbers_beside)
        .fold(layout::TICK, f64::max);
    let named = panels.iter().any(|panel| !panel.panel.y.label.is_empty());
    let panel_width = layout::panel_width(columns);
    let gutter = numbers + if named { NAME_BESIDE } else { 0.0 };
    // Numbers too long to stand beside a box may not push it off the page.
    let gutter = gutter.min(panel_width * 0.6);
    let box_width = panel_width - gutter;
    let mut beside = Vec::new();
    let unplaced = Frame {
        left: 0.0,
        top: 0.0,
        width: box_width,
        height,
    };
    for panel in &mut panels {
        if let Some(axes) = &mut panel.axes {
            axes.fit(box_width);
        }
        beside.push(panel.labels(&looks, &unplaced).1);
    }
    let (shared, own) = legend::split(chart, &looks, &beside);

    let in_legend: Vec<_> = beside.into_iter().flatten().collect();

    let mut layers = Vec::new();
    let mut top = EDGE;
    top += lines(
        &chart.title,
        TITLE_SIZE,
        true,
        (EDGE, top),
        room,
        &mut layers,
    );
    if !chart.title.is_empty() {
        top += 3.0;
    }
    layers.push(legend::draw(&shared, (EDGE, top), room));
    if !shared.is_empty() {
        top += legend::height(&shared, room) + 5.0;
    }
    let strip = panels.iter().find_map(|panel| panel.strip);
    if let Some(strip) = strip.filter(|_| levels.len() == 1) {
        layers.push(strip.draw((EDGE, top), room));
        top += strip.height(room) + 2.0;
    }

    let rows = panels.chunks(columns).zip(own.chunks(columns));
    for (index, (row, legends)) in rows.enumerate() {
        if index > 0 {
            top += ROW_GAP;
        }
        let header = row
            .iter()
            .zip(legends)
            .map(|(panel, legend)| panel.header_height(legend, panel_width))
            .fold(0.0, f64::max);
        for (column, (panel, legend)) in row.iter().zip(legends).enumerate() {
            let left = EDGE + column as f64 * (panel_width + GAP);
            let frame = Frame {
                left: left + gutter,
                top: top + header,
                width: box_width,
                height,
            };
            layers.extend(panel.header(legend, left, top, panel_width));
            layers.extend(panel.layers(&looks, &frame, numbers, &in_legend));
        }
        let below = row
            .iter()
            .filter_map(|panel| panel.axes.as_ref())
            .map(Axes::below)
            .fold(BELOW, f64::max);
        top += header + height + below;
    }
    if !chart.source.is_empty() {
        top += 6.0;
        let first = layers.len();
        top += lines(
            &chart.source,
            SOURCE_SIZE,
            false,
            (EDGE, top),
            room,
            &mut layers,
        );
        for shape in layers
            .iter_mut()
            .skip(first)
            .flat_map(|layer| &mut layer.shapes)
        {
            if let Shape::Text(text) = shape {
                text.opacity = 65;
            }
        }
    }
    layers.retain(|layer| !layer.shapes.is_empty());
    Scene {
        width,
        height: (top + EDGE).ceil(),
        layers,
    }
}

/// Adds a text in as many lines as it needs, from its top left corner. Returns its height.
fn lines(
    content: &str,
    size: f64,
    bold: bool,
    at: (f64, f64),
    room: f64,
    layers: &mut Vec<Layer>,
) -> f64 {
    let lines = text::lines(content, size, bold, room);
    let shapes = lines
        .iter()
        .enumerate()
        .map(|(row, line)| {
            let base = at.1 + size * 0.85 + row as f64 * size * LEADING;
            let text = Text::at((at.0, base), size, line);
            Shape::Text(if bold { text.bold() } else { text })
        })
        .collect();
    layers.push(Layer { name: None, shapes });
    lines.len() as f64 * size * LEADING
}

/// How many panels stand side by side: as asked, but no more than there are, or than can be read.
pub(crate) fn columns(chart: &Chart) -> usize {
    chart.columns.clamp(1, 6).min(chart.panels.len().max(1))
}
