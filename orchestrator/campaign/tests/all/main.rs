//! Sweeps: their laws, what they find, and how that is printed and drawn.

mod findings;
mod lab;
mod laws;
mod summary;
