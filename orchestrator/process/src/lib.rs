//! Starts processes and watches them: webloop's own roles, and programs of somebody's own.
//!
//! * [`Role`] and [`spawn`]: a role as a child process that cannot outlive its parent. [`Seen`] is
//!   what it looked like from outside: stopped, running, waiting for a processor.
//! * [`program`]: a controller of somebody's own, supervised; [`plant`]: a plant of somebody's own, stepped;
//!   [`first`] is the first process of their PID namespace, and [`Hidden`] what they do not see.
//!
//! The caller decides what they do, and when. Not here: processes in other containers, which `containers` reaches.

mod error;
mod exit;
pub mod first;
mod freezer;
mod keeper;
mod look;
mod lookout;
pub mod plant;
pub mod program;
mod python_path;
mod role;
mod shelter;
pub mod spawn;

pub use error::Error;
pub use exit::{UNSUPPORTED, exit_code};
pub use freezer::Stop;
pub use look::{Strain, busy_ns, own_strain, stolen_ns};
pub use lookout::Seen;
pub use role::{Launch, POLL, READY_WITHIN, Role, SECRET, STOP_WITHIN, last_words};
pub use shelter::Hidden;
