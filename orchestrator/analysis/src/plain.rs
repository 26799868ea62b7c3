//! Parses a row from a line as webloop writes it: by position, without quotes, without copying.
//!
//! This is a faster way to the result of the csv crate and serde, and never gives another result. A
//! line in another form (quotes, signs, a carriage return), or one that is not a row, gives `None`;
//! [`crate::rows`] then passes it to the csv crate and serde. So there are no error messages here.

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, SecondRow, TickRow};
use plan::{Phase, ProbeRow};
use serde::de::DeserializeOwned;

/// A row that can be read both ways: from the plain form, and by serde.
pub trait Row: DeserializeOwned {
    /// Parses a line without its line end; `None` if it is not in the plain form.
    fn plain(line: &[u8]) -> Option<Self>;

    /// How many of the last columns older files do not have; they are empty then.
    const NEW: usize = 0;
}

/// A field in the plain form.
trait Plain: Sized {
    fn plain(fields: &mut Fields<'_>) -> Option<Self>;
}

impl Plain for u64 {
    fn plain(fields: &mut Fields<'_>) -> Option<u64> {
        fields.count()
    }
}

impl Plain for u32 {
    fn plain(fields: &mut Fields<'_>) -> Option<u32> {
        u32::try_from(fields.count()?).ok()
    }
}

impl<T: Plain> Plain for Option<T> {
    fn plain(fields: &mut Fields<'_>) -> Option<Option<T>> {
        fields.maybe(T::plain)
    }
}

/// Types parsed with `FromStr`, which accepts the same text as serde does; a float is the one nearest
/// to the digits.
macro_rules! words {
    ($($type:ty),+) => {$(
        impl Plain for $type {
            fn plain(fields: &mut Fields<'_>) -> Option<$type> {
                str::from_utf8(fields.text()?).ok()?.parse().ok()
            }
        }
    )+};
}

words!(f64, bool, ArrivalOutcome, MessageOutcome, Phase);

/// Implements `Row` field by field, in the order of the columns.
macro_rules! rows {
    ($($row:ident { $($field:ident),+ } $($new:literal)?)+) => {$(
        impl Row for $row {
            $(const NEW: usize = $new;)?

            fn plain(line: &[u8]) -> Option<Self> {
                let mut fields = Fields::of(line);
                let row = Self { $($field: Plain::plain(&mut fields)?),+ };
                fields.end(row)
            }
        }
    )+};
}

rows! {
    TickRow { k, t_due_ns, t_tick_ns, u, y, seq, u_applied } 1
    SecondRow { k, u2, y2, u2_applied } 1
    ArrivalRow { n, seq, t_send_ns, t_arrive_ns, tick, u, outcome }
    MessageRow { seq, t_due_ns, t_send_ns, t_receive_ns, t_arrive_ns, r, y, e, u, tick, outcome }
    ProbeRow { phase, seq, t_send_ns, t_reach_ns, t_back_ns, due_up_ns, due_down_ns, due_lost }
}

/// The fields of a line, taken one after the other.
struct Fields<'a> {
    /// The rest of the line; `None` after the last field.
    rest: Option<&'a [u8]>,
}

impl<'a> Fields<'a> {
    fn of(line: &'a [u8]) -> Self {
        Self { rest: Some(line) }
    }

    /// The next field as bytes.
    fn text(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let length = rest.iter().position(|byte| *byte == b',');
        let length = length.unwrap_or(rest.len());
        self.rest = rest.get(length + 1..);
        rest.get(..length)
    }

    /// The next field as an integer in digits. At most 19 digits, which always fit into a `u64`.
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

    /// The next field as `read` parses it, or `Some(None)` if it is empty.
    fn maybe<T>(&mut self, read: impl FnOnce(&mut Self) -> Option<T>) -> Option<Option<T>> {
        let rest = self.rest?;
        if matches!(rest.first(), None | Some(b',')) {
            self.rest = rest.get(1..);
            return Some(None);
        }
        read(self).map(Some)
    }

    /// Returns the row if no field is left.
    fn end<R>(self, row: R) -> Option<R> {
        self.rest.is_none().then_some(row)
    }
}
