//! Systems from files, and their laws as numbers.

mod described;
mod vectors;
