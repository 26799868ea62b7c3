//! Figures as values, and the three forms in which they are published.
//!
//! A [`Chart`] says what is drawn, in panels with axes and series; it knows nothing of what the
//! numbers mean. How it is drawn is the plotting crate's work, which nothing outside this crate sees.
#![forbid(unsafe_code)]

#[allow(clippy::module_inception)]
mod chart;

pub use chart::{Axis, Chart, Guide, GuideAt, Mark, Panel, Role, Scale, Series};
