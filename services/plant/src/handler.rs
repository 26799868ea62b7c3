//! The state with which requests are handled; [`crate::route`] decides what each gets.

use std::{cell::OnceCell, collections::BTreeMap};

use clock::journal::Recorder;
use endpoint::{ArrivalRow, Hosts, Inbox, Output, PlantSettings, Reference, Signals};
use hyper::body::Bytes;
use tokio::sync::watch;

use crate::{
    filer::Filer,
    latest::{Publisher, Reader},
    session::Control,
    ticker::{INPUT_WORDS, OUTPUT_WORDS, input_words, output},
};

/// The plant's state as owned by the HTTP thread.
pub(crate) struct Handler {
    pub(crate) settings: PlantSettings,
    /// The names that it answers to.
    pub(crate) hosts: Hosts,
    /// The law that a page with a session should follow.
    pub(crate) law: Option<serde_json::Value>,
    /// The reference that it should follow, if that moves.
    pub(crate) reference: Option<Reference>,
    /// How many inputs and outputs it has.
    pub(crate) signals: [usize; 2],
    /// The description of its routes, once somebody has asked for it.
    pub(crate) description: OnceCell<Bytes>,
    pub(crate) inbox: Inbox,
    pub(crate) input: Publisher<INPUT_WORDS>,
    pub(crate) output: Reader<OUTPUT_WORDS>,
    pub(crate) rows: Recorder<ArrivalRow>,
    /// How many requests and commands were refused, by kind.
    pub(crate) refusals: BTreeMap<&'static str, u64>,
    /// The output at rest, and whether the model can return to it.
    pub(crate) at_rest: Signals,
    pub(crate) can_reset: bool,
    /// How often the model was to do so.
    pub(crate) resets: u64,
    pub(crate) control: Control,
    pub(crate) filer: Filer,
    /// The latest session that has ended, for its sockets.
    pub(crate) over: watch::Sender<u64>,
}

impl Handler {
    /// Counts a refusal.
    pub(crate) fn refuse(&mut self, kind: &'static str) {
        *self.refusals.entry(kind).or_default() += 1;
    }

    /// Passes on the input that is held.
    pub(crate) fn publish(&mut self) {
        self.input
            .publish(input_words(self.inbox.input(), self.resets));
    }

    /// The latest output. Until the tick after a reset it is that at rest.
    pub(crate) fn output(&self) -> Output {
        let (latest, resets) = output(self.output.read());
        if resets == self.resets {
            return latest;
        }
        Output {
            y: self.at_rest,
            u_applied: latest.u_applied.map(|_| 0.0),
            is_safe: false,
            ..latest
        }
    }
}
