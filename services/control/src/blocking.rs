//! The loop of a client with one request at a time: the longest constant round trip with which it is stable.
//!
//! Such a client sends at the first deadline after it has received its answer. A longer round trip
//! therefore not only delays its commands but makes them rarer: one every ceil(RTT/h) deadlines, held
//! by the plant over all ticks between. And a law that advances by h per message, however long the
//! message took, becomes slower. From command to command this is a loop of its own, whose poles are
//! computed here. Variable delays are left to the ends that run the loop.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::hessenberg::eigenvalues;
use crate::law::Law;
use crate::law::swept::SweptLaw;
use crate::minimal::{Fate, Minimal};
use crate::open_loop::OpenLoop;
use crate::plant::SampledPlant;
use crate::scan::{Scan, Unsure};
use crate::state_space::StateSpace;
use crate::swept::{Swept, difference, over_h};
use crate::timebase::Discrete;
use crate::transfer::InvalidTransferFunction;
use crate::wide::Wide;
use crate::wide::matrix::Matrix;
use crate::winding::unstable_poles;

/// Once the plant's response to its old state has decayed to this share, holding a command for longer
/// changes nothing.
const FORGOTTEN: f64 = 1e-12;
/// Most ticks between two commands; longer round trips are not examined.
const LONGEST_TICKS: usize = 1_000_000;
/// From so many ticks on, by one part of as many at once: a plant at rest or nearly so would be asked for minutes.
const STEP_PART: usize = 500;
/// With more states than this, computing the poles for every round trip takes too long.
const MOST_STATES: usize = 60;

