//! The commands as processes, on folders and files: no namespaces, no sockets, no waiting.

mod action;
mod architecture;
mod book;
mod collect;
mod compare;
mod escape;
mod falsified;
mod gate;
mod report;
mod simulated;
mod sweep;
mod transcripts;
