//! The two directions of a link, which are always told apart.

/// A direction of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// From controller to plant: the paper's `tau_ca`.
    Up,
    /// From plant to controller: the paper's `tau_sc`.
    Down,
}

impl std::fmt::Display for Way {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Way::Up => "up",
            Way::Down => "down",
        })
    }
}
