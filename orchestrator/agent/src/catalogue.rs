//! The roles that an agent starts.
//!
//! What is not listed cannot be reached over the network: no other command of webloop. A role is told its
//! settings on its standard input, and they name no file; what they may be is checked by the role itself.

use crate::refusal::Refusal;

/// Each role, as `webloop serve` calls it.
const ROLES: [&str; 7] = [
    "plant",
    "controller",
    "python",
    "browser",
    "link",
    "ask",
    "hear",
];

/// The role by its name, if it is one that an agent starts.
pub(crate) fn role(asked: &str) -> Result<&'static str, Refusal> {
    let known = ROLES.into_iter().find(|role| *role == asked);
    known.ok_or_else(|| Refusal::Role(asked.chars().take(40).collect(), ROLES.join(", ")))
}

/// Whether a role is looked at from outside while it runs. Plant, native controller and players write
/// down themselves when they were held up, and a slow machine has no time for more than it needs.
pub(crate) fn is_watched(role: &str) -> bool {
    matches!(role, "python" | "browser")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_listed_is_refused() {
        for asked in ["agent", "run", "--help", "", "plant --out=/etc"] {
            assert!(role(asked).is_err(), "{asked}");
        }
        assert_eq!(role("hear").ok(), Some("hear"));
    }
}
