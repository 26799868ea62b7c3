//! Drawn loops on both sides of their border, by the loop's own steps: a delay and a gain just inside it die out, just
//! outside they do not.
//!
//! Which is which is what `fixtures/borders_reference.py` proved of each side, by counting poles; here nothing is
//! counted. By hand a thousandth of the gain shows after millions of steps. So a loop of some states is stepped by
//! the powers of its matrix, in `powers`; one of more by its own steps, of which the largest factors of growth are
//! told, in `krylov`. `WEBLOOP_TEST_BORDERS=1` takes all loops, of which then none may be left open, and prints how many
//! were told how, which takes minutes in a release; else a share of them is, with less patience, and a side that is
//! left open is no fault.

mod krylov;
mod powers;
mod system;

use std::sync::atomic::{AtomicUsize, Ordering};

use control::{Analysis, OpenLoop};

use crate::table::{Drawn, drawn};
use krylov::by_krylov;
use powers::by_powers;

/// How far from the gain margin; the reference has it too.
const OFF: f64 = 1e-3;

/// What became of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    DiesOut,
    Grows,
    /// There was not the time, or were not the digits, to tell.
    Open,
}

/// One side of a border, and how many poles of the closed loop are outside the unit circle there, by the reference.
struct Side {
    gain: f64,
    ticks: usize,
    outside: u32,
}

impl Side {
    fn fate(&self) -> Fate {
        match self.outside {
            0 => Fate::DiesOut,
            _ => Fate::Grows,
        }
    }
}

/// Both sides of both borders of a loop that is stable; none of another.
fn sides(of: &Drawn) -> Vec<Side> {
    let shortest = Analysis::SHORTEST_TICKS;
    let mut places = [None; 4];
    if let (Some(gain), Some(_)) = (of.gain, of.longest_ticks) {
        let off = if gain > 1.0 { OFF } else { -OFF };
        places[0] = Some((gain * (1.0 - off), shortest));
        places[1] = Some((gain * (1.0 + off), shortest));
    }
    if let Some(longest) = of.longest_ticks.filter(|ticks| ticks.is_finite()) {
        places[2] = Some((1.0, longest as usize));
        places[3] = Some((1.0, longest as usize + 1));
    }
    let both = places.into_iter().zip(of.outside);
    let each = both.enumerate().filter_map(|(i, both)| match both {
        (Some((gain, ticks)), Some(outside)) => Some(Side {
            gain,
            ticks,
            outside,
        }),
        (None, None) => None,
        _ => panic!("line {}: side {i} has no count, or no border", of.line),
    });
    each.collect()
}

/// How much is tried.
#[derive(Debug, Clone, Copy)]
struct Patience {
    /// Most states of a loop that is stepped by powers.
    states: usize,
    /// Most steps of one.
    steps: usize,
    /// One loop in so many.
    share: usize,
}

/// How often each was told, and what was told wrong.
#[derive(Debug, Default)]
struct Tally {
    powers: usize,
    krylov: usize,
    open: Vec<String>,
    wrong: Vec<String>,
}

impl Tally {
    fn try_one(&mut self, of: &Drawn, side: &Side, patience: Patience) {
        let model = &of.plant.model;
        let dead = (of.plant.dead_time_ns / of.h_ns) as usize * model.inputs();
        let states = model.order() + of.law.order() + side.ticks * model.outputs() + dead;
        let by_power = if states <= patience.states {
            by_powers(of, side.gain, side.ticks)
        } else {
            Fate::Open
        };
        let found = match by_power {
            Fate::Open => by_krylov(of, side.gain, side.ticks, patience.steps),
            told => told,
        };
        let what = || {
            let Side { gain, ticks, .. } = side;
            let expected = side.fate();
            let line = of.line;
            format!(
                "line {line}: gain {gain}, {ticks} ticks, {states} states: {found:?} for {expected:?}"
            )
        };
        match found {
            Fate::Open => self.open.push(what()),
            found if found != side.fate() => self.wrong.push(what()),
            _ if by_power == Fate::Open => self.krylov += 1,
            _ => self.powers += 1,
        }
    }

    fn add(&mut self, other: Self) {
        self.powers += other.powers;
        self.krylov += other.krylov;
        self.open.extend(other.open);
        self.wrong.extend(other.wrong);
    }
}

/// Both sides of every border, on two processors.
fn tally(chosen: &[&Drawn], patience: Patience) -> Tally {
    let next = AtomicUsize::new(0);
    let mut all = Tally::default();
    std::thread::scope(|scope| {
        let each = || {
            let mut tally = Tally::default();
            while let Some(of) = chosen.get(next.fetch_add(1, Ordering::Relaxed)) {
                for side in sides(of) {
                    tally.try_one(of, &side, patience);
                }
            }
            tally
        };
        let both = [scope.spawn(each), scope.spawn(each)];
        for one in both {
            all.add(one.join().expect("no panic"));
        }
    });
    all
}

fn takes_all() -> bool {
    std::env::var_os("WEBLOOP_TEST_BORDERS").is_some()
}

#[test]
#[allow(clippy::print_stdout)]
fn a_delay_or_a_gain_inside_the_border_dies_out_and_one_outside_does_not() {
    let patience = if takes_all() {
        Patience {
            states: 56,
            steps: 200_000_000,
            share: 1,
        }
    } else {
        Patience {
            states: 40,
            steps: 40_000,
            share: 16,
        }
    };
    let drawn = drawn();
    let chosen: Vec<&Drawn> = drawn.iter().step_by(patience.share).collect();
    let found = tally(&chosen, patience);
    println!(
        "of {} loops: {} sides by powers, {} by Krylov's space, {} open, {} wrong",
        chosen.len(),
        found.powers,
        found.krylov,
        found.open.len(),
        found.wrong.len()
    );
    let wrong = found.wrong.join("\n");
    assert!(wrong.is_empty(), "{wrong}");
    let open = found.open.join("\n");
    assert!(!takes_all() || open.is_empty(), "open:\n{open}");
}

#[test]
fn analysis_finds_a_gain_inside_the_border_stable_and_one_outside_not() {
    const SHARE: usize = 16;
    let drawn = drawn();
    let share = if takes_all() { 1 } else { SHARE };
    let mut wrong = Vec::new();
    for of in drawn.iter().step_by(share) {
        for side in sides(of).iter().filter(|side| side.gain != 1.0) {
            let mut plant = of.plant.clone();
            plant.model = system::louder(&plant.model, side.gain);
            let open = OpenLoop::new(&plant, &of.law, of.h_ns).expect("finite");
            let found = Analysis::of(&open).map(|found| found.longest_s.is_some());
            if found != Ok(side.fate() == Fate::DiesOut) {
                wrong.push(format!("line {}: gain {}: {found:?}", of.line, side.gain));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
