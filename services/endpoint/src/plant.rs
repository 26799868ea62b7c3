//! The plant's end: it holds the last input and steps the model every h.
//!
//! It has two parts, because in a real run two threads own them: the [`Inbox`] takes commands as they arrive
//! and gives the input that is held, the [`Process`] steps the model at its deadlines. [`PlantEnd`] is both
//! together, for virtual time and for the test vectors. The HTTP around it is elsewhere.

use std::net::IpAddr;

use control::{Signals, Stepper};

use crate::{
    age::{Ages, Stamped},
    hold::Hold,
    message::{Acknowledgement, Answer, Command, Observation, Request, State},
    model::Model,
    noise::TickNoise,
    plant_setting::PlantSettings,
    row::{ArrivalOutcome, ArrivalRow, SecondRow, TickRow},
    setting::{Late, Lease, Mode},
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
    /// The input of that tick, behind watchdog and actuator, or both of them.
    pub u_applied: Signals,
    /// Whether the watchdog acts.
    pub is_safe: bool,
    /// How often it has begun to act.
    pub trips: u64,
}

impl Output {
    /// What is told of it together with an input that is held.
    #[must_use]
    pub fn observed(self, input: Input, now_ns: u64) -> Observation {
        Observation {
            t_ns: now_ns,
            tick: self.tick,
            y: self.y,
            u: input.u,
            u_applied: self.u_applied,
            safe: self.is_safe,
            trips: self.trips,
        }
    }
}

/// Where commands arrive: numbers them, judges late ones, holds the input.
///
/// The age of a command is its sequence number. With [`Late::Drop`] all commands of a controller that
/// starts again from 0 are therefore stale, unless [`Inbox::welcome`] was called for it.
///
/// With `max_age` a command that is older is aged, as `age` tells it, whoever is welcome.
#[derive(Clone, Debug)]
pub struct Inbox {
    late: Late,
    ages: Option<Ages>,
    /// Since when the commands that are heard can have been sent, if that is known.
    since_ns: Option<u64>,
    input: Input,
    /// The newest command of this controller that was applied.
    newest: Option<u64>,
    arrivals: u64,
}

impl Inbox {
    /// An inbox that holds u = 0, for each of so many inputs.
    #[must_use]
    pub fn new(settings: &PlantSettings, inputs: usize) -> Self {
        Self {
            late: settings.late,
            ages: settings
                .max_age_ns
                .map(|max_age_ns| Ages::new(max_age_ns, settings.clock)),
            since_ns: None,
            input: Input {
                u: Signals::zeros(inputs),
                ..Input::default()
            },
            newest: None,
            arrivals: 0,
        }
    }

    /// Goes on with the numbers of an earlier inbox, which has had so many arrivals.
    #[must_use]
    pub fn resumed(self, arrivals: u64) -> Self {
        Self { arrivals, ..self }
    }

    /// Accepts another controller, whose commands count from 0. The input is held, and what is known of clocks
    /// stays: an old command is old for whomever it is.
    pub fn welcome(&mut self) {
        self.newest = None;
    }

    /// The next commands come from this address, whose clock is its own, or this machine's if it is loopback; and
    /// none of them was sent before `since_ns`, if a session says so.
    #[inline]
    pub fn hear(&mut self, address: IpAddr, since_ns: Option<u64>) {
        if let Some(ages) = &mut self.ages {
            ages.hear(address);
            self.since_ns = since_ns;
        }
    }

    /// Returns to the input that was held before the first command, and accepts any controller.
    pub fn reset(&mut self) {
        self.welcome();
        self.input = Input {
            u: self.input.u.map(|_| 0.0),
            ..Input::default()
        };
    }

