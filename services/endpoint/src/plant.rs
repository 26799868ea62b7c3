//! The plant's end: it holds the last input and steps the model every h.
//!
//! It has two parts, because in a real run two threads own them: the [`Inbox`] takes commands as they arrive
//! and gives the input that is held, the [`Process`] steps the model at its deadlines. [`PlantEnd`] is both
//! together, for virtual time and for the test vectors. The HTTP around it is elsewhere.

use control::{Signals, Stepper};

use crate::{
    hold::Hold,
    message::{Acknowledgement, Answer, Command, Observation, Request, State},
    model::Model,
    noise::TickNoise,
    row::{ArrivalOutcome, ArrivalRow, SecondRow, TickRow},
    setting::{Late, Mode, PlantSettings},
};

/// The plant's input between two commands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// The input that is held, or both of them; 0 before the first command.
    pub u: Signals,
    /// The command that set it.
    pub seq: Option<u64>,
    /// When it was set; 0 before the first command.
    pub t_ns: u64,
}

/// The visible output of the process: its latest tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Number of the latest tick; also 0 before tick 0.
    pub tick: u64,
    /// What the sensor shows after that tick: the model's output, unless there is noise, or both of them.
    pub y: Signals,
}

/// Where commands arrive: numbers them, judges late ones, holds the input.
///
/// The age of a command is its sequence number. With [`Late::Drop`] all commands of a controller that
/// starts again from 0 are therefore stale, unless [`Inbox::welcome`] was called for it.
#[derive(Clone, Debug)]
pub struct Inbox {
    late: Late,
    input: Input,
    /// The newest command of this controller that was applied.
    newest: Option<u64>,
    arrivals: u64,
}

impl Inbox {
    /// An inbox that holds u = 0, for each of so many inputs.
    #[must_use]
    pub fn new(late: Late, inputs: usize) -> Self {
        Self {
            late,
            input: Input {
                u: Signals::zeros(inputs),
                ..Input::default()
            },
            newest: None,
            arrivals: 0,
        }
    }

    /// Accepts another controller, whose commands count from 0. The input is held.
    pub fn welcome(&mut self) {
        self.newest = None;
    }

    /// Takes a command that arrived at `now_ns`, while the output of the process was `output`;
    /// returns the row and the answer. A command without a number has that of its arrival.
    #[inline]
    pub fn command(
        &mut self,
        mode: Mode,
        request: &Request,
        output: Output,
        now_ns: u64,
    ) -> (ArrivalRow, Answer) {
        let &Request { seq, t_send_ns, u } = request;
        let seq = seq.unwrap_or(self.arrivals);
        let overtaken = self.newest.is_some_and(|newest| seq <= newest);
        let outcome = match (mode, self.late) {
            (Mode::Open, _) => ArrivalOutcome::Acknowledged,
            (Mode::Closed, Late::Drop) if overtaken => ArrivalOutcome::Stale,
            (Mode::Closed, _) => {
                self.input = Input {
                    u,
                    seq: Some(seq),
                    t_ns: now_ns,
                };
                self.newest = Some(seq);
                ArrivalOutcome::Applied
            }
        };
        let row = ArrivalRow {
            n: self.arrivals,
            seq,
            t_send_ns,
            t_arrive_ns: now_ns,
            tick: output.tick,
            u: u.first,
            outcome,
        };
        self.arrivals += 1;
        let answer = match mode {
            Mode::Open => Answer::Acknowledgement(Acknowledgement {
                seq,
                t_arrive_ns: now_ns,
            }),
            Mode::Closed => Answer::State(State {
                seq,
                tick: output.tick,
                t_arrive_ns: now_ns,
                y: output.y,
                u: self.input.u,
            }),
        };
        (row, answer)
    }

    /// The input that is held.
    #[must_use]
    pub fn input(&self) -> Input {
        self.input
    }

    /// How many inputs a command has to have.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.input.u.count()
    }

    /// Number of commands that have arrived.
    #[must_use]
    pub fn arrivals(&self) -> u64 {
        self.arrivals
    }
}

/// The model at its deadlines, start + k h.
#[derive(Clone, Debug)]
pub struct Process<M = Stepper> {
    model: M,
    h_ns: u64,
    hold: Hold,
    noise: Option<TickNoise>,
    next_k: u64,
    next_due_ns: u64,
    /// When the latest tick happened.
    last_ns: u64,
    output: Output,
    second: Option<SecondRow>,
}

