//! A run of a controller of one's own: whether it kept the contract by what the plant saw of it, and its
//! messages, which the plant's rows have too.
//!
//! How its process did is its supervisor's to say, in `agent`.

use std::io::ErrorKind;
use std::path::Path;

use endpoint::{ArrivalRow, MessageOutcome, MessageRow, Mode};
use plan::{Cell, file_name};
use process::program::OWN;
use record::rows::all;
use record::{file, folder};

use crate::error::RunError;
use crate::report::Reports;

/// Messages beyond those due are a flood if there are more than this, and more than once again as many.
const FLOOD: u64 = 100;

/// No row of a message is longer, bytes.
const ROW_BYTES: u64 = 512;

/// The plant may refuse one message, and one more of so many.
const REFUSED_OF: u64 = 100;

/// One message may be sent again, and one more of so many; if more are, their numbers count something else.
const AGAIN_OF: u64 = 20;

/// Checks the messages of a run whose first was due at `start_ns`, and leaves them as `messages.csv`: the
/// controller's own rows if it left such a file, or else those that the plant saw.
pub(crate) fn settle(cell: &Cell, start_ns: u64, folder: &Path) -> Result<(), RunError> {
    let arrivals: Vec<ArrivalRow> = all(&folder.join(file_name::ARRIVALS))?;
    let refused = Reports::read(folder)
        .plant
        .map_or(0, |plant| plant.refused());
    if let Some(breach) = breach(cell, start_ns, &arrivals, refused) {
        return Err(RunError::role("controller", breach));
    }
    let (own, path) = (
        folder.join(OWN).join(file_name::MESSAGES),
        folder.join(file_name::MESSAGES),
    );
    let text = match left(&own, cell)? {
        Some(text) => text,
        None => text(&messages(cell, start_ns, &arrivals))
            .map_err(|problem| RunError::write(&path, problem))?,
    };
    Ok(folder::write(&path, &text)?)
}

/// The rows of messages that the controller left as `path`; `None` if it left none. They are a regular file, no link
/// to one, and no longer than the rows of as many messages as it may send.
fn left(path: &Path, cell: &Cell) -> Result<Option<Vec<u8>>, RunError> {
    let most_bytes = (2 * cell.due() + FLOOD + 1).saturating_mul(ROW_BYTES);
    let refuse = |problem: &dyn std::fmt::Display| {
        RunError::role(
            "controller",
            format!(
                "left {OWN}/{} that cannot be used: {problem}",
                file_name::MESSAGES
            ),
        )
    };
    let text = match file::text(path, most_bytes) {
        Ok(text) => text,
        Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok(None),
        Err(problem) => return Err(refuse(&problem)),
    };
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    for row in reader.deserialize::<MessageRow>() {
        row.map_err(|problem| refuse(&problem))?;
    }
    Ok(Some(text.into_bytes()))
}

/// How the messages break the contract, as the end of a sentence about the controller.
fn breach(cell: &Cell, start_ns: u64, arrivals: &[ArrivalRow], refused: u64) -> Option<String> {
    let (sent, due, h_ns) = (arrivals.len() as u64, cell.due(), cell.settings.h.ns());
    let Some(first) = arrivals.first() else {
        return Some(match refused {
            0 => "sent no message to the plant".to_owned(),
            _ => format!(
                "sent no message that the plant took; it refused {refused} requests (plant.log)"
            ),
        });
    };
    if first.t_arrive_ns + h_ns < start_ns {
        let early_ms = (start_ns - first.t_arrive_ns) as f64 * 1e-6;
        return Some(format!(
            "sent its first message {early_ms:.0} ms early; wait until WEBLOOP_START"
        ));
    }
    if sent > 2 * due + FLOOD {
        return Some(format!(
            "flooded the plant: {sent} messages, and {due} were due; send one every h"
        ));
    }
    if refused > 1 + (sent + refused) / REFUSED_OF {
        return Some(format!(
            "was refused {refused} times, beside {sent} messages that the plant took (plant.log)"
        ));
    }
    None
}

/// The messages as the plant saw them, and the deadlines without one.
///
/// They have the controller's numbers if these count its messages, or else those of their arrivals. A message that
/// was sent again under its number, since its connection broke, is one, which arrived when it first did.
fn messages(cell: &Cell, start_ns: u64, arrivals: &[ArrivalRow]) -> Vec<MessageRow> {
    let (due, h_ns) = (cell.due(), cell.settings.h.ns());
    let end = due.max(arrivals.len() as u64);
    let mut by_number: Vec<Option<&ArrivalRow>> = vec![None; end as usize];
    let mut again = 0;
    let are_inside = arrivals.iter().all(|row| {
        let place = by_number.get_mut(row.seq as usize);
        place.is_some_and(|place| {
            again += u64::from(place.is_some());
            place.get_or_insert(row);
            true
        })
    });
    if !are_inside || again > 1 + arrivals.len() as u64 / AGAIN_OF {
        by_number.fill(None);
        for (place, row) in by_number.iter_mut().zip(arrivals) {
            *place = Some(row);
        }
    }
    let is_closed = cell.settings.mode == Mode::Closed;
    let moving = cell.moving_reference();
    let r = |due_ns| {
        moving
            .as_ref()
            .map_or(cell.settings.r, |moving| moving.at(due_ns))
    };
    let message = |(seq, row): (u64, &Option<&ArrivalRow>)| MessageRow {
        seq,
        t_due_ns: start_ns.saturating_add(seq.saturating_mul(h_ns)),
        t_send_ns: row.and_then(|row| row.t_send_ns),
        t_receive_ns: None,
        t_arrive_ns: row.map(|row| row.t_arrive_ns),
        r: r(seq.saturating_mul(h_ns)),
        y: None,
        e: None,
        u: row.map(|row| row.u),
        tick: row.filter(|_| is_closed).map(|row| row.tick),
        outcome: match row {
            Some(_) => MessageOutcome::Arrived,
            None => MessageOutcome::Missed,
        },
        y_seq: None,
    };
    (0..).zip(&by_number).map(message).collect()
}

