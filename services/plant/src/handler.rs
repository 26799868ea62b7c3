//! What requests are dealt with by; what each gets is in [`crate::route`].

use endpoint::{ArrivalRow, Inbox, PlantSettings};
use journal::Recorder;
use tokio::sync::watch;

use crate::{
    filer::Filer,
    latest::{Publisher, Reader},
    session::Control,
};

/// Where requests are dealt with: the plant's state as the HTTP thread owns it.
pub(crate) struct Handler {
    pub(crate) settings: PlantSettings,
    /// What a page that is granted a session is to follow.
    pub(crate) law: Option<serde_json::Value>,
    pub(crate) inbox: Inbox,
    pub(crate) input: Publisher<4>,
    pub(crate) output: Reader<2>,
    pub(crate) rows: Recorder<ArrivalRow>,
    pub(crate) refused: u64,
    pub(crate) control: Control,
    pub(crate) filer: Filer,
    /// The latest session that is over, for the sockets of it.
    pub(crate) over: watch::Sender<u64>,
}
