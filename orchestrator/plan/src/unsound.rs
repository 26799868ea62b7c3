//! What is wrong with a plan that no experiment can produce, each with the words that its reader sees.
//!
//! `sound` and `faults` find it; what is wrong with a fault by itself is in `bad_fault`.

use crate::system::Unfit;

use crate::bad_fault::BadFault;
use crate::end_fault::End;
use crate::limit::{CELLS_MAX, ID_MAX, TOGETHER_MAX};

/// Why a text is not a plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotAPlan {
    /// It is not the JSON of one.
    #[error("{0}")]
    Json(String),
    /// It is one of another webloop.
    #[error("this plan has format version {found}, and this webloop reads version {known}")]
    Version {
        /// The version that it says.
        found: u32,
        /// The version that is read here.
        known: u32,
    },
    /// No experiment can produce it.
    #[error(transparent)]
    Unsound(#[from] Unsound),
}

/// What is wrong with a plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unsound {
    /// The experiment's name cannot be a folder's.
    #[error(
        "`{0}` is not a valid name of a results folder; use up to 40 of a-z, 0-9 and -, a letter or digit first"
    )]
    Name(String),
    /// It has too many cells.
    #[error("it has more than {CELLS_MAX} cells")]
    Cells,
    /// It has both cells and a sweep.
    #[error("it has cells beside its sweep")]
    CellsBesideSweep,
    /// Its sweep cannot be run.
    #[error("its sweep cannot be run: {0}")]
    Sweep(String),
    /// One of its cells is wrong.
    #[error("cell {index}, {}: {problem}", .id.escape_debug())]
    Cell {
        /// The cell's index.
        index: usize,
        /// Its id, as it is written.
        id: String,
        /// What is wrong with it.
        problem: UnsoundCell,
    },
    /// What one of its cells names is wrong.
    #[error("cell {index}: {problem}")]
    Named {
        /// The cell's index.
        index: usize,
        /// What is wrong.
        problem: UnsoundName,
    },
    /// A cell's id is not made of its settings.
    #[error(
        "cell {index}, {id}: this id is not that of such a cell; make the plan anew with `webloop matrix`"
    )]
    Unidentified {
        /// The cell's index.
        index: usize,
        /// Its id.
        id: String,
    },
    /// Its clauses are of a cell that is not there.
    #[error("it expects something of cell {0}, which it does not have")]
    Expected(usize),
    /// A link's profile cannot be played.
    #[error("its profile `{name}` cannot be played: {problem}")]
    Profile {
        /// The profile's name in the plan.
        name: String,
        /// The first of its faults.
        problem: String,
    },
    /// A profile, a system or a fault has another name than the plan has it by.
    #[error("its {what} `{name}` calls itself `{own}`")]
    Called {
        /// What it is.
        what: &'static str,
        /// Its name in the plan.
        name: String,
        /// Its name by itself.
        own: String,
    },
    /// A trace has a name that a run's own files have.
    #[error(
        "its profile `{name}` has a trace `{trace}`, a name that a run's own files may have; call it something \
         like {name}-trace.csv"
    )]
    Trace {
        /// The profile's name.
        name: String,
        /// The trace's.
        trace: String,
    },
    /// Two traces have one name where upper and lower case are the same.
    #[error(
        "its profile `{name}` has two traces whose names differ from `{trace}` in upper and lower case only"
    )]
    Twins {
        /// The profile's name.
        name: String,
        /// The second of the traces.
        trace: String,
    },
    /// A system's text cannot be read.
    #[error("its system `{name}`, {fault}")]
    System {
        /// The system's name in the plan.
        name: String,
        /// What is wrong with it, after its line.
        fault: String,
    },
    /// A system's plant is a program, and the plan has none for it, or the other way round.
    #[error("its system `{0}` and its `plants` do not agree on whether the plant is a program")]
    Plant(String),
    /// A program has no command.
    #[error("its program `{0}` has nothing to `run`")]
    Program(String),
    /// A fault is wrong.
    #[error("its fault `{name}`: {problem}")]
    Fault {
        /// The fault's name in the plan.
        name: String,
        /// What is wrong with it.
        problem: BadFault,
    },
}

