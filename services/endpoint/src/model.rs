//! What the plant's end steps every h: webloop's own linear model, or whatever else answers to an input
//! with an output.

use control::Stepper;

/// A plant that advances by h at each step.
pub trait Model {
    /// Advances by h under the input `u`, which is held meanwhile; returns the output of the tick that was
    /// due at `due_ns`.
    fn step(&mut self, u: f64, due_ns: u64) -> f64;

    /// What a sensor shows of the output `y` of the last step: that is what controllers get.
    fn measured(&mut self, y: f64) -> f64 {
        y
    }

    /// The output before the first step. It is not asked for later.
    fn at_rest(&self) -> f64 {
        0.0
    }

    /// Whether it can step no more, as a program that has ended. What it returned last is no output then.
    fn is_broken(&self) -> bool {
        false
    }
}

impl Model for Stepper {
    #[inline]
    fn step(&mut self, u: f64, _: u64) -> f64 {
        Stepper::step(self, u)
    }

    fn at_rest(&self) -> f64 {
        self.output()
    }
}

impl<M: Model + ?Sized> Model for Box<M> {
    fn step(&mut self, u: f64, due_ns: u64) -> f64 {
        (**self).step(u, due_ns)
    }

    fn measured(&mut self, y: f64) -> f64 {
        (**self).measured(y)
    }

    fn at_rest(&self) -> f64 {
        (**self).at_rest()
    }

    fn is_broken(&self) -> bool {
        (**self).is_broken()
    }
}
