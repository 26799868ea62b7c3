//! An agent over real sockets, with a stand-in for the roles: real processes, no loop.
// `--nocapture` prints what docs/reliability.md quotes.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod endings;
mod follower;
mod hostile;
mod remote;
mod roles;
mod routes;
mod served;