/// What is wrong with what a cell names in its plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UnsoundName {
    /// Its system is not there, or cannot be read.
    #[error(transparent)]
    System(#[from] NoSystem),
    /// Its system cannot run at its sample time.
    #[error("{0}")]
    Unfit(String),
    /// Its program is not there.
    #[error("there is no program `{0}`")]
    Program(String),
    /// Its fault is not there.
    #[error("there is no fault `{0}`")]
    Fault(String),
    /// Its fault is one of a link, and it has none.
    #[error("the fault `{fault}` needs a link, and on {topology} there is none")]
    Linkless {
        /// The fault's name.
        fault: String,
        /// The topology's.
        topology: String,
    },
    /// Two events of its fault hit an end at a time.
    #[error(
        "its fault hits the {end} at {at_s} s, while an earlier event still does: write them apart"
    )]
    Overlap {
        /// The end that is hit.
        end: End,
        /// When the later one begins, s.
        at_s: f64,
    },
    /// An event of its fault outlasts the loop.
    #[error(
        "its fault hits the {end} at {at_s} s until {until_s} s, and the loop ends at {ends_s} s: let it be over \
         before"
    )]
    Outlasts {
        /// The end that is hit.
        end: End,
        /// When the event begins, s.
        at_s: f64,
        /// When it ends, s.
        until_s: f64,
        /// When the loop ends, s.
        ends_s: f64,
    },
}

impl From<Unfit> for UnsoundName {
    fn from(unfit: Unfit) -> Self {
        Self::Unfit(unfit.to_string())
    }
}

/// What is wrong with a cell by itself.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UnsoundCell {
    /// Another cell has its folder.
    #[error("another cell has the same id, so the same folder")]
    SameId,
    /// Another cell has its index.
    #[error("another cell has this index")]
    SameIndex,
    /// Its id cannot be a folder's name.
    #[error(
        "this id cannot name a folder; use up to {ID_MAX} of a-z, 0-9, `-` and `.`, and a letter or a digit at the \
         beginning"
    )]
    Id,
    /// Its link is not there.
    #[error("there is no profile `{}`", .0.escape_debug())]
    Profile(String),
    /// A time is out of range.
    #[error("{field} {ns} is not between 0 and a week")]
    Time {
        /// The time's name.
        field: &'static str,
        /// Its value, ns.
        ns: u64,
    },
    /// Its sample time is longer than its run.
    #[error("h = {0} is longer than the run")]
    SampleTime(endpoint::SampleTime),
    /// Its repeat is not counted from 1.
    #[error("repeat 0; repeats count from 1")]
    Repeat,
    /// Too many of it run at a time.
    #[error("together {0} is not between 1 and {TOGETHER_MAX}")]
    Together(u16),
    /// Its link's seed does not follow from the plan's.
    #[error("link_seed {found} is not that of the plan's seed {seed}, which is {due}")]
    Seed {
        /// The seed that it has.
        found: u64,
        /// The plan's seed.
        seed: u64,
        /// The seed that follows from it.
        due: u64,
    },
    /// A client without a page has one.
    #[error("only a browser has a page")]
    Page,
    /// A browser has no page.
    #[error("a browser has a page")]
    NoPage,
    /// A setting of its client or page is wrong.
    #[error("{0}")]
    Setting(String),
}

/// Why a plan has no system for a cell.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoSystem {
    /// It is not there.
    #[error("the plan has no system `{0}`")]
    Missing(String),
    /// Its text cannot be read.
    #[error("the plan's system `{name}`, {fault}")]
    Unread {
        /// The system's name.
        name: String,
        /// What is wrong with it, after its line.
        fault: String,
    },
}
