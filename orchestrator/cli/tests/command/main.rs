//! The commands as processes, on folders and files: no namespaces, no sockets, no waiting.

// `--nocapture` prints what docs/reliability.md quotes.
#![allow(clippy::print_stdout)]

mod action;
mod again;
mod architecture;
mod book;
mod border;
mod collect;
mod compare;
mod console;
mod damaged;
mod disk;
mod ended;
mod escape;
mod falsified;
mod flipped;
mod gate;
mod power;
mod report;
mod resumed;
mod script;
mod simulated;
mod source;
mod sweep;
mod traced;
mod transcripts;
mod verdicts;
