//! A loop along all frequencies, so densely that it is nearly straight between two neighbours, with every place
//! at which its gain passes 1.
//!
//! The first points are spread evenly on a log scale and crowd around poles close to the axis. From there the
//! middle of each gap is computed: where magnitude, phase or the angle of 1 + L's numerator bend, the gap is
//! divided. A change of sign is bisected to the last bit, an extremum near 1 is searched for one.

use nalgebra::Complex;
use thiserror::Error;

use crate::open_loop::{OpenLoop, Point};

/// A frequency with the loop there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub(crate) rad_s: f64,
    pub(crate) at: Point,
}

/// The loop along all frequencies.
#[derive(Debug, Clone)]
pub(crate) struct Scan<'a> {
    pub(crate) of: &'a OpenLoop,
    /// In ascending order.
    pub(crate) nodes: Vec<Node>,
    /// Each place where the gain is 1, with the number of its locus.
    pub(crate) crossovers: Vec<(Node, usize)>,
}

/// What is asked cannot be known to the digits that would be printed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum Unsure {
    /// Two computations that round differently disagree.
    #[error(
        "two computations of the loop that round differently differ by {off:.0e} of it at {rad_s:.3e} rad/s; \
         describe the plant by smaller parts, or with states of like size"
    )]
    Rounding {
        /// Where.
        rad_s: f64,
        /// By what part.
        off: f64,
    },
    /// The loop turns too often.
    #[error(
        "the loop turns too often to follow it between {from_rad_s:.3e} rad/s and {to_rad_s:.3e}"
    )]
    Turns {
        /// From this frequency on.
        from_rad_s: f64,
        /// To this one.
        to_rad_s: f64,
    },
    /// A pole of the closed loop lies on the border between stable and unstable, as far as can be told.
    #[error("a pole of the closed loop lies on the border of stability, as far as can be told")]
    Border,
}

const POINTS_PER_DECADE: f64 = 40.0;
/// The scan extends beyond the outermost corners by this factor; there the magnitude is a power law.
const BEYOND_CORNERS: f64 = 1e3;
/// Most decades by which the scan may grow to find an outer crossover: a gain of 10^30 has one there.
const MOST_DECADES: usize = 30;
/// Around a corner the points come as close as its damping says, at most to this power of ten of its frequency.
const CLOSEST_DECADES: f64 = 9.0;
/// Most frequencies; a second's work.
const MOST_POINTS: usize = 200_000;
/// Most of them between two neighbours of the first ones: where more are needed, rounding bends the response.
const MOST_BETWEEN: usize = 5_000;
/// A gap this narrow is not divided.
const NARROWEST: f64 = 1e-12;

impl<'a> Scan<'a> {
    /// Along all frequencies, of a continuous loop to `reach_rad_s` at least.
    pub(crate) fn new(of: &'a OpenLoop, reach_rad_s: f64) -> Result<Self, Unsure> {
        let mut nodes: Vec<Node> = Vec::new();
        for rad_s in first_points(of, reach_rad_s)? {
            let Some(at) = of.at(rad_s) else {
                continue;
            };
            let mut next = Node { rad_s, at };
            if let Some(last) = nodes.last().copied() {
                next = divide(of, last, matched(next, last.at), &mut nodes)?;
            }
            nodes.push(next);
        }
        let mut scan = Self {
            of,
            nodes,
            crossovers: Vec::new(),
        };
        scan.find_extrema();
        scan.find_crossovers();
        Ok(scan)
    }

    /// The loop at a frequency next to a node, its loci in the same order.
    pub(crate) fn beside(&self, node: Node, rad_s: f64) -> Option<Node> {
        let at = self.of.at(rad_s)?;
        Some(matched(Node { rad_s, at }, node.at))
    }

