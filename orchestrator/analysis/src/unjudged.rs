//! What could not be judged of runs, in a line for tables and pages: a program of one's own that does not say when it
//! sends, or what it received, leaves a part of its link to its word.

use plan::Client;

use crate::campaign::Run;
use crate::layout::grouped;

/// A client, and what could not be judged of a run of it.
pub type Unjudged = (Client, Vec<&'static str>);

/// What could not be judged of a run; nothing where there is no manifest.
#[must_use]
pub fn of(run: &Run) -> Unjudged {
    let messages = run.manifest.as_ref().and_then(|of| of.messages.as_ref());
    let Some(messages) = messages else {
        return (run.cell.client, Vec::new());
    };
    (run.cell.client, messages.unknown())
}

/// `Not judged of mine: the way down, since it writes no messages.csv.` Clients of which the same is unknown are named
/// together. `None` if all was judged.
#[must_use]
pub fn sentence<'a>(all: impl IntoIterator<Item = &'a Unjudged>) -> Option<String> {
    let known = all.into_iter().filter(|(_, unknown)| !unknown.is_empty());
    let parts = grouped(known, |(_, unknown)| unknown.join("; "));
    let words = parts.into_iter().map(|(unknown, of)| {
        let clients = grouped(of, |(client, _)| *client);
        let names: Vec<String> = clients
            .iter()
            .map(|(client, _)| client.to_string())
            .collect();
        format!("Not judged of {}: {unknown}.", names.join(", "))
    });
    let words: Vec<String> = words.collect();
    (!words.is_empty()).then(|| words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_leaves_the_same_unknown_is_named_once_and_who_leaves_nothing_is_not() {
        let down = "the way down, since it writes no messages.csv";
        let all = [
            (Client::Native, vec![]),
            (Client::Python, vec![down]),
            (Client::Python, vec![down]),
            (Client::Firefox, vec![down]),
        ];
        assert_eq!(
            sentence(&all).as_deref(),
            Some("Not judged of python, firefox: the way down, since it writes no messages.csv.")
        );
        assert_eq!(sentence(&all[..1]), None);
    }
}
