//! A drawn loop as matrices in 32 digits: its plant and its law, and the whole closed loop. How it is told whether it
//! dies out is in `powers` and `krylov`.

use control::{Discrete, Gains, Law, Plant, StateSpace, seconds};

use crate::table::Drawn;
use crate::wide::{Matrix, Number};

/// A sampled system in 32 digits: x' = x + delta x + B u, y = C x + D u.
struct Wide {
    delta: Matrix,
    b: Matrix,
    c: Matrix,
    d: Matrix,
}

impl Wide {
    fn empty(n: usize, m: usize, p: usize) -> Self {
        Self {
            delta: Matrix::zeros(n, n),
            b: Matrix::zeros(n, m),
            c: Matrix::zeros(p, n),
            d: Matrix::zeros(p, m),
        }
    }

    fn signals(&self) -> (usize, usize, usize) {
        (self.delta.rows, self.d.columns, self.d.rows)
    }

    /// What has its digits already.
    fn of(system: &StateSpace<Discrete>) -> Self {
        let less = Matrix::identity(system.order()).scaled((-1.0).into());
        Self {
            delta: Matrix::from(system.a()).plus(&less),
            b: system.b().into(),
            c: system.c().into(),
            d: system.d().into(),
        }
    }

    /// A plant by a zero-order hold, without its whole samples of dead time, and their number.
    fn sampled(plant: &Plant, h_ns: u64) -> (Self, usize) {
        let model = &plant.model;
        let (n, m, p) = (model.order(), model.inputs(), model.outputs());
        let held = |t_ns: u64| {
            let mut block = Matrix::zeros(n + m, n + m);
            block.add(0, 0, &model.a().into());
            block.add(0, n, &model.b().into());
            let all = block.scaled(wide_seconds(t_ns)).exp_m1();
            (all.part(0, 0, n, n), all.part(0, n, n, m))
        };
        let (delta, b) = held(h_ns);
        let (c, d) = (Matrix::from(model.c()), Matrix::from(model.d()));
        let ticks = usize::try_from(plant.dead_time_ns / h_ns).expect("a count");
        let rest_ns = plant.dead_time_ns % h_ns;
        if rest_ns == 0 {
            return (Self { delta, b, c, d }, ticks);
        }
        // The last input acts for the rest, and is a state.
        let (_, by_the_last) = held(rest_ns);
        let (after, by_the_next) = held(h_ns - rest_ns);
        let mut split = Self::empty(n + m, m, p);
        split.delta.add(0, 0, &delta);
        split.delta.add(0, n, &by_the_last);
        split.delta.add(0, n, &after.times(&by_the_last));
        let one = Matrix::identity(m);
        split.delta.add(n, n, &one.clone().scaled((-1.0).into()));
        split.b.add(0, 0, &by_the_next);
        split.b.add(n, 0, &one);
        split.c.add(0, 0, &c);
        split.c.add(0, n, &d);
        (split, ticks)
    }

    /// The system whose input acts `ticks` later.
    fn later(&self, ticks: usize) -> Self {
        let (n, m, p) = self.signals();
        let mut late = Self::empty(n + ticks * m, m, p);
        late.delta.add(0, 0, &self.delta);
        late.c.add(0, 0, &self.c);
        let one = Matrix::identity(m);
        let Some(last) = ticks.checked_sub(1) else {
            late.b.add(0, 0, &self.b);
            late.d.add(0, 0, &self.d);
            return late;
        };
        late.delta.add(0, n, &self.b);
        late.c.add(0, n, &self.d);
        for i in 0..ticks {
            let at = n + i * m;
            late.delta.add(at, at, &one.clone().scaled((-1.0).into()));
            if i < last {
                late.delta.add(at, at + m, &one);
            }
        }
        late.b.add(n + last * m, 0, &one);
        late
    }

    /// A PID from its error, each term by backward Euler.
    fn pid(gains: Gains, h_ns: u64) -> Self {
        let h = wide_seconds(h_ns);
        let terms = usize::from(gains.ki != 0.0) + usize::from(gains.kd != 0.0);
        let mut pid = Self::empty(terms, 1, 1);
        let mut direct = Number::from(gains.kp);
        if gains.ki != 0.0 {
            let per_tick = h.times(gains.ki.into());
            pid.b.set(0, 0, per_tick);
            pid.c.set(0, 0, 1.0.into());
            direct = direct.plus(per_tick);
        }
        if gains.kd != 0.0 {
            let i = terms - 1;
            let lag = match gains.filter_rad_s {
                w if w.is_infinite() => Number::default(),
                w => Number::from(1.0).over(w.into()),
            };
            // k (z - 1)/(z - 1 + f) is k less k f/(z - 1 + f).
            let (k, f) = (
                Number::from(gains.kd).over(lag.plus(h)),
                h.over(lag.plus(h)),
            );
            pid.delta.set(i, i, f.negated());
            pid.b.set(i, 0, 1.0.into());
            pid.c.set(0, i, k.times(f).negated());
            direct = direct.plus(k);
        }
        pid.d.set(0, 0, direct);
        pid
    }

    /// The law from y to u.
    fn law(of: &Drawn, plant: &Self) -> Self {
        match (&of.law, of.pid) {
            (Law::Pid(_), Some(gains)) => {
                let mut pid = Self::pid(gains, of.h_ns);
                pid.b = pid.b.scaled((-1.0).into());
                pid.d = pid.d.scaled((-1.0).into());
                pid
            }
            (Law::Smith(_), Some(gains)) => Self::smith(
                &Self::pid(gains, of.h_ns),
                plant,
                of.law.order() - plant.delta.rows - 1,
            ),
            (law, _) => Self::of(&law.state_space(seconds(of.h_ns)).expect("finite")),
        }
    }

