//! Time for a measured process: its clock, waiting for an instant on it, what the kernel grants for that, and rows
//! that hold no thread up. All ends, players and probes of a run have it from here.
//!
//! * [`now`]: the run's clock. It is `CLOCK_MONOTONIC`, which all processes and namespaces of one kernel share, so
//!   times of plant, controller and link can be compared.
//! * [`pacer`] and `alarm`: wait for a deadline on it, in a thread and in a task. How long before it a real-time
//!   thread wakes is learnt from how late its wakes are, by a [`guard`].
//! * `patience`: how long a connection waits for one thing after another.
//! * [`scheduling`]: requests the best scheduling that a thread can get, and returns what it got.
//! * [`limit`]: room for the sockets of many messages.
//! * `stop`: the signals that end a process in an orderly way.
//! * [`journal`]: rows from a measured thread to a file.
//!
//! `alarm`, `patience` and `stop` are for tasks, and need the feature `task`. What happens at a deadline, what a row
//! is and how a report puts what was granted are left to who uses this: it knows neither loops nor links. The only
//! `unsafe` is in `alarm`.

#[cfg(feature = "task")]
pub mod alarm;
pub mod guard;
pub mod journal;
pub mod limit;
pub mod now;
pub mod pacer;
#[cfg(feature = "task")]
pub mod patience;
pub mod scheduling;
#[cfg(feature = "task")]
pub mod stop;