impl<M: Model> Process<M> {
    /// A process whose tick 0 is due at `start_ns`. `model` advances by h at a step, and is at rest.
    #[must_use]
    pub fn new(settings: &PlantSettings, model: M, start_ns: u64) -> Self {
        Self {
            h_ns: settings.h.ns(),
            hold: settings.hold,
            noise: settings.tick_noise,
            next_k: 0,
            next_due_ns: start_ns,
            last_ns: 0,
            output: Output {
                tick: 0,
                y: model.at_rest(),
            },
            second: None,
            model,
        }
    }

    /// When the next tick is due.
    #[must_use]
    pub fn next_due_ns(&self) -> u64 {
        self.next_due_ns
    }

    /// When the next tick should happen: when it is due, plus its noise if the plant has any. Ticks
    /// keep their order, so never before the previous tick.
    #[must_use]
    pub fn next_tick_ns(&self) -> u64 {
        match self.noise {
            None => self.next_due_ns,
            Some(noise) => {
                let extra_ns = noise.extra_ns(self.next_k);
                self.next_due_ns.saturating_add(extra_ns).max(self.last_ns)
            }
        }
    }

    /// Performs the next tick with `input`; `now_ns` is only recorded. A late tick is caught up, not
    /// skipped, so simulated time stays at `k h`.
    #[inline]
    pub fn tick(&mut self, input: Input, now_ns: u64) -> TickRow {
        let k = self.next_k;
        let input = match self.hold {
            Hold::Last => input,
            // Judged by the due time, so that a tick that is caught up is stepped like one on time.
            Hold::For { ns } => {
                if self.next_due_ns.saturating_sub(input.t_ns) > ns {
                    Input {
                        u: input.u.map(|_| 0.0),
                        ..Input::default()
                    }
                } else {
                    input
                }
            }
        };
        let y = self.model.step(input.u, self.next_due_ns);
        self.output = Output {
            tick: k,
            y: self.model.measured(y),
        };
        let row = TickRow {
            k,
            t_due_ns: self.next_due_ns,
            t_tick_ns: now_ns,
            u: input.u.first,
            y: y.first,
            seq: input.seq,
        };
        let has_second = input.u.second.is_some() || y.second.is_some();
        self.second = has_second.then_some(SecondRow {
            k,
            u2: input.u.second,
            y2: y.second,
        });
        self.next_k += 1;
        self.last_ns = now_ns;
        self.next_due_ns = self.next_due_ns.saturating_add(self.h_ns);
        row
    }

    /// The latest tick and its output.
    #[must_use]
    pub fn output(&self) -> Output {
        self.output
    }

    /// The second input and output of the latest tick; `None` if there are none.
    #[must_use]
    pub fn second(&self) -> Option<SecondRow> {
        self.second
    }

    /// The model that it steps.
    #[must_use]
    pub fn model(&self) -> &M {
        &self.model
    }
}

/// The whole plant's end, for one thread.
#[derive(Clone, Debug)]
pub struct PlantEnd<M = Stepper> {
    inbox: Inbox,
    process: Process<M>,
}

impl<M: Model> PlantEnd<M> {
    /// An end whose tick 0 is due at `start_ns`; see [`Process::new`].
    #[must_use]
    pub fn new(settings: &PlantSettings, model: M, start_ns: u64) -> Self {
        Self {
            inbox: Inbox::new(settings.late, model.inputs()),
            process: Process::new(settings, model, start_ns),
        }
    }

    /// When the next tick is due.
    #[must_use]
    pub fn next_due_ns(&self) -> u64 {
        self.process.next_due_ns()
    }

    /// When the next tick should happen; see [`Process::next_tick_ns`].
    #[must_use]
    pub fn next_tick_ns(&self) -> u64 {
        self.process.next_tick_ns()
    }

    /// Performs the next tick with the input that is held; see [`Process::tick`].
    #[inline]
    pub fn tick(&mut self, now_ns: u64) -> TickRow {
        self.process.tick(self.inbox.input(), now_ns)
    }

    /// The second input and output of the latest tick; see [`Process::second`].
    #[must_use]
    pub fn second(&self) -> Option<SecondRow> {
        self.process.second()
    }

    /// Takes a command; see [`Inbox::command`].
    #[inline]
    pub fn command(&mut self, mode: Mode, command: &Command, now_ns: u64) -> (ArrivalRow, Answer) {
        self.inbox
            .command(mode, &command.into(), self.process.output(), now_ns)
    }

    /// Reads the plant's state without a command.
    #[must_use]
    pub fn observe(&self, now_ns: u64) -> Observation {
        let Output { tick, y } = self.process.output();
        Observation {
            t_ns: now_ns,
            tick,
            y,
            u: self.inbox.input().u,
        }
    }
}
