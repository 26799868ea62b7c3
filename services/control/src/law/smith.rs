//! A Smith predictor: a PID that controls a model without dead time, corrected by the difference
//! between the plant and the delayed model.
//!
//! O. J. M. Smith, "Closer control of loops with dead time" (1957). The dead time is the plant's own
//! plus the expected round trip of the network. If the real one differs, the correction comes late;
//! with a plant that is unstable by itself the predictor is unstable.

use std::collections::VecDeque;

use nalgebra::DMatrix;

use crate::closed_loop::loop_delay_ticks;
use crate::pid::{Gains, Pid};
use crate::plant::SampledPlant;
use crate::polynomial::{product, sum};
use crate::state_space::StateSpace;
use crate::stepper::Stepper;
use crate::timebase::Discrete;
use crate::transfer::{InvalidTransferFunction, TransferFunction};

/// A PID around a model, with the model's outputs over the dead time.
#[derive(Debug, Clone, PartialEq)]
pub struct Smith {
    pid: Pid,
    model: StateSpace<Discrete>,
    stepper: Stepper,
    /// The model's newest output.
    fresh: f64,
    /// The model's earlier outputs, oldest first: the oldest is what the plant should show now.
    line: VecDeque<f64>,
    output: f64,
}

impl Smith {
    /// `pid` at rest, with the plant as model and `ticks` ticks between a model's output and the
    /// plant's own, as seen by the controller.
    #[must_use]
    pub fn new(pid: Pid, model: StateSpace<Discrete>, ticks: usize) -> Self {
        Self {
            pid,
            stepper: Stepper::new(&model),
            model,
            fresh: 0.0,
            line: VecDeque::from(vec![0.0; ticks]),
            output: 0.0,
        }
    }

    /// Number of ticks by which a model without dead time is ahead of the output of `plant` that the
    /// controller sees, if messages take a round trip of `rtt_ns`: the dead time plus the loop's
    /// delay, less the tick by which the model itself is late.
    #[must_use]
    pub fn ticks(plant: &SampledPlant, rtt_ns: u64, h_ns: u64) -> usize {
        plant.delay_ticks + loop_delay_ticks(rtt_ns, h_ns).get() - 1
    }

    #[inline]
    pub(super) fn update(&mut self, r: f64, y: f64, dt_s: f64) -> f64 {
        if !(r.is_finite() && y.is_finite()) {
            return self.output;
        }
        let old = self.line.front().copied().unwrap_or(self.fresh);
        let e = r - y - (self.fresh - old);
        let u = self.pid.update(e, dt_s);
        let fresh = self.stepper.step(u);
        if fresh.is_finite() && self.stepper.is_finite() {
            if self.line.pop_front().is_some() {
                self.line.push_back(self.fresh);
            }
            self.fresh = fresh;
        } else {
            self.stepper.undo();
        }
        self.output = u;
        u
    }

    /// With the PID C, the model M and t ticks: u = C e, e = -y - (1 - z^-t) z^-1 M u, hence C / (1 +
    /// C M z^-1 (1 - z^-t)).
    pub(super) fn transfer_function(
        &self,
        h_s: f64,
    ) -> Result<TransferFunction<Discrete>, InvalidTransferFunction> {
        let c = self.pid.gains().sampled(h_s)?;
        let m = self.model.transfer_function()?;
        let t = self.line.len();
        // z^(t + 1), and z^t - 1.
        let mut later = vec![0.0; t + 2];
        later[0] = 1.0;
        let mut difference = vec![0.0; t + 1];
        difference[0] = 1.0;
        difference[t] -= 1.0;
        let inner = product(&product(c.den(), m.den()), &later);
        let outer = product(&product(c.num(), m.num()), &difference);
        TransferFunction::try_new(
            product(&product(c.num(), m.den()), &later),
            sum(&inner, &outer),
            c.timebase(),
        )
    }

    /// The gains of its PID.
    pub(super) fn gains(&self) -> Gains {
        self.pid.gains()
    }

    /// Its model of the plant.
    pub(super) fn model(&self) -> &StateSpace<Discrete> {
        &self.model
    }

    /// By how many ticks the model is ahead of the output.
    pub(super) fn ticks_ahead(&self) -> usize {
        self.line.len()
    }

    /// The states of the PID and the model, `fresh`, and the delay line.
    pub(super) fn order(&self) -> usize {
        self.pid.gains().order() + self.model.order() + 1 + self.line.len()
    }

    /// From y to u with r = 0. The states are those of the PID and the model, `fresh`, and the delay line.
    pub(super) fn state_space(
        &self,
        h_s: f64,
    ) -> Result<StateSpace<Discrete>, InvalidTransferFunction> {
        let pid = StateSpace::from(&self.pid.gains().sampled(h_s)?);
        let (p, m, t) = (pid.order(), self.model.order(), self.line.len());
        let n = p + m + 1 + t;
        let (fresh, line) = (p + m, p + m + 1);
        // e = -y - fresh + old, where old is the oldest in the line, or fresh itself if the line is empty.
        let mut error = DMatrix::zeros(1, n);
        if t > 0 {
            error[fresh] = -1.0;
            error[line] = 1.0;
        }
        // u = Cp xp + Dp e.
        let mut command = &error * pid.d0();
        let mut own = command.columns_mut(0, p);
        own += pid.c();
        let at_once = -pid.d0();

        let mut a = DMatrix::zeros(n, n);
        let mut b = DMatrix::zeros(n, 1);
        a.view_mut((0, 0), (p, p)).copy_from(pid.a());
        let mut of_pid = a.rows_mut(0, p);
        of_pid += pid.b() * &error;
        b.rows_mut(0, p).copy_from(&-pid.b());

        a.view_mut((p, p), (m, m)).copy_from(self.model.a());
        let mut of_model = a.rows_mut(p, m);
        of_model += self.model.b() * &command;
        b.rows_mut(p, m).copy_from(&(self.model.b() * at_once));

        a.view_mut((fresh, p), (1, m)).copy_from(self.model.c());
        let mut of_fresh = a.rows_mut(fresh, 1);
        of_fresh += &command * self.model.d0();
        b[fresh] = self.model.d0() * at_once;

        for i in 0..t {
            let from = if i + 1 < t { line + i + 1 } else { fresh };
            a[(line + i, from)] = 1.0;
        }
        let d = DMatrix::from_element(1, 1, at_once);
        Ok(StateSpace::try_new(a, b, command, d, pid.timebase())
            .expect("finite parts in shapes that fit"))
    }
}
