//! How late a message was, within what is known of it: whether it opened its connection, and when its first packet
//! entered the link.

use crate::connecting::Connecting;

/// How late one message was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lateness {
    /// By no less than this, ms: the link was as slow as it was at any time at which the message may have met it, and
    /// its reader read it last of those that came together.
    pub(crate) least_ms: f64,
    /// By no more than this, ms: the link was as quick as it was at any such time.
    pub(crate) most_ms: f64,
    /// Whether that is late; see [`LATE_MS`](crate::limit::LATE_MS).
    pub(crate) is_late: bool,
    /// Whether it came as late as a resend.
    pub(crate) is_resent: bool,
}

/// A message of which rows do not tell whether it opened a connection, judged in both cases. `None` where there is an
/// excuse in that case.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Untold {
    pub(crate) kept: Option<Lateness>,
    pub(crate) opened: Option<Lateness>,
}

/// What each of these messages is judged by: the latest may have opened the connections that there were, as many as
/// there were, and the others had one. So nothing is held against a program that a connection of its own explains,
/// and no more is excused than was opened.
pub(crate) fn told(mut all: Vec<Untold>, connecting: Connecting) -> Vec<Lateness> {
    let least_ms = |one: &Untold| one.kept.map_or(f64::NEG_INFINITY, |kept| kept.least_ms);
    all.sort_by(|one, other| least_ms(other).total_cmp(&least_ms(one)));
    let most = connecting.most_untold(all.len());
    let (first, rest) = all.split_at(most);
    let opened = first.iter().filter_map(|one| match (one.kept, one.opened) {
        (Some(kept), Some(opened)) if opened.most_ms >= 0.0 => Some(Lateness {
            least_ms: opened.least_ms.min(kept.least_ms),
            ..opened
        }),
        // Quicker than a handshake: it had a connection, or waited for one that became free.
        _ => None,
    });
    let kept = rest.iter().filter_map(|one| one.kept);
    opened.chain(kept).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lateness(ms: f64) -> Lateness {
        Lateness {
            least_ms: ms,
            most_ms: ms,
            is_late: ms > 10.0,
            is_resent: ms > 150.0,
        }
    }

    /// Messages so late if they had a connection, over a link whose handshake takes 4 ms.
    fn messages(late_ms: &[f64]) -> Vec<Untold> {
        let one = |ms: &f64| Untold {
            kept: Some(lateness(*ms)),
            opened: Some(lateness(ms - 4.0)),
        };
        late_ms.iter().map(one).collect()
    }

    fn of(late_ms: &[f64], accepted: Option<u64>) -> Vec<f64> {
        let all = told(messages(late_ms), Connecting::Own { accepted });
        let mut all: Vec<f64> = all.iter().map(|one| one.least_ms).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    #[test]
    fn no_more_messages_are_excused_by_a_handshake_than_connections_were_opened() {
        let late_ms = [4.1, 0.1, 0.1, 9.0, 9.0];
        assert_eq!(of(&late_ms, Some(0)), [0.1, 0.1, 4.1, 9.0, 9.0]);
        assert_eq!(of(&late_ms, Some(1)), [0.1, 0.1, 4.1, 5.0, 9.0]);
        let all: Vec<f64> = of(&late_ms, Some(9));
        assert!(all.iter().all(|ms| *ms <= 5.0), "{all:?}");
        assert_eq!(of(&late_ms, None), all);
    }

    #[test]
    fn a_message_that_may_have_waited_for_a_free_connection_says_nothing() {
        assert_eq!(of(&[0.2, 0.3, 3.0], Some(1)), [0.2, 0.3]);
    }
}
