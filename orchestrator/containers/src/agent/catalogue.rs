//! The roles that an agent starts.
//!
//! Other commands of webloop cannot be reached over the network. A role gets its settings on its
//! standard input. They name no files, and the role itself checks them.

use plan::Client;

use crate::agent::refusal::Refusal;

/// The role that runs a program of somebody's own.
const OWN: &str = "program";

/// Finds a role by the name that `webloop serve` uses; refuses one that agents do not start.
pub(crate) fn role(asked: &str) -> Result<&'static str, Refusal> {
    let clients = Client::ALL.map(|client| client.spec().role);
    let mut roles = [&["plant"][..], &clients, &[OWN, "link", "ask", "hear"]].concat();
    roles.dedup();
    let known = roles.iter().copied().find(|role| *role == asked);
    known.ok_or_else(|| Refusal::Role(asked.chars().take(40).collect(), roles.join(", ")))
}

/// Whether to watch a role from outside while it runs. Plant, native controller and players record
/// themselves when they were held up, and a slow machine has no time to watch them as well.
pub(crate) fn is_watched(role: &str) -> bool {
    let mut clients = Client::ALL.into_iter().map(Client::spec);
    role == OWN || clients.any(|spec| spec.role == role && !spec.allowance.keeps_time)
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
