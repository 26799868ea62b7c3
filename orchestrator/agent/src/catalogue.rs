//! The roles that an agent starts.
//!
//! Other commands of webloop cannot be reached over the network. A role gets its
//! settings on its standard input, and they name no file; what they may be is checked by the role itself.

use plan::Client;

use crate::refusal::Refusal;

/// The role by its name, as `webloop serve` calls it, if it is one that an agent starts.
pub(crate) fn role(asked: &str) -> Result<&'static str, Refusal> {
    let clients = Client::ALL.map(|client| client.spec().role);
    let mut roles = [&["plant"][..], &clients, &["link", "ask", "hear"]].concat();
    roles.dedup();
    let known = roles.iter().copied().find(|role| *role == asked);
    known.ok_or_else(|| Refusal::Role(asked.chars().take(40).collect(), roles.join(", ")))
}

/// Whether a role is looked at from outside while it runs. Plant, native controller and players write
/// down themselves when they were held up, and a slow machine has no time for more than it needs.
pub(crate) fn is_watched(role: &str) -> bool {
    let mut clients = Client::ALL.into_iter().map(Client::spec);
    clients.any(|spec| spec.role == role && !spec.allowance.keeps_time)
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
