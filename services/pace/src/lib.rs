//! Time for the two ends of a real run, and the scheduling that the kernel grants them.
//!
//! * [`now_ns`]: the run's clock. It is `CLOCK_MONOTONIC`, which all processes and namespaces of one
//!   kernel share, so times of plant and controller can be compared.
//! * [`Pacer`] and [`Alarm`]: wait for a deadline on it, in a thread and in a task. How long before it a
//!   real-time thread wakes is learnt from how late its wakes are.
//! * [`Patience`]: how long a connection waits for one thing after another.
//! * [`ask`]: requests the best scheduling that a thread can get, and returns what it got, for the manifest.
//! * [`raise_open_files`]: room for the sockets of many messages.
//! * [`told_to_end`]: the signals that end a process in an orderly way.
//!
//! The crate `endpoint` decides what happens at a deadline. The only `unsafe` is in `alarm`.

mod alarm;
mod clock;
mod guard;
mod limit;
mod patience;
mod scheduling;
mod stop;

pub use alarm::Alarm;
pub use clock::{Pacer, now_ns, timespec};
pub use limit::raise_open_files;
pub use patience::Patience;
pub use scheduling::ask;
pub use stop::told_to_end;
