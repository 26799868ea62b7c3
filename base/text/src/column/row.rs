//! The rows of a raw file, and the macros that declare a table's columns.

use serde::de::DeserializeOwned;

use crate::column::strict::BadLine;

/// A row of a raw file: a struct with a field for each column, in the order of its header.
pub trait Row: DeserializeOwned {
    /// How many of the last columns older files do not have, each of which came by itself; they are empty then.
    const NEW: usize;

    /// The columns of its file, in order.
    const COLUMNS: &'static [&'static str];

    /// Appends the row to a text, as a line with its end. Nothing but a text that is too short allocates.
    fn write(&self, text: &mut Vec<u8>);

    /// Parses a line without its end; `None` if it is not in the [plain form](crate::column::plain).
    fn plain(line: &[u8]) -> Option<Self>;

    /// Reads a line without its end that somebody else wrote.
    ///
    /// # Errors
    /// [`BadLine`] if it is not a row.
    fn strict(line: &str) -> Result<Self, BadLine>;
}

/// Declares the rows of a table: a struct with a field for each column, under a comment that says what its entries
/// mean; its header `COLUMNS`; and its `SCHEMA`, what the columns say of themselves. Fields `beside` are no columns.
///
/// How a row is written and read is serde's, whose attributes come with the struct.
#[macro_export]
macro_rules! table {
    (
        $(#[$meta:meta])*
        $name:ident { $($(#[doc = $doc:literal])+ $field:ident: $type:ty,)+ }
        $(beside { $($(#[$beside_meta:meta])* $beside:ident: $beside_type:ty,)+ })?
    ) => {
        $(#[$meta])*
        pub struct $name {
            $($(#[doc = $doc])+ pub $field: $type,)+
            $($($(#[$beside_meta])* pub $beside: $beside_type,)+)?
        }

        impl $name {
            /// The columns of its file, in order.
            pub const COLUMNS: &'static [&'static str] = &[$(stringify!($field)),+];

            /// The same, and what is in them.
            pub const SCHEMA: &'static [$crate::column::Column] = &[
                $($crate::column::Column::of::<$type>(stringify!($field), concat!($($doc, "\n"),+))),+
            ];
        }
    };
}

/// Declares the rows of a raw file: what [`table!`] does, and how a row is written and read ([`Row`]). Columns that
/// came `later` are the last ones, and may be empty: a file that was written before does not have them.
#[macro_export]
macro_rules! row {
    (
        $(#[$meta:meta])*
        $name:ident { $($columns:tt)+ }
        $(later { $($later:tt)+ })?
    ) => {
        $crate::table!(
            $(#[$meta])*
            #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
            $name { $($columns)+ $($($later)+)? }
        );
        $crate::row!(@ways $name { $($columns)+ $($($later)+)? } { $($($later)+)? });
    };
    (
        @ways $name:ident
        { $($(#[doc = $doc:literal])+ $field:ident: $type:ty,)+ }
        { $($(#[doc = $new_doc:literal])+ $new:ident: $new_type:ty,)* }
    ) => {
        // An older file has nothing in its place.
        const _: () = {
            $(assert!(!<$new_type as $crate::column::Typed>::IS_REQUIRED, "a later column may be empty");)*
        };

        impl $crate::column::Row for $name {
            const NEW: usize = <[&str]>::len(&[$(stringify!($new)),*]);
            const COLUMNS: &'static [&'static str] = $name::COLUMNS;

            #[inline]
            fn write(&self, text: &mut Vec<u8>) {
                $(
                    $crate::column::Value::write(&self.$field, text);
                    text.push(b',');
                )+
                // In place of the last comma.
                if let Some(end) = text.last_mut() {
                    *end = b'\n';
                }
            }

            #[inline]
            fn plain(line: &[u8]) -> Option<Self> {
                let mut fields = $crate::column::plain::Fields::of(line);
                let row = Self { $($field: $crate::column::Value::plain(&mut fields)?),+ };
                fields.end(row)
            }

            fn strict(line: &str) -> Result<Self, $crate::column::strict::BadLine> {
                let mut unread = $crate::column::strict::Unread::of(line, Self::COLUMNS)?;
                Ok(Self { $($field: unread.next(stringify!($field))?),+ })
            }
        }
    };
}