    /// Adds the top or bottom of a gain that comes close to 1 between nodes.
    fn find_extrema(&mut self) {
        const CLOSE: f64 = 0.2;
        let mut more = Vec::new();
        for (at, trio) in self.nodes.windows(3).enumerate() {
            let Some([a, b, c]) = trio.first_chunk::<3>() else {
                continue;
            };
            for locus in 0..2 {
                let [x, y, z] = [a, b, c].map(|node| level(node.at.loci[locus]));
                let is_top = y >= x && y >= z && y < 0.0;
                let is_bottom = y <= x && y <= z && y > 0.0;
                if (is_top || is_bottom) && y.abs() < CLOSE {
                    let sign = if is_top { 1.0 } else { -1.0 };
                    let found = self.extremum((*a, *c), |node| sign * level(node.at.loci[locus]));
                    more.extend(found.map(|node| (at + 1, node)));
                }
            }
        }
        for (_, node) in more {
            let place = self.nodes.partition_point(|other| other.rad_s < node.rad_s);
            self.nodes.insert(place, node);
        }
    }

    /// Where `of` is largest between two nodes, by golden section.
    pub(crate) fn extremum(
        &self,
        (from, to): (Node, Node),
        of: impl Fn(&Node) -> f64,
    ) -> Option<Node> {
        const ROUNDS: usize = 60;
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (mut low, mut high) = (from.rad_s, to.rad_s);
        let at = |rad_s: f64| self.beside(from, rad_s);
        let mut left = at(high - GOLDEN * (high - low))?;
        let mut right = at(low + GOLDEN * (high - low))?;
        for _ in 0..ROUNDS {
            if of(&left) > of(&right) {
                high = right.rad_s;
                right = left;
                left = at(high - GOLDEN * (high - low))?;
            } else {
                low = left.rad_s;
                left = right;
                right = at(low + GOLDEN * (high - low))?;
            }
        }
        Some(left)
    }

    fn find_crossovers(&mut self) {
        let mut all = Vec::with_capacity(self.nodes.len());
        for pair in self.nodes.windows(2) {
            let Some([a, b]) = pair.first_chunk::<2>() else {
                continue;
            };
            all.push(*a);
            let mut here = Vec::new();
            for locus in 0..2 {
                let is_above = |node: &Node| level(node.at.loci[locus]) > 0.0;
                if is_above(a) != is_above(b) {
                    let found = self.bisect(*a, *b, |node| is_above(node) == is_above(a));
                    here.extend(found.map(|node| (node, locus)));
                }
            }
            here.sort_by(|p, q| p.0.rad_s.total_cmp(&q.0.rad_s));
            all.extend(here.iter().map(|(node, _)| *node));
            self.crossovers.extend(here);
        }
        all.extend(self.nodes.last());
        self.nodes = all;
    }

    /// The last frequency between two nodes at which `is_before`, which holds at the first.
    pub(crate) fn bisect(
        &self,
        from: Node,
        to: Node,
        is_before: impl Fn(&Node) -> bool,
    ) -> Option<Node> {
        let (mut low, mut high) = (from.rad_s, to.rad_s);
        let mut last = from;
        loop {
            let middle = low + (high - low) / 2.0;
            if middle <= low || middle >= high {
                return Some(last);
            }
            let node = self.beside(last, middle)?;
            if is_before(&node) {
                low = middle;
                last = node;
            } else {
                high = middle;
            }
        }
    }
}

/// ln of the magnitude.
pub(crate) fn level(x: Complex<f64>) -> f64 {
    x.norm().ln()
}

/// A node whose loci are in the order of its neighbour's.
fn matched(mut node: Node, neighbour: Point) -> Node {
    let [a, b] = neighbour.loci;
    let [x, y] = node.at.loci;
    let zero = Complex::new(0.0, 0.0);
    if b == zero && y == zero {
        return node;
    }
    let apart =
        |p: Complex<f64>, q: Complex<f64>| (p - q).norm() / (p.norm() + q.norm()).max(1e-300);
    if apart(x, b) + apart(y, a) < apart(x, a) + apart(y, b) {
        node.at.loci = [y, x];
    }
    node
}

