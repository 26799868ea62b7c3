//! What people write into webloop's files and on its command line, and what they are told when it is wrong.
//!
//! - [`Diagnostic`]: what is wrong with a file, where, and what to do; [`TomlText`] is the text that it is about.
//!   `slip` says in plain words what serde has against a text.
//! - [`duration_ns`], [`share`], [`rate_bps`]: the one grammar of times, shares and rates. [`duration_text`] and
//!   [`span_text`] write times.
//! - [`is_name`]: names of links, systems, experiments and programs. [`Whole`]: a whole number in a range.
//! - [`or_nearest`]: the name that somebody may have meant.
//! - [`counted`]: `1 run`, `2 runs`; [`one_of`]: `open or closed`. [`significant`]: a number to so many digits.
//! - [`plain()`], [`excerpt`]: a text from outside, made harmless where it is shown.
//! - [`column`](mod@column): the columns of a table, declared once, and how its rows are written and read.
//!
//! What the words of a setting mean is elsewhere, and so are files, which the caller reads.
#![forbid(unsafe_code)]

pub mod column;
mod diagnostic;
mod digits;
mod duration;
mod field;
mod list;
mod name;
mod nearest;
mod plain;
mod plural;
mod quantity;
mod sentence;
mod slip;
mod span;
mod whole;

pub use diagnostic::{Diagnostic, Severity, TomlText};
pub use digits::{decimals, significant};
pub use duration::{duration_ns, exact_ns};
pub use list::one_of;
pub use name::{is_device, is_name, is_plain};
pub use nearest::{nearest, or_nearest};
pub use plain::{excerpt, excerpt_of_line, is_active, plain};
pub use plural::counted;
pub use quantity::{Flaw, InvalidQuantity, rate_bps, share};
pub use sentence::sentence;
pub use span::{DAY_NS, MINUTE_NS, WEEK_NS, duration_text, span_text};
pub use whole::{NotWhole, Whole};
