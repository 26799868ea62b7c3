//! The columns of a table, declared once, where the type of its rows is.
//!
//! - [`row!`](crate::row!) declares the rows of a raw file: a struct with a field for each column, its header, how
//!   a row is written and read ([`Row`]), and what the columns say of themselves ([`Column`]);
//! - [`table!`](crate::table!) declares the rows of a table that serde writes: the struct, its header, its columns;
//! - [`Typed`], [`Value`]: what an entry can be, how it is written and read;
//!   [`choice!`](crate::choice!) declares an entry that is one of a few words ([`Word`]), as settings are too;
//! - [`plain`]: reads the form in which rows are written, as fast as can be; [`strict`]: reads what somebody else
//!   wrote, and says what is wrong with it, and where.
//!
//! The files themselves are the task of others, and so are other forms of CSV.

mod bad_entry;
mod choice;
mod entry;
pub mod plain;
mod row;
pub mod strict;
mod value;

pub use bad_entry::BadEntry;
pub use choice::{UnknownWord, Word};
pub use entry::{Column, EntryType, Typed};
pub use row::Row;
pub use value::Value;