/// The frequencies to begin with.
fn first_points(of: &OpenLoop, reach_rad_s: f64) -> Result<Vec<f64>, Unsure> {
    // A pole at rest is found beside it, by its rounding, which is no corner.
    const ROUNDING: f64 = 1e-12;
    let mut corners = of.corners();
    corners.retain(|corner| corner.rad_s.is_finite() && corner.rad_s > 0.0);
    let fastest = corners.iter().fold(0.0, |most: f64, c| most.max(c.rad_s));
    corners.retain(|corner| corner.rad_s > ROUNDING * fastest);
    let lowest = corners
        .iter()
        .map(|corner| corner.rad_s)
        .fold(f64::INFINITY, f64::min);
    let highest = corners
        .iter()
        .map(|corner| corner.rad_s)
        .fold(0.0, f64::max);
    let (lowest, highest) = match (corners.is_empty(), of.nyquist_rad_s()) {
        (false, _) => (lowest, highest),
        (true, Some(nyquist)) => (nyquist, nyquist),
        (true, None) => (1.0, 1.0),
    };
    let low = settled(of, walk(of, lowest / BEYOND_CORNERS, 0.1));
    let high = match of.nyquist_rad_s() {
        Some(nyquist) => nyquist,
        None => walk(of, highest * BEYOND_CORNERS, 10.0).max(reach_rad_s),
    };
    let low = low.min(high / BEYOND_CORNERS);
    let decades = (high / low).log10();
    let count = (decades * POINTS_PER_DECADE).ceil();
    let mut points: Vec<f64> = (0..count as usize)
        .map(|i| low * 10f64.powf(decades * i as f64 / count))
        .collect();
    for corner in &corners {
        let closest = (-corner.damping.log10() + 1.0).clamp(0.0, CLOSEST_DECADES);
        let near = (0..=(2.0 * closest) as i32).map(|k| 10f64.powf(-f64::from(k) / 2.0 - 0.5));
        points.extend(
            near.flat_map(|step| [corner.rad_s * (1.0 - step), corner.rad_s * (1.0 + step)]),
        );
    }
    points.retain(|rad_s| (low..high).contains(rad_s));
    points.push(high);
    points.sort_by(f64::total_cmp);
    points.dedup_by(|b, a| *b - *a <= NARROWEST * *b);
    crowded(of, points)
}

/// The points with those between that no turn of what the law delays is missed.
fn crowded(of: &OpenLoop, points: Vec<f64>) -> Result<Vec<f64>, Unsure> {
    let mut all: Vec<f64> = Vec::with_capacity(points.len());
    for to in points {
        let from = all.last().copied();
        if let (Some(from), Some(step)) = (from, of.step_rad_s(to)) {
            let parts = ((to - from) / step).ceil();
            if parts + all.len() as f64 > MOST_POINTS as f64 {
                return Err(Unsure::Turns {
                    from_rad_s: from,
                    to_rad_s: to,
                });
            }
            all.extend((1..parts as usize).map(|i| from + (to - from) * i as f64 / parts));
        }
        all.push(to);
    }
    Ok(all)
}

/// Moves from an outermost frequency outward, decade by decade, as long as the magnitude approaches one.
fn walk(of: &OpenLoop, from: f64, factor: f64) -> f64 {
    // A smaller change per decade is no slope: a slope is at least one power of ten.
    const FLAT: f64 = 0.1;
    let levels = |rad_s: f64| of.at(rad_s).map(|point| point.loci.map(level));
    let mut rad_s = from;
    for _ in 0..MOST_DECADES {
        let (Some(here), Some(next)) = (levels(rad_s), levels(rad_s * factor)) else {
            break;
        };
        let is_approaching = here.iter().zip(next).any(|(here, next)| {
            here.is_finite()
                && if *here > 0.0 {
                    next < here - FLAT
                } else {
                    next > here + FLAT
                }
        });
        if !is_approaching {
            break;
        }
        rad_s *= factor;
    }
    rad_s
}

