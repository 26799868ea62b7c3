//! Experiments and systems as a user writes them.

mod expect;
mod experiments;
mod sweep;
mod system;
mod systems;
mod wrong;
