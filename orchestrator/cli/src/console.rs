//! What a command prints: lines for people on standard error, and what was asked for on standard output.
//!
//! A line that cannot be printed, on a full disk or a closed terminal, ends nothing: a campaign of hours is not lost
//! with its progress. What was asked for and cannot be written is an error.

use std::fmt::Arguments;
use std::io::{self, Stdout, Write};

/// Prints a line on standard error, with control characters by their codes; takes what `format!` takes.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::console::line(format_args!($($words)*))
    };
}

/// What [`say!`] does.
pub(crate) fn line(words: Arguments<'_>) {
    drawn(&endpoint::plain(&words.to_string()));
}

/// Prints a text on standard error that has colours of our own, and a line's end.
pub(crate) fn drawn(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Standard output, whose errors say that they are its own.
pub(crate) fn out() -> Out {
    Out(io::stdout())
}

pub(crate) struct Out(Stdout);

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(|problem| own(&problem))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(|problem| own(&problem))
    }
}

fn own(problem: &io::Error) -> io::Error {
    let words = format!("standard output cannot be written: {problem}");
    io::Error::new(problem.kind(), words)
}
