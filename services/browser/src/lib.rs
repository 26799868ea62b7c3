//! Real browsers as controllers.
//!
//! * [`visit`], [`visit_until`]: start one at the plant's page, watch it from
//!   outside, and give each ending a name; [`Config`] in,
//!   [`endpoint::report::Visit`] out.
//! * [`found`]: which browser this machine has.
//! * `engine`, `argument`, `preference`: the browsers, and what each is started with.
//! * `attempt`: one start of a browser.
//! * `profile`, `process`, `family`, `words`, `sandbox`: one as files and processes.
//! * [`page`]: the page's files, which the plant serves.
//! * `address`, `clock`, `plant`, `watch`: the page, and what the plant says of it.
//!
//! Nothing drives the browser while it runs: it opens one address, and the page
//! there does the rest by itself. What the page does is not here.
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