/// Moves further down until only a power of the frequency is left: a constant, or what integrators make, well away
/// from 1. Then the angle at frequency 0 is known.
fn settled(of: &OpenLoop, from: f64) -> f64 {
    // The slope is a whole number of powers, within this.
    const WHOLE: f64 = 0.005;
    // A hundredfold or a hundredth.
    const AWAY: f64 = 4.6;
    // With an integrator L has to rise in the end; but a zero may be there too. Of two loci one does, and far below
    // it the other is lost in its rounding.
    const PATIENCE: usize = 12;
    let mut rad_s = from;
    for round in 0..MOST_DECADES {
        let must_rise = of.has_integrator() && round < PATIENCE;
        let here = of.at(rad_s).map(|point| point.loci.map(level));
        let next = of.at(rad_s * 0.1).map(|point| point.loci.map(level));
        let (Some(here), Some(next)) = (here, next) else {
            break;
        };
        let slopes = here
            .iter()
            .zip(next)
            .map(|(here, next)| (*here, (next - here) / std::f64::consts::LN_10));
        let rises = |(here, slope): (f64, f64)| {
            (slope - slope.round()).abs() < WHOLE && slope.round() > 0.0 && here > AWAY
        };
        let is_settled = slopes.clone().all(|(here, slope)| {
            let is_whole = (slope - slope.round()).abs() < WHOLE;
            !slope.is_finite()
                || rises((here, slope))
                || is_whole && (slope.round() == 0.0 || here < -AWAY)
        });
        rad_s *= 0.1;
        if is_settled && (!must_rise || slopes.clone().any(rises)) {
            break;
        }
    }
    rad_s
}

/// Adds the nodes between two until none is far from the line between its neighbours; returns the second, its
/// loci in the order of the last.
fn divide(of: &OpenLoop, a: Node, b: Node, nodes: &mut Vec<Node>) -> Result<Node, Unsure> {
    let mut waiting = vec![b];
    let mut from = a;
    let most = MOST_POINTS.min(nodes.len() + MOST_BETWEEN);
    while let Some(to) = waiting.last().copied() {
        if nodes.len() > most {
            return Err(Unsure::Turns {
                from_rad_s: a.rad_s,
                to_rad_s: b.rad_s,
            });
        }
        let middle = if to.rad_s > 1.5 * from.rad_s {
            (from.rad_s * to.rad_s).sqrt()
        } else {
            from.rad_s + (to.rad_s - from.rad_s) / 2.0
        };
        let between = of
            .at(middle)
            .map(|at| matched(Node { rad_s: middle, at }, from.at));
        let is_narrow = to.rad_s - from.rad_s <= NARROWEST * to.rad_s;
        match between {
            Some(between) if !is_narrow && !is_straight(&from, &between, &to) => {
                waiting.pop();
                waiting.push(matched(to, between.at));
                waiting.push(between);
            }
            _ => {
                from = to;
                waiting.pop();
                if !waiting.is_empty() {
                    nodes.push(to);
                }
            }
        }
    }
    Ok(from)
}

/// Whether a node between two others is about where a straight line has it.
fn is_straight(a: &Node, between: &Node, b: &Node) -> bool {
    const BEND: f64 = 0.05;
    const TURN_RAD: f64 = 0.5;
    const RISE: f64 = 2.0;
    const FAINT: f64 = 1e-12;
    let each = (0..2).all(|locus| {
        let [x, y, z] = [a, between, b].map(|node| node.at.loci[locus]);
        // So little decides nothing, and may be rounding.
        if [x, y, z].iter().all(|l| l.norm() < FAINT) || [x, y, z].iter().any(|l| l.norm() == 0.0) {
            return true;
        }
        let (first, second) = ((y / x).ln(), (z / y).ln());
        (first - second).norm() < BEND
            && first.im.abs() < TURN_RAD
            && second.im.abs() < TURN_RAD
            && first.re.abs() < RISE
    });
    if !each {
        return false;
    }
    let leads = leading(&between.at);
    let [x, y, z] = [a, between, b].map(|node| product(&node.at, leads));
    (y / x).arg().abs() < TURN_RAD && (z / y).arg().abs() < TURN_RAD
}

/// Which loci are larger than 1.
pub(crate) fn leading(at: &Point) -> [bool; 2] {
    at.loci.map(|l| level(l) > 0.0)
}

/// What the angle of the closed loop's polynomial follows: the poles' product, times the loci that lead.
pub(crate) fn product(at: &Point, leads: [bool; 2]) -> Complex<f64> {
    let mut product = at.turn;
    for (l, leads) in at.loci.iter().zip(leads) {
        if leads {
            product *= l / l.norm();
        }
    }
    product
}
