//! How large a plan may be.

/// Most cells that may run at a time, as for `--jobs`.
pub(crate) const TOGETHER_MAX: u16 = 64;

/// Most cells in one plan; the paper's whole matrix has 1142.
pub(crate) const CELLS_MAX: usize = 100_000;

/// Longest id, bytes: a file system allows 255, and a folder that is moved aside gets a suffix.
pub(crate) const ID_MAX: usize = 200;
