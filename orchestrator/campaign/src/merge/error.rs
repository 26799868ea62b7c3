//! Why folders cannot be merged.

use std::io;
use std::path::PathBuf;

use plan::file_name::PLAN;

/// Why a step of copying failed.
pub(super) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why folders cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder has no plan, nor has any folder in it.
    #[error("{} is not a results folder and contains none: {PLAN} is missing", .0.display())]
    NoPlan(PathBuf),
    /// No folder was given.
    #[error("there is no folder to collect from")]
    Nothing,
    /// Two folders have different plans.
    #[error(
        "{} and {} have different plans: {difference}; collect folders of one plan only",
        first.display(), other.display()
    )]
    OtherPlan {
        /// A folder.
        first: PathBuf,
        /// The first folder that has another plan.
        other: PathBuf,
        /// How they differ.
        difference: String,
    },
    /// A plan is invalid.
    #[error("cannot use the plan {}: {problem}", path.display())]
    BadPlan {
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A plan cannot be read.
    #[error("cannot read {}: {problem}", path.display())]
    Unreadable {
        /// Its file.
        path: PathBuf,
        /// What the system said.
        problem: io::Error,
    },
    /// A folder's entries cannot be listed.
    #[error("cannot read the folder {}", path.display())]
    NotListed {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Two runs were made by different back-ends: they are two campaigns, whatever their plan.
    #[error(
        "{} was run by {first_backend}, and {} by {other_backend}; collect folders of one back-end \
         only. Nothing was copied", first.display(), other.display()
    )]
    OtherBackend {
        /// A run's folder.
        first: PathBuf,
        /// Its back-end.
        first_backend: String,
        /// The first run by another back-end.
        other: PathBuf,
        /// Its back-end.
        other_backend: String,
    },
    /// A cell has two different complete runs.
    #[error(
        "{} and {} are two different complete runs of one cell; leave one of them out, or move it \
         away. Nothing was copied", first.display(), other.display()
    )]
    Conflict {
        /// A run's folder.
        first: PathBuf,
        /// The other run's folder.
        other: PathBuf,
    },
    /// A cell cannot be copied.
    #[error("cannot copy {} to {}; run the same command again", from.display(), to.display())]
    NotCopied {
        /// The run's folder.
        from: PathBuf,
        /// Where it was to go.
        to: PathBuf,
        /// What went wrong.
        source: Cause,
    },
}

impl MergeError {
    /// Whether the given folders are at fault. Nothing was copied then.
    pub(crate) fn is_usage(&self) -> bool {
        !matches!(self, MergeError::NotCopied { .. })
    }
}
