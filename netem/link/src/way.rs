//! The two directions of a link, which are always told apart.

/// A direction of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// From controller to plant: the paper's `tau_ca`.
    Up,
    /// From plant to controller: the paper's `tau_sc`.
    Down,
}
