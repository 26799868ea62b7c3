//! Systems from files, and their laws as numbers.

mod systems;
mod vectors;
