//! The model of links: its laws, the profiles that are built in, and what tc is told.

mod faults;
mod laws;
mod lint;
mod profiles;
mod staircase;
mod table2;
mod trace;