/// Why there is no result for a loop with one request at a time.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Untold {
    /// Too many states, for instance from a dead time of hundreds of samples.
    #[error(
        "plant and law have {states} states; the poles for every round trip can be computed for at \
         most {most}"
    )]
    States {
        /// States of plant and law together.
        states: usize,
        /// The limit.
        most: usize,
    },
    /// The law's numbers overflow.
    #[error(transparent)]
    Law(#[from] InvalidTransferFunction),
    /// Rounding would decide.
    #[error(transparent)]
    Unsure(#[from] Unsure),
}

/// The longest constant round trip, in seconds, at which a loop with one request at a time is stable,
/// as at every shorter one: a multiple of h.
///
/// Infinite if no round trip makes it unstable; `None` if it is unstable even at the shortest.
///
/// With y read at a command's arrival before the command acts, n ticks to the next command, a dead time of d = i n + b
/// ticks, the sum S of k powers of A from 0 on, and the law s' = F s + G y, u = H s + E y, where v is the command of i
/// commands ago and w the one before it:
///
/// ```text
/// x' = A^n x + S(n-b) B v + A^(n-b) S(b) B w      y' = C (A^(n-1) x + S(n-1-b) B v + A^(n-1-b) S(b) B w) + D v
/// s' = F s + G y                                  u' = H s + E y
/// ```
///
/// A stretch of unstable round trips between two stable ones that is shorter than a five-hundredth of them can be missed
/// beyond 1000 ticks.
///
/// # Errors
/// [`Untold`] if there are too many states, or numbers overflow.
pub fn largest_stable_blocking_round_trip_s(
    plant: &SampledPlant,
    law: &Law,
) -> Result<Option<f64>, Untold> {
    let h_s = plant.h_s();
    let of_plant = plant.system.order().saturating_add(plant.delay_ticks);
    let states = of_plant.saturating_add(law.order());
    if states > MOST_STATES {
        return Err(Untold::States {
            states,
            most: MOST_STATES,
        });
    }
    let overflow = || InvalidTransferFunction::NotFinite {
        polynomial: "den",
        index: 0,
        coefficient: f64::INFINITY,
    };
    let exact = Exact::new(plant, law).ok_or_else(overflow)?;
    if exact.grows_unseen {
        return Ok(None);
    }
    let law = law.state_space(h_s)?;
    let mut held = 0;
    while held < LONGEST_TICKS {
        let ticks = held + (held / STEP_PART).max(1);
        let interval = Interval::new(ticks, plant);
        let poles = eigenvalues(&interval.step(&plant.system, &law));
        // Poles near 1 are known to a root of the precision alone, so what they say is asked again.
        if poles.is_empty() || poles.iter().any(|pole| pole.norm() >= 1.0) {
            held = match exact.is_stable(ticks)? {
                true => exact.last_stable(ticks, plant)?,
                false => exact.last_before(held, ticks)?,
            };
            return Ok(match held {
                0 => None,
                ticks if ticks >= LONGEST_TICKS => Some(f64::INFINITY),
                ticks => Some(ticks as f64 * h_s),
            });
        }
        if interval.is_forgotten() {
            break;
        }
        held = ticks;
    }
    Ok(Some(f64::INFINITY))
}

/// A^n, and the sum of A's powers before it.
struct Powers {
    last: DMatrix<f64>,
    sum: DMatrix<f64>,
}

impl Powers {
    fn new(a: &DMatrix<f64>, n: usize) -> Self {
        let size = a.nrows();
        let one = DMatrix::identity(size, size);
        let (mut last, mut sum) = (one.clone(), one.clone() * 0.0);
        for bit in (0..usize::BITS - n.leading_zeros()).rev() {
            sum = &sum + &sum * &last;
            last = &last * &last;
            if n >> bit & 1 == 1 {
                sum = &one + a * &sum;
                last = a * &last;
            }
        }
        Self { last, sum }
    }
}

/// What a plant does between two commands that come `ticks` apart, with a dead time of whole commands and a part.
struct Interval {
    commands: usize,
    /// A^n and A^(n-1).
    grown: [DMatrix<f64>; 2],
    /// A to the power of the ticks since the command acts that is the last to act.
    since: DMatrix<f64>,
    /// What the command adds that acts from the dead time's part on, to the state and to the output, and what the one
    /// before it adds until then.
    next: [DMatrix<f64>; 2],
    last: [DMatrix<f64>; 2],
}

impl Interval {
    fn new(ticks: usize, plant: &SampledPlant) -> Self {
        let (a, b) = (plant.system.a(), plant.system.b());
        let (commands, part) = (plant.delay_ticks / ticks, plant.delay_ticks % ticks);
        let before = Powers::new(a, part).sum * b;
        let after = Powers::new(a, ticks - 1 - part);
        let one_later = a * &after.last;
        let next = &after.sum * b;
        Self {
            commands,
            grown: match part {
                0 => [one_later.clone(), after.last.clone()],
                _ => [ticks, ticks - 1].map(|n| Powers::new(a, n).last),
            },
            last: [&one_later * &before, &after.last * before],
            since: one_later,
            next: [a * &next + b, next],
        }
    }

    /// Whether the last command acts before the next comes, and what was before it acts is forgotten by then.
    fn is_forgotten(&self) -> bool {
        self.commands == 0 && self.since.norm() < FORGOTTEN
    }

    /// The loop from command to command: the state is x, y, s, and the commands, newest first.
    fn step(&self, plant: &StateSpace<Discrete>, law: &StateSpace<Discrete>) -> DMatrix<f64> {
        let (order, of_law) = (plant.order(), law.order());
        let (p, m) = (plant.outputs(), plant.inputs());
        let (y, s) = (order, order + p);
        let u = s + of_law;
        let next = u + self.commands * m;
        let last = next + m;
        let size = last + m;
        let mut step = DMatrix::zeros(size, size);
        let c = plant.c();
        let mut put = |row: usize, column: usize, part: &DMatrix<f64>| {
            step.view_mut((row, column), part.shape()).copy_from(part);
        };
        put(0, 0, &self.grown[0]);
        put(0, next, &self.next[0]);
        put(0, last, &self.last[0]);
        put(y, 0, &(c * &self.grown[1]));
        put(y, next, &(c * &self.next[1] + plant.d()));
        put(y, last, &(c * &self.last[1]));
        put(s, s, law.a());
        put(s, y, law.b());
        put(u, s, law.c());
        put(u, y, law.d());
        let older = (self.commands + 1) * m;
        put(u + m, u, &DMatrix::identity(older, older));
        step
    }
}

/// The same loop in wide numbers, whose unstable poles are counted and not computed.
struct Exact {
    /// (A - 1)/h, B/h and C of what the loop sees.
    minimal: Minimal,
    d: DMatrix<f64>,
    delay_ticks: usize,
    law: SweptLaw,
    grows_unseen: bool,
    h_s: f64,
}

impl Exact {
    fn new(plant: &SampledPlant, law: &Law) -> Option<Self> {
        let (h_s, system) = (plant.h_s(), &plant.system);
        let (a, b) = (difference(system.a(), h_s), over_h(system.b(), h_s));
        let minimal = Minimal::sampled(a, b, system.c().into(), h_s);
        Some(Self {
            grows_unseen: minimal.hidden.iter().any(|mode| mode.fate == Fate::Grows),
            minimal,
            d: system.d().clone(),
            delay_ticks: plant.delay_ticks,
            law: SweptLaw::new(law, h_s)?,
            h_s,
        })
    }

    /// Whether the loop is stable with a command every `ticks` ticks; not with a pole on the border.
    fn is_stable(&self, ticks: usize) -> Result<bool, Unsure> {
        let Some(open) = self.open(ticks) else {
            return Ok(false);
        };
        let count = Scan::new(&open, 0.0).and_then(|scan| unstable_poles(&scan, 0));
        match count {
            Ok(count) => Ok(count == 0),
            Err(Unsure::Border) => Ok(false),
            Err(other) => Err(other),
        }
    }

    /// The loop from command to command, opened; `None` if it overflows.
    fn open(&self, ticks: usize) -> Option<OpenLoop> {
        let h = Wide::from(self.h_s);
        let whole = Wide::from(ticks as f64);
        let one = self.minimal.a.clone().each(|x| x * h);
        let (commands, part) = (self.delay_ticks / ticks, self.delay_ticks % ticks);
        let [
            (grown, _),
            (before, _),
            (later, sum_later),
            (rest, sum_rest),
            (_, sum_part),
        ] = [ticks, ticks - 1, ticks - part, ticks - 1 - part, part].map(|n| power(&one, n));
        let b = &self.minimal.b;
        let acted = sum_part.times(b);
        // Over n h, of which B/h has one.
        let a = grown.each(|x| x / (whole * h));
        let next = sum_later.times(b).each(|x| x / whole);
        let last = acted.clone().plus(&later.times(&acted)).each(|x| x / whole);
        let c = &self.minimal.c;
        let read = c.clone().plus(&c.times(&before));
        let through = c.times(&sum_rest.times(b)).each(|x| x * h).rounded() + &self.d;
        let at_once = acted.clone().plus(&rest.times(&acted));
        let at_once = c.times(&at_once).each(|x| x * h).rounded();
        let period_s = ticks as f64 * self.h_s;
        let plant = match part {
            0 => Swept::new(&a, &next, &read, &through, period_s),
            _ => Swept::split(&a, [next, last], &read, [&through, &at_once], period_s),
        }?;
        // The output that one command finds is used for the next, and that acts when it arrives.
        let law = self.law.clone();
        Some(OpenLoop::around(
            plant,
            law,
            self.h_s,
            2 + commands,
            period_s,
        ))
    }

    /// The last stable number of ticks from `held` on, which seems to be, to `lost`, which is not.
    fn last_before(&self, held: usize, lost: usize) -> Result<usize, Unsure> {
        if held == 0 {
            return Ok(0);
        }
        if self.is_stable(held)? {
            return self.between(held, lost);
        }
        match self.is_stable(1)? {
            true => self.between(1, held),
            false => Ok(0),
        }
    }

    /// The last stable number of ticks from one that is stable, in growing steps; so a short stretch of unstable
    /// ones between two stable ones can be missed.
    fn last_stable(&self, from: usize, plant: &SampledPlant) -> Result<usize, Unsure> {
        const STEP: f64 = 1.1;
        let mut held = from;
        while held < LONGEST_TICKS {
            if Interval::new(held, plant).is_forgotten() {
                return Ok(LONGEST_TICKS);
            }
            let next = ((held as f64 * STEP) as usize).max(held + 1);
            if !self.is_stable(next)? {
                return self.between(held, next);
            }
            held = next;
        }
        Ok(held)
    }

    fn between(&self, mut held: usize, mut lost: usize) -> Result<usize, Unsure> {
        while lost - held > 1 {
            let middle = held + (lost - held) / 2;
            if self.is_stable(middle)? {
                held = middle;
            } else {
                lost = middle;
            }
        }
        Ok(held)
    }
}

/// Aⁿ - 1 and Aⁿ⁻¹ + .. + 1, from A - 1: without a difference of numbers that are nearly equal.
fn power(one: &Matrix, n: usize) -> (Matrix, Matrix) {
    let size = one.rows();
    let (mut grown, mut sum) = (Matrix::zeros(size, size), Matrix::zeros(size, size));
    for bit in (0..usize::BITS - n.leading_zeros()).rev() {
        // Twice as many.
        let doubled = grown.clone().each(|x| x.scaled(2.0));
        sum = sum.clone().each(|x| x.scaled(2.0)).plus(&sum.times(&grown));
        grown = doubled.plus(&grown.times(&grown));
        if n >> bit & 1 == 1 {
            // And one more.
            sum = Matrix::identity(size).plus(&sum).plus(&one.times(&sum));
            grown = one.clone().plus(&grown).plus(&one.times(&grown));
        }
    }
    (grown, sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discretise::Method;
    use crate::pid::{Gains, Pid};
    use crate::plant::Plant;
    use crate::preset::{paper_pi, paper_plant};
    use crate::timebase::Continuous;
    use crate::transfer::TransferFunction;

    fn longest_s(h_ns: u64, law: Pid) -> Option<f64> {
        let plant = paper_plant().sampled(h_ns).expect("stable");
        largest_stable_blocking_round_trip_s(&plant, &law.into()).expect("few states")
    }

    #[test]
    fn a_dead_time_of_many_samples_is_left_untold_before_anything_is_worked_out() {
        let mut plant = paper_plant().sampled(1_000_000).expect("stable");
        for delay_ticks in [100, 1_000_000_000] {
            plant.delay_ticks = delay_ticks;
            let untold = largest_stable_blocking_round_trip_s(&plant, &paper_pi().into());
            assert_eq!(
                untold,
                Err(Untold::States {
                    states: delay_ticks + 3,
                    most: MOST_STATES
                })
            );
        }
    }

    #[test]
    fn a_plant_has_forgotten_nothing_until_it_has_had_its_time_after_the_dead_time() {
        // A lag that decays to a millionth of a millionth in 23 ticks of 10 ms, behind a dead time of 40.
        let model = TransferFunction::try_new([120.0], [1.0, 120.0], Continuous).expect("valid");
        let mut plant = Plant::new(&model, Method::ZeroOrderHold)
            .sampled(10_000_000)
            .expect("stable");
        plant.delay_ticks = 40;
        let forgotten = [30, 40, 41, 62, 64].map(|n| Interval::new(n, &plant).is_forgotten());
        assert_eq!(forgotten, [false, false, false, false, true]);
    }

    #[test]
    fn the_paper_s_loop_survives_less_from_a_client_that_waits() {
        for h_ns in [1_000_000, 3_000_000] {
            let longest_s = longest_s(h_ns, paper_pi()).expect("stable without a network");
            assert!((0.02..0.096).contains(&longest_s), "{longest_s} at {h_ns}");
        }
    }

    #[test]
    fn a_quiet_controller_survives_every_round_trip_and_a_loud_one_none() {
        let with = |kp| Pid::try_new(Gains::pi(kp, 0.0), None).expect("finite");
        assert_eq!(longest_s(3_000_000, with(0.01)), Some(f64::INFINITY));
        assert_eq!(longest_s(3_000_000, with(1e3)), None);
    }
}
