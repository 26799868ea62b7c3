//! A row from a line as webloop writes it: by position, without quotes, nothing copied.
//!
//! This is a shorter way to what the csv crate and serde make of the line, and never another
//! result: whatever is written otherwise (quotes, signs, a carriage return) or is no row at all is
//! `None`, and [`crate::rows`] asks those two what to make of it. So no error is worded here.

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, TickRow};
use plan::{Phase, ProbeRow};
use serde::de::DeserializeOwned;

/// A row that can be read both ways.
pub trait Row: DeserializeOwned {
    /// The row in a line without its end; `None` if the line is not in the plain form.
    fn plain(line: &[u8]) -> Option<Self>;
}

impl Row for TickRow {
    fn plain(line: &[u8]) -> Option<Self> {
        let mut fields = Fields::of(line);
        let row = Self {
            k: fields.count()?,
            t_due_ns: fields.count()?,
            t_tick_ns: fields.count()?,
            u: fields.number()?,
            y: fields.number()?,
            seq: fields.maybe(Fields::count)?,
        };
        fields.end(row)
    }
}

impl Row for ArrivalRow {
    fn plain(line: &[u8]) -> Option<Self> {
        let mut fields = Fields::of(line);
        let row = Self {
            n: fields.count()?,
            seq: fields.count()?,
            t_send_ns: fields.count()?,
            t_arrive_ns: fields.count()?,
            tick: fields.count()?,
            u: fields.number()?,
            outcome: match fields.text()? {
                b"applied" => ArrivalOutcome::Applied,
                b"stale" => ArrivalOutcome::Stale,
                b"acknowledged" => ArrivalOutcome::Acknowledged,
                _ => return None,
            },
        };
        fields.end(row)
    }
}

impl Row for MessageRow {
    fn plain(line: &[u8]) -> Option<Self> {
        let mut fields = Fields::of(line);
        let row = Self {
            seq: fields.count()?,
            t_due_ns: fields.count()?,
            t_send_ns: fields.maybe(Fields::count)?,
            t_receive_ns: fields.maybe(Fields::count)?,
            t_arrive_ns: fields.maybe(Fields::count)?,
            r: fields.number()?,
            y: fields.maybe(Fields::number)?,
            e: fields.maybe(Fields::number)?,
            u: fields.maybe(Fields::number)?,
            tick: fields.maybe(Fields::count)?,
            outcome: match fields.text()? {
                b"answered" => MessageOutcome::Answered,
                b"timeout" => MessageOutcome::Timeout,
                b"failed" => MessageOutcome::Failed,
                b"missed" => MessageOutcome::Missed,
                _ => return None,
            },
        };
        fields.end(row)
    }
}

impl Row for ProbeRow {
    fn plain(line: &[u8]) -> Option<Self> {
        let mut fields = Fields::of(line);
        let row = Self {
            phase: match fields.text()? {
                b"empty" => Phase::Empty,
                b"before" => Phase::Before,
                b"during" => Phase::During,
                b"after" => Phase::After,
                _ => return None,
            },
            seq: u32::try_from(fields.count()?).ok()?,
            t_send_ns: fields.count()?,
            t_reach_ns: fields.maybe(Fields::count)?,
            t_back_ns: fields.maybe(Fields::count)?,
            due_up_ns: fields.count()?,
            due_down_ns: fields.count()?,
            due_lost: match fields.text()? {
                b"true" => true,
                b"false" => false,
                _ => return None,
            },
        };
        fields.end(row)
    }
}

/// The fields of a line, taken one after the other.
struct Fields<'a> {
    /// What has not been taken; `None` after the last field.
    rest: Option<&'a [u8]>,
}

impl<'a> Fields<'a> {
    fn of(line: &'a [u8]) -> Self {
        Self { rest: Some(line) }
    }

    /// The next field, whatever is in it.
    fn text(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let length = rest.iter().position(|byte| *byte == b',');
        let length = length.unwrap_or(rest.len());
        self.rest = rest.get(length + 1..);
        rest.get(..length)
    }

    /// The next field as a whole number in digits. It has at most 19 of them, which no `u64` is too
    /// small for.
    fn count(&mut self) -> Option<u64> {
        let rest = self.rest?;
        let (mut count, mut digits): (u64, usize) = (0, 0);
        for byte in rest {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            count = count.wrapping_mul(10).wrapping_add(u64::from(digit));
            digits += 1;
        }
        self.rest = match rest.get(digits) {
            None => None,
            Some(b',') => rest.get(digits + 1..),
            Some(_) => return None,
        };
        (1..=19).contains(&digits).then_some(count)
    }

    /// The next field as a number, by the rules of [`f64::from_str`](std::str::FromStr), which are
    /// serde's too: the nearest to the digits.
    fn number(&mut self) -> Option<f64> {
        str::from_utf8(self.text()?).ok()?.parse().ok()
    }

    /// The next field as `read` takes it, or nothing where it is empty.
    fn maybe<T>(&mut self, read: impl FnOnce(&mut Self) -> Option<T>) -> Option<Option<T>> {
        let rest = self.rest?;
        if matches!(rest.first(), None | Some(b',')) {
            self.rest = rest.get(1..);
            return Some(None);
        }
        read(self).map(Some)
    }

    /// The row, if no field is left.
    fn end<R>(self, row: R) -> Option<R> {
        self.rest.is_none().then_some(row)
    }
}
