//! The model of links: its laws, the profiles that are built in, what tc is told, and what vouches for a link.

mod echoes;
mod faults;
mod laws;
mod lint;
mod profiles;
mod staircase;
mod table2;
mod trace;
