//! The commands, one file each: what `webloop NAME` does, in terms of the other crates.

pub(crate) mod doctor;
pub(crate) mod link;
pub(crate) mod packaging;
pub(crate) mod probe;
pub(crate) mod run;
pub(crate) mod run_cell;
pub(crate) mod serve;
pub(crate) mod show;
