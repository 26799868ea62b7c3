//! The commands, one file each: what `webloop NAME` does, in terms of the other crates.

pub(crate) mod agent;
pub(crate) mod agree;
pub(crate) mod attempt;
pub(crate) mod calibrate;
pub(crate) mod client;
pub(crate) mod collect;
pub(crate) mod compare;
pub(crate) mod conform;
pub(crate) mod doctor;
pub(crate) mod echo;
pub(crate) mod gate;
pub(crate) mod gc;
pub(crate) mod link;
pub(crate) mod margin;
pub(crate) mod matrix;
pub(crate) mod packaging;
pub(crate) mod play;
pub(crate) mod probe;
pub(crate) mod program;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod run_cell;
pub(crate) mod serve;
pub(crate) mod show;
pub(crate) mod sweep;
pub(crate) mod system;
