//! The commands as processes, on folders and files: no namespaces, no sockets, no waiting.

mod architecture;
mod book;
mod collect;
mod falsified;
mod report;
mod simulated;
mod sweep;
mod transcripts;
