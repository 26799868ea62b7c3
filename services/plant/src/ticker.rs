//! The thread that steps the model at its deadlines.
//!
//! Between two ticks it only sleeps (and with real-time scheduling spins for the last moment). A tick reads
//! the input, steps, publishes the output and passes on a row, without allocating, locking, logging or
//! entering the kernel, unless its model does: a program is another process. Late ticks follow at once, so
//! that simulated time stays at real time.

use std::{
    io,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
};

use clock::{journal::Recorder, now::now_ns, pacer::Pacer, scheduling::Granted};
use endpoint::{Input, Model, Output, Policy, Process, SecondRow, Signals, TickRow};
use tokio::sync::oneshot;

use crate::latest::{Publisher, Reader};

/// Below most kernel threads, above all other threads of a run.
const FIFO_PRIORITY: u8 = 50;

/// Longest sleep, so that a plant with a long h still stops soon.
const NAP_NS: u64 = 50_000_000;

/// How many words the threads share of an input, and of an output.
pub(crate) const INPUT_WORDS: usize = 7;
pub(crate) const OUTPUT_WORDS: usize = 10;

/// An input in the form that the threads share, and how often the model was to be reset.
pub(crate) fn input_words(input: Input, resets: u64) -> [u64; INPUT_WORDS] {
    let [first, second, count] = words(input.u);
    [
        first,
        second,
        count,
        input.seq.unwrap_or_default(),
        u64::from(input.seq.is_some()),
        input.t_ns,
        resets,
    ]
}

fn input([first, second, count, seq, any, t_ns, resets]: [u64; INPUT_WORDS]) -> (Input, u64) {
    let input = Input {
        u: signals([first, second, count]),
        seq: (any != 0).then_some(seq),
        t_ns,
    };
    (input, resets)
}

/// An output in the form that the threads share, and how often the model was reset before.
pub(crate) fn output_words(output: Output, resets: u64) -> [u64; OUTPUT_WORDS] {
    let [y0, y1, outputs] = words(output.y);
    let [u0, u1, inputs] = words(output.u_applied);
    let is_safe = u64::from(output.is_safe);
    let Output { tick, trips, .. } = output;
    [
        tick, y0, y1, outputs, u0, u1, inputs, is_safe, trips, resets,
    ]
}

pub(crate) fn output(words: [u64; OUTPUT_WORDS]) -> (Output, u64) {
    let [
        tick,
        y0,
        y1,
        outputs,
        u0,
        u1,
        inputs,
        is_safe,
        trips,
        resets,
    ] = words;
    let output = Output {
        tick,
        y: signals([y0, y1, outputs]),
        u_applied: signals([u0, u1, inputs]),
        is_safe: is_safe != 0,
        trips,
    };
    (output, resets)
}

fn words(signals: Signals) -> [u64; 3] {
    let second = signals.second.unwrap_or_default();
    [
        signals.first.to_bits(),
        second.to_bits(),
        signals.count() as u64,
    ]
}

fn signals([first, second, count]: [u64; 3]) -> Signals {
    Signals {
        first: f64::from_bits(first),
        second: (count > 1).then_some(f64::from_bits(second)),
    }
}

/// The data that the thread needs.
pub(crate) struct Ticker {
    pub(crate) process: Process<Box<dyn Model + Send>>,
    pub(crate) h_ns: u64,
    pub(crate) input: Reader<INPUT_WORDS>,
    pub(crate) output: Publisher<OUTPUT_WORDS>,
    pub(crate) rows: Recorder<TickRow>,
    /// Of the second input and output, if there is one.
    pub(crate) second: Option<Recorder<SecondRow>>,
    pub(crate) scheduling: Policy,
}

/// The result of the thread.
pub(crate) struct Ticked {
    pub(crate) ticks: u64,
    pub(crate) missed: u64,
    /// How often the watchdog tripped.
    pub(crate) trips: u64,
    pub(crate) rows: Recorder<TickRow>,
    pub(crate) second: Option<Recorder<SecondRow>>,
    pub(crate) granted: Granted,
}

/// The running thread.
pub(crate) struct Running {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Ticked>,
    /// Completes when the thread ends, for whatever reason.
    pub(crate) ended: oneshot::Receiver<()>,
}

impl Ticker {
    pub(crate) fn start(self) -> io::Result<Running> {
        let stop = Arc::new(AtomicBool::new(false));
        let (alive, ended) = oneshot::channel();
        let thread = thread::Builder::new().name("ticker".to_owned()).spawn({
            let stop = Arc::clone(&stop);
            move || {
                // Dropped at the end of this closure, also after a panic.
                let _alive: oneshot::Sender<()> = alive;
                self.run(&stop)
            }
        })?;
        Ok(Running {
            stop,
            thread,
            ended,
        })
    }

    fn run(mut self, stop: &AtomicBool) -> Ticked {
        let granted = clock::scheduling::ask(self.scheduling.priority(FIFO_PRIORITY));
        let mut pacer = Pacer::new(&granted);
        let (mut held, mut resets) = input(self.input.read());
        let (mut ticks, mut missed) = (0, 0);
        loop {
            let (due_ns, at_ns) = (self.process.next_due_ns(), self.process.next_tick_ns());
            pacer.sleep_until(at_ns.min(now_ns().saturating_add(NAP_NS)));
            if stop.load(Ordering::Relaxed) {
                return self.ended(ticks, missed, granted);
            }
            let tick_ns = now_ns();
            if tick_ns < at_ns {
                continue;
            }
            if let Some(words) = self.input.try_read() {
                let asked;
                (held, asked) = input(words);
                if asked != resets {
                    self.process.reset();
                    resets = asked;
                }
            }
            // Between the two looks other threads may have run. A tick that has a command took place after it came.
            let row = self.process.tick(held, tick_ns.max(held.t_ns));
            // Ending early is an error, whose cause the model's owner knows.
            let is_broken = self.process.model().is_broken();
            if is_broken {
                return self.ended(ticks, missed, granted);
            }
            self.output
                .publish(output_words(self.process.output(), resets));
            self.rows.record(row);
            if let (Some(rows), Some(row)) = (&mut self.second, self.process.second()) {
                rows.record(row);
            }
            ticks += 1;
            missed += u64::from(tick_ns - due_ns >= self.h_ns);
        }
    }

    fn ended(self, ticks: u64, missed: u64, granted: Granted) -> Ticked {
        Ticked {
            ticks,
            missed,
            trips: self.process.output().trips,
            rows: self.rows,
            second: self.second,
            granted,
        }
    }
}

impl Running {
    /// Stops the thread; `None` if it has panicked.
    pub(crate) fn stop(self) -> Option<Ticked> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().ok()
    }
}
