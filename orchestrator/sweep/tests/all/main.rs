//! Sweeps: their laws, what they find, and what is refused.

mod findings;
mod invalid;
mod laws;
mod summary;
mod wrong;