fn text(messages: &[MessageRow]) -> std::io::Result<Vec<u8>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in messages {
        csv.serialize(row).map_err(std::io::Error::other)?;
    }
    csv.into_inner().map_err(csv::IntoInnerError::into_error)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use endpoint::ArrivalOutcome;
    use plan::{Instead, Plan, ProfileText};

    use super::*;

    const START_NS: u64 = 5_000_000_000;

    /// A cell of a hundred messages, at 100 Hz.
    fn cell() -> Cell {
        let source = "name = \"own\"\n[[cells]]\ntopology = \"arima\"\nmode = \"closed\"\nh = \"10ms\"\n\
                      client = { name = \"mine\", run = [\"mine\"] }\nduration = \"1s\"\n";
        let profile = |name: &str| {
            Ok(ProfileText {
                source: link::Profile::builtin(name).unwrap().to_owned(),
                ..ProfileText::default()
            })
        };
        Plan::resolve(source, "own.toml", &Instead::default(), profile)
            .unwrap()
            .cells
            .remove(0)
    }

    fn arrivals(
        count: u64,
        seq: impl Fn(u64) -> u64,
        first_ns: u64,
        every_ns: u64,
    ) -> Vec<ArrivalRow> {
        let row = |n| ArrivalRow {
            n,
            seq: seq(n),
            t_send_ns: None,
            t_arrive_ns: first_ns + n * every_ns,
            tick: n,
            u: 0.5,
            outcome: ArrivalOutcome::Applied,
        };
        (0..count).map(row).collect()
    }

    #[test]
    fn each_breach_is_named_and_a_plain_controller_has_none() {
        let cell = cell();
        let said = |rows: &[ArrivalRow], refused| breach(&cell, START_NS, rows, refused);
        let good = arrivals(100, |n| n, START_NS, 10_000_000);
        assert_eq!(said(&good, 1), None);
        for (words, rows, refused) in [
            ("no message to the plant", vec![], 0),
            ("refused 7 requests", vec![], 7),
            (
                "500 ms early",
                arrivals(100, |n| n, START_NS - 500_000_000, 10_000_000),
                0,
            ),
            ("flooded", arrivals(301, |n| n, START_NS, 1_000_000), 0),
            ("refused 20 times", good.clone(), 20),
        ] {
            let said = said(&rows, refused).unwrap();
            assert!(said.contains(words), "{words}: {said}");
        }
    }

    #[test]
    fn rows_that_a_controller_left_are_a_file_of_bounded_length_and_whole() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join(file_name::MESSAGES);
        let cell = cell();
        assert!(left(&path, &cell).unwrap().is_none());
        let good = text(&messages(
            &cell,
            START_NS,
            &arrivals(100, |n| n, START_NS, 10_000_000),
        ))
        .unwrap();
        std::fs::write(&path, &good).unwrap();
        assert_eq!(left(&path, &cell).unwrap(), Some(good));
        let said = || left(&path, &cell).unwrap_err().to_string();
        std::fs::write(&path, "seq,t_due_ns\n1,x\n").unwrap();
        assert!(said().contains("own/messages.csv"), "{}", said());
        let long = std::fs::File::create(&path).unwrap();
        long.set_len(1 << 40).unwrap();
        assert!(said().contains("at most"), "{}", said());
        std::fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink("/etc/passwd", &path).unwrap();
        assert!(said().contains("a link"), "{}", said());
    }

    #[test]
    fn messages_have_their_own_numbers_or_those_of_their_arrivals() {
        let cell = cell();
        // Every second message was sent.
        let rows = messages(
            &cell,
            START_NS,
            &arrivals(50, |n| 2 * n, START_NS, 20_000_000),
        );
        assert_eq!(rows.len(), 100);
        assert!(
            rows.iter()
                .all(|row| (row.outcome == MessageOutcome::Arrived) == (row.seq % 2 == 0))
        );
        // Numbers that repeat count nothing.
        let rows = messages(
            &cell,
            START_NS,
            &arrivals(90, |n| n / 2, START_NS, 10_000_000),
        );
        assert!(
            rows.iter()
                .all(|row| (row.outcome == MessageOutcome::Arrived) == (row.seq < 90))
        );
        assert!((0..).zip(&rows).all(|(seq, row)| row.seq == seq));
    }

    #[test]
    fn a_message_sent_again_under_its_number_leaves_all_others_theirs() {
        let cell = cell();
        let mut twice = arrivals(99, |n| n, START_NS, 10_000_000);
        let again = ArrivalRow {
            t_arrive_ns: twice[40].t_arrive_ns + 230_000_000,
            ..twice[40]
        };
        twice.insert(64, again);
        let rows = messages(&cell, START_NS, &twice);
        assert_eq!(rows.len(), 100);
        let arrived = |row: &MessageRow| row.t_arrive_ns;
        let first: Vec<Option<u64>> = (0..99).map(|n| Some(START_NS + n * 10_000_000)).collect();
        let all: Vec<Option<u64>> = rows.iter().map(arrived).collect();
        assert_eq!(all[..99], first);
        assert_eq!(rows[99].outcome, MessageOutcome::Missed);
    }
}
