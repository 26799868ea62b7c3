//! The state with which requests are handled; [`crate::route`] decides what each gets.

use endpoint::{ArrivalRow, Inbox, PlantSettings, Reference};
use journal::Recorder;
use tokio::sync::watch;

use crate::{
    filer::Filer,
    latest::{Publisher, Reader},
    session::Control,
    ticker::{INPUT_WORDS, OUTPUT_WORDS},
};

/// The plant's state as owned by the HTTP thread.
pub(crate) struct Handler {
    pub(crate) settings: PlantSettings,
    /// The law that a page with a session should follow.
    pub(crate) law: Option<serde_json::Value>,
    /// The reference that it should follow, if that moves.
    pub(crate) reference: Option<Reference>,
    pub(crate) inbox: Inbox,
    pub(crate) input: Publisher<INPUT_WORDS>,
    pub(crate) output: Reader<OUTPUT_WORDS>,
    pub(crate) rows: Recorder<ArrivalRow>,
    pub(crate) refused: u64,
    pub(crate) control: Control,
    pub(crate) filer: Filer,
    /// The latest session that has ended, for its sockets.
    pub(crate) over: watch::Sender<u64>,
}
