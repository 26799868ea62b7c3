//! Real browsers as controllers.
//!
//! * [`visit()`], [`visit_until`]: start a browser at the plant's page, watch it from outside, and name
//!   every ending; [`Config`] in, [`endpoint::report::Visit`] out.
//! * [`found`]: the browser that this machine has.
//! * `engine`, `argument`, `preference`: the browsers, and what each is started with.
//! * `attempt`: one start of a browser.
//! * `profile`, `process`, `family`, `words`, `sandbox`: its files and processes.
//! * [`page`]: the page's files, which the plant serves.
//! * `address`, `clock`, `plant`, `watch`: the page, and what the plant reports about it.
//!
//! Nothing controls the browser while it runs: it opens one address, and the page there does the
//! rest. The page itself is not in this crate's Rust code.
#![forbid(unsafe_code)]

mod address;
mod argument;
mod attempt;
mod clock;
mod config;
mod engine;
mod family;
pub mod page;
mod plant;
mod preference;
mod process;
mod profile;
mod sandbox;
mod visit;
mod watch;
mod words;

pub use config::{Config, Leash, Limits, VisitError};
pub use endpoint::report::{Confinement, Engine, Version};
pub use engine::{Missing, found};
pub use visit::{visit, visit_until};
