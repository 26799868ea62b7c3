//! Being told to end, by SIGTERM or SIGINT: a flag that the commands look at.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::register;

use crate::exit::Exit;

/// How long an orchestrator that was told to end may go on: agents that are well need a third of
/// a second to flush their rows, and a container is to be gone within two.
const GIVE_UP_AFTER: Duration = Duration::from_millis(1_600);

/// How often the flag is looked at.
const POLL: Duration = Duration::from_millis(50);

/// A flag that either signal sets, from now on.
pub(crate) fn told_to_end() -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGINT] {
        register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// Ends this process some time after `stop` is set, whatever it waits for: of agents that were
/// told to end as well, each would have to be given up by itself. What has been copied is on disk.
pub(crate) fn give_up_soon_after(stop: &Arc<AtomicBool>) -> io::Result<()> {
    let stop = Arc::clone(stop);
    thread::Builder::new()
        .name("give-up".to_owned())
        .spawn(move || {
            while !stop.load(Ordering::Relaxed) {
                thread::sleep(POLL);
            }
            thread::sleep(GIVE_UP_AFTER);
            eprintln!("webloop: interrupted; the agents do not answer");
            std::process::exit(Exit::Interrupted as i32);
        })
        .map(drop)
}
