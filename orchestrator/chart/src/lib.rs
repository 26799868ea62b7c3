//! Figures as values, and the three forms in which they are published: SVG, PDF and CSV.
//!
//! A [`Chart`] says what is drawn, in panels with axes and series; it knows nothing of what the
//! numbers mean. Its data are thinned once to what can be distinguished on paper; all three forms
//! show the same points, and the same chart is the same bytes wherever and whenever it is drawn.
//!
//! An SVG's colours are those of the page that it stands in, if the page sets them:
//! `--chart-ink`, `--chart-paper`, one for each of the chart's [`Tone`]s by its name, and for maps
//! `--chart-level-1`, the lowest, to `--chart-level-9`. A page that sets one of ink and paper sets both.
//! By itself an SVG is dark on white.
#![forbid(unsafe_code)]

mod axes;
mod axis;
#[allow(clippy::module_inception)]
mod chart;
mod clip;
mod csv;
mod document;
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
mod page;
mod palette;
mod panel;
mod pdf;
mod scene;
mod span;
mod strip;
mod svg;
mod text;
mod thin;
mod tick;

pub use axis::{Axis, Scale};
pub use chart::{Chart, Guide, GuideAt, Mark, Panel, Series, Tone};
pub use map::{Along, Map, Tile};
