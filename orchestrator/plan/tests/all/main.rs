//! Experiments and systems as a user writes them.

mod experiments;
mod systems;
