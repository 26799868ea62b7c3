//! The grid: every combination of the axes' levels is a point.
//!
//! A point has a number and, for each axis, the place of its level; the last axis changes fastest.

use std::sync::Arc;

use crate::system::System;
use endpoint::{Outstanding, SampleTime};
use link::Profile;

use super::axis::Axis;
use super::machine::Machine;
use super::made::Made;
use super::point::{Between, Point};

/// One level of an axis, as written and drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Its text in rows, in the unit of its column.
    pub text: String,
    /// The same as a number, if it is one.
    pub number: Option<f64>,
}

/// An axis and its levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dimension<'a> {
    /// The axis.
    pub axis: Axis,
    /// Its levels, at least one.
    pub levels: &'a [Level],
}

/// At least one level, each with its value.
#[derive(Debug, Clone)]
pub(crate) struct Levels<T> {
    values: Vec<T>,
    levels: Vec<Level>,
}

impl<T: Clone> Levels<T> {
    /// The first level and the others.
    pub(crate) fn new(first: (T, Level), others: impl IntoIterator<Item = (T, Level)>) -> Self {
        let (values, levels) = std::iter::once(first).chain(others).unzip();
        Self { values, levels }
    }

    /// The value of the level at this place; of the first level if there is no such place.
    fn at(&self, place: usize) -> T {
        let value = self.values.get(place).unwrap_or(&self.values[0]);
        value.clone()
    }

    pub(crate) fn values(&self) -> &[T] {
        &self.values
    }

    pub(crate) fn levels(&self) -> &[Level] {
        &self.levels
    }
}

/// The link between the two ends: whole links, or links made of numbers.
#[derive(Debug, Clone)]
pub(crate) enum Links {
    Named(Levels<Arc<Profile>>),
    Made {
        rtt_ns: Levels<u64>,
        jitter_ns: Levels<u64>,
        loss: Levels<f64>,
        rate_bps: Levels<Option<u64>>,
        hold_ns: u64,
    },
}

impl Links {
    /// The worst link of those that are made of numbers: the longest round trip, the most jitter and loss, and the
    /// slowest rate.
    pub(crate) fn worst(&self) -> Option<Made> {
        let Links::Made {
            rtt_ns,
            jitter_ns,
            loss,
            rate_bps,
            hold_ns,
        } = self
        else {
            return None;
        };
        let most = |values: &[u64]| values.iter().copied().max().unwrap_or(0);
        Some(Made {
            rtt_ns: most(rtt_ns.values()),
            jitter_ns: most(jitter_ns.values()),
            loss: loss.values().iter().copied().fold(0.0, f64::max),
            rate_bps: rate_bps.values().iter().copied().flatten().min(),
            hold_ns: *hold_ns,
        })
    }
}

/// Everything that a sweep varies.
#[derive(Debug, Clone)]
pub struct Grid {
    pub(crate) links: Links,
    pub(crate) client: Levels<Machine>,
    pub(crate) system: Levels<Arc<System>>,
    pub(crate) h: Levels<SampleTime>,
    pub(crate) outstanding: Levels<Outstanding>,
    pub(crate) kp: Levels<Option<f64>>,
    pub(crate) ki: Levels<Option<f64>>,
}

impl Grid {
    /// The axes in order, including those with one level.
    #[must_use]
    pub fn dimensions(&self) -> Vec<Dimension<'_>> {
        let mut all = Vec::with_capacity(Axis::ALL.len());
        let mut add = |axis, levels| all.push(Dimension { axis, levels });
        match &self.links {
            Links::Named(topology) => add(Axis::Topology, topology.levels()),
            Links::Made {
                rtt_ns,
                jitter_ns,
                loss,
                rate_bps,
                hold_ns: _,
            } => {
                add(Axis::Rtt, rtt_ns.levels());
                add(Axis::Jitter, jitter_ns.levels());
                add(Axis::Loss, loss.levels());
                add(Axis::Rate, rate_bps.levels());
            }
        }
        add(Axis::Client, self.client.levels());
        add(Axis::System, self.system.levels());
        add(Axis::H, self.h.levels());
        add(Axis::Outstanding, self.outstanding.levels());
        add(Axis::Kp, self.kp.levels());
        add(Axis::Ki, self.ki.levels());
        all
    }

    /// Whether any client is other than ideal, so that programs take time.
    #[must_use]
    pub fn takes_time(&self) -> bool {
        let mut machines = self.client.values().iter();
        machines.any(|machine| *machine != Machine::Ideal)
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        let sizes = self.dimensions().into_iter().map(|d| d.levels.len());
        sizes.fold(1, usize::saturating_mul)
    }

    /// The place on each axis of the point with this number.
    #[must_use]
    pub fn place(&self, number: usize) -> Vec<usize> {
        let mut rest = number;
        let dimensions = self.dimensions();
        let mut place: Vec<usize> = dimensions
            .iter()
            .rev()
            .map(|dimension| {
                let at = rest % dimension.levels.len();
                rest /= dimension.levels.len();
                at
            })
            .collect();
        place.reverse();
        place
    }

    /// The number of the point at this place.
    #[must_use]
    pub fn number(&self, place: &[usize]) -> usize {
        let dimensions = self.dimensions();
        let at = dimensions.iter().zip(place);
        at.fold(0, |number, (dimension, at)| {
            number * dimension.levels.len() + at
        })
    }

    /// The point with this number.
    #[must_use]
    pub fn point(&self, number: usize) -> Point {
        let place = self.place(number);
        let mut at = place.iter().copied();
        // Every axis has a place.
        let mut next = || at.next().unwrap_or(0);
        let between = match &self.links {
            Links::Named(topology) => Between::Named(topology.at(next())),
            Links::Made {
                rtt_ns,
                jitter_ns,
                loss,
                rate_bps,
                hold_ns,
            } => Between::Made(Made {
                rtt_ns: rtt_ns.at(next()),
                jitter_ns: jitter_ns.at(next()),
                loss: loss.at(next()),
                rate_bps: rate_bps.at(next()),
                hold_ns: *hold_ns,
            }),
        };
        Point {
            between,
            client: self.client.at(next()),
            system: self.system.at(next()),
            h: self.h.at(next()),
            outstanding: self.outstanding.at(next()),
            kp: self.kp.at(next()),
            ki: self.ki.at(next()),
        }
    }
}
