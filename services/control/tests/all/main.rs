//! The laws of control theory, and agreement with the reference implementations.

mod design;
mod law;
mod laws;
mod reference;