    /// Learns from a command that was sent at `t_send_ns`, and tells whether it is too old; without a time it is.
    #[inline]
    fn ages(&mut self, t_send_ns: Option<u64>, now_ns: u64) -> bool {
        let since_ns = self.since_ns;
        let Some(ages) = &mut self.ages else {
            return false;
        };
        t_send_ns.is_none_or(|t_send_ns| {
            ages.refuses(Stamped {
                t_send_ns,
                now_ns,
                since_ns,
            })
        })
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
        let is_aged = mode == Mode::Closed && self.ages(t_send_ns, now_ns);
        let outcome = match (mode, self.late) {
            (Mode::Open, _) => ArrivalOutcome::Acknowledged,
            (Mode::Closed, Late::Drop) if overtaken => ArrivalOutcome::Stale,
            (Mode::Closed, _) if is_aged => ArrivalOutcome::Aged,
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
    /// When the command came after which the watchdog tripped last.
    tripped_ns: Option<u64>,
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
                y: model.at_rest(),
                u_applied: Signals::zeros(model.inputs()),
                ..Output::default()
            },
            tripped_ns: None,
            second: None,
            model,
        }
    }

    /// Goes on with the ticks of an earlier process, which was lost with its state: tick `k` is the next, due
    /// at start + k h.
    #[must_use]
    pub fn resumed(mut self, k: u64) -> Self {
        self.next_k = k;
        let since_start_ns = k.saturating_mul(self.h_ns);
        self.next_due_ns = self.next_due_ns.saturating_add(since_start_ns);
        // So that a controller does not take what it gets before that tick for older than what it has.
        self.output.tick = k.saturating_sub(1);
        self
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
        // Judged by the due time, so that a tick that is caught up is stepped like one on time. Before the
        // first command there is nothing to be silent about.
        let acted = input.seq.and_then(|_| {
            let silence_ns = self.next_due_ns.saturating_sub(input.t_ns);
            self.hold.acts(input.u, silence_ns)
        });
        let is_safe = acted.is_some();
        let asked = acted.unwrap_or(input.u);
        let y = self.model.step(asked, self.next_due_ns);
        let applied = self.model.applied().unwrap_or(asked);
        let trips = is_safe && self.tripped_ns.replace(input.t_ns) != Some(input.t_ns);
        self.output = Output {
            tick: k,
            y: self.model.measured(y),
            u_applied: applied,
            is_safe,
            trips: self.output.trips + u64::from(trips),
        };
        let row = TickRow {
            k,
            t_due_ns: self.next_due_ns,
            t_tick_ns: now_ns,
            u: input.u.first,
            y: y.first,
            seq: input.seq,
            u_applied: Some(applied.first),
        };
        let has_second = input.u.second.is_some() || y.second.is_some();
        self.second = has_second.then_some(SecondRow {
            k,
            u2: input.u.second,
            y2: y.second,
            u2_applied: applied.second,
        });
        self.next_k += 1;
        self.last_ns = now_ns;
        self.next_due_ns = self.next_due_ns.saturating_add(self.h_ns);
        row
    }

    /// Puts the model back into the state before the first step, if it can do that; returns whether. The ticks go
    /// on.
    pub fn reset(&mut self) -> bool {
        self.model.reset()
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

/// The whole plant's end, for one thread, with one controller.
#[derive(Clone, Debug)]
pub struct PlantEnd<M = Stepper> {
    inbox: Inbox,
    process: Process<M>,
    lease: Lease,
    /// When a command was last taken.
    taken_ns: u64,
}

impl<M: Model> PlantEnd<M> {
    /// An end whose tick 0 is due at `start_ns`; see [`Process::new`].
    #[must_use]
    pub fn new(settings: &PlantSettings, model: M, start_ns: u64) -> Self {
        Self {
            inbox: Inbox::new(settings, model.inputs()),
            process: Process::new(settings, model, start_ns),
            lease: settings.lease,
            taken_ns: 0,
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

    /// Takes a command; see [`Inbox::command`]. After a silence a lease by address is over, and begins anew.
    #[inline]
    pub fn command(&mut self, mode: Mode, command: &Command, now_ns: u64) -> (ArrivalRow, Answer) {
        let silent_ns = now_ns.saturating_sub(self.taken_ns);
        if silent_ns >= Lease::SILENCE_NS && self.lease == Lease::Address {
            self.inbox.welcome();
            self.taken_ns = now_ns;
        }
        let output = self.process.output();
        let (row, answer) = self.inbox.command(mode, &command.into(), output, now_ns);
        if matches!(
            row.outcome,
            ArrivalOutcome::Applied | ArrivalOutcome::Acknowledged
        ) {
            self.taken_ns = now_ns;
        }
        (row, answer)
    }

    /// Reads the plant's state without a command.
    #[must_use]
    pub fn observe(&self, now_ns: u64) -> Observation {
        self.process.output().observed(self.inbox.input(), now_ns)
    }
}
