//! What the plant's end steps every h: webloop's own linear model, or whatever else answers to
//! inputs with outputs.

use control::{Signals, Stepper};

/// A plant that advances by h at each step.
pub trait Model {
    /// Advances by h under the inputs `u`, which are held meanwhile; returns the outputs of the tick that was
    /// due at `due_ns`.
    fn step(&mut self, u: Signals, due_ns: u64) -> Signals;

    /// What sensors show of the outputs `y` of the last step: that is what controllers get.
    fn measured(&mut self, y: Signals) -> Signals {
        y
    }

    /// The input that acted in the last step, where something lies between it and the given one: an actuator. A
    /// disturbance is not part of it.
    fn applied(&self) -> Option<Signals> {
        None
    }

    /// Puts it back into the state before the first step, if it can do that; returns whether.
    fn reset(&mut self) -> bool {
        false
    }

    /// Whether it can be reset.
    fn can_reset(&self) -> bool {
        false
    }

    /// The outputs before the first step. They are not asked for later.
    fn at_rest(&self) -> Signals {
        0.0.into()
    }

    /// How many inputs it has: 1 or 2.
    fn inputs(&self) -> usize {
        1
    }

    /// Whether it has a second input or output. Like [`Model::at_rest`] it is asked before the first step.
    fn has_second(&self) -> bool {
        self.inputs() > 1 || self.at_rest().count() > 1
    }

    /// Whether it can step no more, as a program that has ended. What it returned last is no output then.
    fn is_broken(&self) -> bool {
        false
    }
}

impl Model for Stepper {
    #[inline]
    fn step(&mut self, u: Signals, _: u64) -> Signals {
        Stepper::step_all(self, u)
    }

    fn at_rest(&self) -> Signals {
        self.output()
    }

    fn inputs(&self) -> usize {
        Stepper::inputs(self)
    }

    fn reset(&mut self) -> bool {
        Stepper::reset(self);
        true
    }

    fn can_reset(&self) -> bool {
        true
    }
}

impl<M: Model + ?Sized> Model for Box<M> {
    fn step(&mut self, u: Signals, due_ns: u64) -> Signals {
        (**self).step(u, due_ns)
    }

    fn measured(&mut self, y: Signals) -> Signals {
        (**self).measured(y)
    }

    fn applied(&self) -> Option<Signals> {
        (**self).applied()
    }

    fn reset(&mut self) -> bool {
        (**self).reset()
    }

    fn can_reset(&self) -> bool {
        (**self).can_reset()
    }

    fn at_rest(&self) -> Signals {
        (**self).at_rest()
    }

    fn inputs(&self) -> usize {
        (**self).inputs()
    }

    fn is_broken(&self) -> bool {
        (**self).is_broken()
    }
}
