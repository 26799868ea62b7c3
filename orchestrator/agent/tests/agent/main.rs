//! An agent over real sockets, with a stand-in for the roles: real processes, no loop.
#![allow(clippy::unwrap_used)]

mod endings;
mod follower;
mod hostile;
mod remote;
mod roles;
mod routes;
mod served;
