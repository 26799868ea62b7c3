//! Figures: those that a person has looked at, and what holds for all.

mod golden;
mod laws;
mod map;
mod png;
