//! Being told to end, by SIGTERM or SIGINT: a flag that the commands look at.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::register;

/// A flag that either signal sets, from now on.
pub(crate) fn told_to_end() -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGINT] {
        register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}
