//! Figures as values, and the four forms in which they are published: SVG, PDF, PNG and CSV.
//!
//! A [`Chart`] says what is drawn, in panels with axes and series; it does not know what the numbers
//! mean. Its data are thinned once to what can be distinguished on paper, and all forms show
//! the same points. The same chart always gives the same bytes, on any machine.
//!
//! An SVG takes its colours from the page that contains it, if the page sets these variables:
//! `--chart-ink`, `--chart-paper`, one per [`Tone`] of the chart by its name, and for maps
//! `--chart-level-1`, the lowest, to `--chart-level-9`. A page that sets ink or paper has to set
//! both. On its own an SVG is dark on white.
#![forbid(unsafe_code)]

mod axes;
mod axis;
mod beyond;
mod canvas;
#[allow(clippy::module_inception)]
mod chart;
mod clip;
mod csv;
mod document;
mod drawing;
mod extent;
mod face;
mod field;
mod font;
mod grid;
mod guide;
mod hatch;
mod layout;
mod legend;
mod level;
mod look;
mod map;
mod mark;
mod outline;
mod page;
mod palette;
mod panel;
mod pdf;
mod png;
mod point;
mod scene;
mod span;
mod strip;
mod svg;
mod text;
mod thin;
mod tick;

pub use axis::{Axis, Scale};
pub use chart::{Chart, Guide, GuideAt, Mark, Panel, Series, Tone};
pub use drawing::Drawing;
pub use map::{Along, Map, Tile};
