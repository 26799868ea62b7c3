//! The load that a fault lays on the machine: threads of this process that compute without end, as ordinary programs
//! of a desktop do. They have no priority, so what runs in real time runs before them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

/// Threads that compute until this is dropped.
pub(super) struct Busywork {
    is_over: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Busywork {
    /// Starts so many.
    pub(super) fn start(threads: u16) -> Busywork {
        let is_over = Arc::new(AtomicBool::new(false));
        let start = |_| {
            let is_over = Arc::clone(&is_over);
            thread::spawn(move || {
                while !is_over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            })
        };
        Busywork {
            threads: (0..threads).map(start).collect(),
            is_over,
        }
    }
}

impl Drop for Busywork {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // It does nothing that could fail.
            let _ = thread.join();
        }
    }
}
