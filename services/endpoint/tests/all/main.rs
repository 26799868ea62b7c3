//! Both ends of the loop: their laws, their messages, the plant's safety, and the vectors that every language has to
//! meet.

// `--nocapture` prints what docs/reliability.md quotes.
#![allow(clippy::print_stdout)]

mod age;
mod laws;
mod message;
mod row;
mod safe;
mod vectors;
