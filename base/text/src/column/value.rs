//! An entry of a raw row: how it is written, and how it is read again.
//!
//! What is written has the same bytes as the csv crate writes by serde, which a test compares, in a fraction of the
//! time. None of it needs a quote.

use crate::column::bad_entry::BadEntry;
use crate::column::choice::Word;
use crate::column::entry::{EntryType, Typed};
use crate::column::plain::Fields;

/// An entry of a raw row.
pub trait Value: Typed + Sized {
    /// Appends the entry to a text; nothing, where there is nothing to record.
    fn write(&self, text: &mut Vec<u8>);

    /// Takes the entry from a line in the [plain form](crate::column::plain); `None` if it is not in it.
    fn plain(fields: &mut Fields<'_>) -> Option<Self>;

    /// Reads an entry that somebody else wrote.
    ///
    /// # Errors
    /// [`BadEntry`] if it is none.
    fn strict(text: &str) -> Result<Self, BadEntry>;
}

impl<T: Word> Typed for T {
    const ENTRY: EntryType = EntryType::String;
    const WORDS: &'static [&'static str] = T::WORDS;
}

impl<T: Word> Value for T {
    #[inline]
    fn write(&self, text: &mut Vec<u8>) {
        text.extend_from_slice(self.word().as_bytes());
    }

    #[inline]
    fn plain(fields: &mut Fields<'_>) -> Option<Self> {
        T::of(fields.word()?)
    }

    fn strict(text: &str) -> Result<Self, BadEntry> {
        T::of(text).ok_or_else(|| BadEntry::word(text, <T as Word>::WORDS))
    }
}

/// Whole numbers of these types.
macro_rules! counts {
    ($($type:ty),+) => {$(
        impl Value for $type {
            #[inline]
            fn write(&self, text: &mut Vec<u8>) {
                text.extend_from_slice(itoa::Buffer::new().format(*self).as_bytes());
            }

            #[inline]
            fn plain(fields: &mut Fields<'_>) -> Option<Self> {
                fields.count()?.try_into().ok()
            }

            /// Digits only, so neither `+7` nor ` 7`.
            fn strict(text: &str) -> Result<Self, BadEntry> {
                let is_digits = text.bytes().all(|byte| byte.is_ascii_digit());
                match text.parse() {
                    Ok(number) if is_digits => Ok(number),
                    _ => Err(BadEntry::count(text, <$type>::MAX.into())),
                }
            }
        }
    )+};
}

counts!(u32, u64);

impl Value for f64 {
    /// With the fewest digits that read back to the same number.
    #[inline]
    fn write(&self, text: &mut Vec<u8>) {
        let mut buffer = zmij::Buffer::new();
        let number = buffer.format(*self);
        // The csv crate writes a great number as 1e16, and this one as 1e+16.
        if self.abs() >= 1e16
            && let Some((digits, exponent)) = number.split_once('+')
        {
            text.extend_from_slice(digits.as_bytes());
            text.extend_from_slice(exponent.as_bytes());
        } else {
            text.extend_from_slice(number.as_bytes());
        }
    }

    #[inline]
    fn plain(fields: &mut Fields<'_>) -> Option<f64> {
        fields.number()
    }

    fn strict(text: &str) -> Result<f64, BadEntry> {
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| BadEntry::number(text))
    }
}

impl Value for bool {
    #[inline]
    fn write(&self, text: &mut Vec<u8>) {
        text.extend_from_slice(if *self { b"true" } else { b"false" });
    }

    #[inline]
    fn plain(fields: &mut Fields<'_>) -> Option<bool> {
        fields.word()?.parse().ok()
    }

    fn strict(text: &str) -> Result<bool, BadEntry> {
        let word = text.parse();
        word.map_err(|_| BadEntry::word(text, &["true", "false"]))
    }
}

impl<T: Value> Value for Option<T> {
    #[inline]
    fn write(&self, text: &mut Vec<u8>) {
        if let Some(value) = self {
            value.write(text);
        }
    }

    #[inline]
    fn plain(fields: &mut Fields<'_>) -> Option<Option<T>> {
        fields.maybe(T::plain)
    }

    fn strict(text: &str) -> Result<Option<T>, BadEntry> {
        match text {
            "" => Ok(None),
            _ => T::strict(text).map(Some),
        }
    }
}