    /// e = -y - fresh + old, where fresh is what the model gave last and old what it gave some ticks before.
    fn smith(pid: &Self, model: &Self, others: usize) -> Self {
        let ((p, _, _), (m, _, _)) = (pid.signals(), model.signals());
        let ticks = others - p;
        let (fresh, line) = (p + m, p + m + 1);
        let n = line + ticks;
        let (one, less) = (Number::from(1.0), Number::from(-1.0));
        let mut error = Matrix::zeros(1, n);
        if ticks > 0 {
            error.set(0, fresh, less);
            error.set(0, line, one);
        }
        let mut smith = Self::empty(n, 1, 1);
        smith.c = pid.d.times(&error);
        smith.c.add(0, 0, &pid.c);
        smith.d = pid.d.clone().scaled(less);
        smith.delta.add(0, 0, &pid.delta);
        smith.delta.add(0, 0, &pid.b.times(&error));
        smith.b.add(0, 0, &pid.b.clone().scaled(less));
        smith.delta.add(p, p, &model.delta);
        smith.delta.add(p, 0, &model.b.times(&smith.c));
        smith.b.add(p, 0, &model.b.times(&smith.d));
        smith.delta.add(fresh, p, &model.c);
        smith.delta.add(fresh, 0, &model.d.times(&smith.c));
        smith.b.add(fresh, 0, &model.d.times(&smith.d));
        for i in fresh..n {
            smith.delta.set(i, i, smith.delta.get(i, i).plus(less));
        }
        for i in 0..ticks {
            let from = if i + 1 < ticks { line + i + 1 } else { fresh };
            smith.delta.set(line + i, from, one);
        }
        smith
    }
}

/// A model with its inputs times `gain`. What of its outputs a zero cancels stays so: there rounding would uncover it.
pub(super) fn louder(of: &StateSpace, gain: f64) -> StateSpace {
    let (b, d) = (of.b() * gain, of.d() * gain);
    StateSpace::try_new(of.a().clone(), b, of.c().clone(), d, of.timebase()).expect("shapes fit")
}

fn wide_seconds(t_ns: u64) -> Number {
    Number::from(t_ns as f64).over(1e9.into())
}

/// Plant and law without any delay in whole ticks, and the plant's own such: what the states, and the outputs that the
/// law sees, add to the states, and what the newest outputs are.
pub(super) fn open(of: &Drawn, gain: f64) -> (Matrix, usize) {
    let (mut plant, dead) = Wide::sampled(&of.plant, of.h_ns);
    let law = Wide::law(of, &plant);
    plant.c = plant.c.scaled(gain.into());
    plant.d = plant.d.scaled(gain.into());
    let ((n, m, p), (s, _, _)) = (plant.signals(), law.signals());
    let mut u = Matrix::zeros(m, n + s);
    u.add(0, n, &law.c);
    let mut states = Matrix::zeros(n + s, n + s);
    states.add(0, 0, &plant.delta);
    states.add(n, n, &law.delta);
    states.add(0, 0, &plant.b.times(&u));
    let mut y = plant.d.times(&u);
    y.add(0, 0, &plant.c);
    let mut into = Matrix::zeros(n + s, p);
    into.add(0, 0, &plant.b.times(&law.d));
    into.add(n, 0, &law.b);
    states.balance(&mut into, &mut y);
    let mut all = Matrix::zeros(n + s + p, n + s + p);
    all.add(0, 0, &states);
    all.add(0, n + s, &into);
    all.add(n + s, 0, &y);
    all.add(n + s, n + s, &plant.d.times(&law.d));
    (all, dead)
}

/// The whole loop without a reference, `ticks` from an output to the first that depends on it: its matrix less 1, what
/// a push at the plant's input does, and what its outputs show.
///
/// The state is that of the plant, of the law, and the outputs under way, the newest first.
pub(super) fn closed(of: &Drawn, gain: f64, ticks: usize) -> [Matrix; 3] {
    let (plant, dead) = Wide::sampled(&of.plant, of.h_ns);
    let law = Wide::law(of, &plant);
    let mut plant = plant.later(dead);
    plant.c = plant.c.scaled(gain.into());
    plant.d = plant.d.scaled(gain.into());
    let ((n, m, p), (s, _, _)) = (plant.signals(), law.signals());
    // The output of this tick is used `ticks` later, when it is the oldest.
    let all = n + s + ticks * p;
    let oldest = all - p;
    let mut u = Matrix::zeros(m, all);
    u.add(0, n, &law.c);
    u.add(0, oldest, &law.d);
    let mut y = plant.d.times(&u);
    y.add(0, 0, &plant.c);
    let mut step = Matrix::zeros(all, all);
    step.add(0, 0, &plant.b.times(&u));
    step.add(0, 0, &plant.delta);
    step.add(n, n, &law.delta);
    step.add(n, oldest, &law.b);
    step.add(n + s, 0, &y);
    for i in n + s..all {
        step.set(i, i, step.get(i, i).plus((-1.0).into()));
    }
    for i in n + s + p..all {
        step.set(i, i - p, step.get(i, i - p).plus(1.0.into()));
    }
    let mut push = Matrix::zeros(all, m);
    push.add(0, 0, &plant.b);
    push.add(n + s, 0, &plant.d);
    step.balance(&mut push, &mut y);
    [step, push, y]
}
