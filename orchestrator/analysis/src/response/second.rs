//! The second output over the ticks of a response, and the finding on it.

use std::ops::Range;

use endpoint::SecondRow;
use plan::system::Band;

use super::Aim;
use crate::asked::{Asked, Task};
use crate::verdict::{Course, Finding, judge, judge_free};

/// Accumulates the second output over the ticks of a response.
#[derive(Debug)]
pub struct SecondTrace {
    first_k: u64,
    end_k: u64,
    h_s: f64,
    r: Option<f64>,
    asked: Asked,
    y: Vec<f64>,
}

impl SecondTrace {
    /// Over the ticks with these numbers.
    pub(super) fn new(aim: &Aim, k: Range<u64>) -> Self {
        Self {
            first_k: k.start,
            end_k: k.end,
            h_s: aim.h_ns as f64 / 1e9,
            r: aim.second_r,
            asked: aim.second,
            y: Vec::new(),
        }
    }

    /// Adds the next tick.
    pub fn push(&mut self, row: &SecondRow) {
        if (self.first_k..self.end_k).contains(&row.k) {
            self.y.extend(row.y2);
        }
    }

    /// The verdict; `None` if there is no second output. Its band in units of y is about its reference; without
    /// one it is about where it comes to rest.
    #[must_use]
    pub fn finish(self) -> Option<Finding> {
        let first = *self.y.first()?;
        let banded = self
            .r
            .filter(|_| matches!(self.asked.band, Some(Band::Absolute(_))));
        let r = banded.unwrap_or_default();
        let error: Vec<f64> = self.y.iter().map(|y| y - r).collect();
        let course = Course {
            error: &error,
            y: &self.y,
            h_s: self.h_s,
            step: r - first,
            task: Task::Tracking,
            open: 0,
            overshoot_pct: None,
            effort: 0.0,
            silence: None,
        };
        Some(if banded.is_some() {
            judge(&course, &self.asked)
        } else {
            judge_free(&course, &self.asked)
        })
    }
}
