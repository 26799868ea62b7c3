//! A chart laid out, of which its forms are made: the laying out takes longer than any of them.
//!
//! The forms are in `svg`, `pdf`, `png` and `csv`.

use crate::chart::Chart;
use crate::page;
use crate::point::Point;
use crate::scene::Scene;

/// A chart laid out: where everything is, and the points of it that are drawn.
#[derive(Debug)]
pub struct Drawing<'a> {
    pub(crate) chart: &'a Chart,
    pub(crate) scene: Scene,
    /// The points of each series of each panel.
    pub(crate) points: Vec<Vec<Vec<Point>>>,
}

impl Chart {
    /// Lays it out.
    #[must_use]
    pub fn draw(&self) -> Drawing<'_> {
        let (scene, panels) = page::scene(self);
        Drawing {
            chart: self,
            scene,
            points: panels,
        }
    }
}
