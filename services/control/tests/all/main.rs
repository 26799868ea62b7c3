//! The laws of control theory, and agreement with the reference implementations.

mod aged;
mod border;
mod design;
mod drawn;
mod law;
mod laws;
mod reference;
mod table;
mod wide;
