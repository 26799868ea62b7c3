//! The flag that SIGTERM and SIGINT set, and that commands check.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};

use crate::exit::Exit;

/// How long an orchestrator may go on after it was told to end: healthy agents need a third of a
/// second to flush their rows, and a container has to be gone within two.
const GIVE_UP_AFTER: Duration = Duration::from_millis(1_600);

/// How often to check the flag.
const POLL: Duration = Duration::from_millis(50);

/// Whether either signal ends this process at once.
static AT_ONCE: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Returns a flag that either signal sets from now on.
pub(crate) fn told_to_end() -> io::Result<Arc<AtomicBool>> {
    by_flag();
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGINT] {
        register_conditional_shutdown(signal, Exit::Interrupted as i32, Arc::clone(&AT_ONCE))?;
        register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// From now on either signal ends this process at once: what is still to come can be made again from what is on disk,
/// and takes long.
pub(crate) fn at_once() {
    AT_ONCE.store(true, Ordering::Relaxed);
}

/// From now on either signal only sets the flag again: what runs is to be ended first.
pub(crate) fn by_flag() {
    AT_ONCE.store(false, Ordering::Relaxed);
}

/// Ends this process some time after `stop` is set, whatever it waits for. If the agents were told
/// to end as well, waiting for each of them in turn would take too long. What has been copied is on
/// disk.
pub(crate) fn give_up_soon_after(stop: &Arc<AtomicBool>) -> io::Result<()> {
    let stop = Arc::clone(stop);
    thread::Builder::new()
        .name("give-up".to_owned())
        .spawn(move || {
            while !stop.load(Ordering::Relaxed) {
                thread::sleep(POLL);
            }
            thread::sleep(GIVE_UP_AFTER);
            say!("webloop: interrupted; the agents do not answer");
            std::process::exit(Exit::Interrupted as i32);
        })
        .map(drop)
}
