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
    drawn(&text::plain(&words.to_string()));
}

/// Prints a text on standard error that has colours of our own, and a line's end.
pub(crate) fn drawn(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Standard output, whose errors say that they are its own. Control characters come out by their codes.
pub(crate) fn out() -> Out {
    Out(PlainWriter::of(io::stdout()))
}

pub(crate) struct Out(PlainWriter<Stdout>);

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(|problem| own(&problem))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(|problem| own(&problem))
    }
}

/// Writes text on, with control characters by their codes, however it is cut into pieces.
struct PlainWriter<W: Write> {
    to: W,
    /// The beginning of a letter whose rest comes with the next piece.
    begun: Vec<u8>,
}

impl<W: Write> PlainWriter<W> {
    fn of(to: W) -> Self {
        Self {
            to,
            begun: Vec::new(),
        }
    }
}

impl<W: Write> Write for PlainWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Of ASCII alone, only what is below the space and DEL act.
        let acts = |byte: &u8| !matches!(byte, b' '..=b'~' | b'\n' | b'\t');
        if self.begun.is_empty() && !bytes.iter().any(acts) {
            return self.to.write(bytes);
        }
        let mut text = std::mem::take(&mut self.begun);
        text.extend_from_slice(bytes);
        let mut chunks = text.utf8_chunks().peekable();
        while let Some(chunk) = chunks.next() {
            self.to.write_all(text::plain(chunk.valid()).as_bytes())?;
            let other = chunk.invalid();
            let is_begun = chunks.peek().is_none()
                && std::str::from_utf8(other).is_err_and(|error| error.error_len().is_none());
            if is_begun {
                self.begun = other.to_vec();
            } else {
                // What is no beginning of a letter is not text, as in a picture.
                self.to.write_all(other)?;
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

fn own(problem: &io::Error) -> io::Error {
    let words = format!("standard output cannot be written: {problem}");
    io::Error::new(problem.kind(), words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_shown_the_same_however_it_is_cut() {
        let text = "a\u{1b}[2J\u{9b}31m \u{e9}\u{20ac}\u{1f980}\u{202e}\r\n\u{7f}z\t.";
        for size in 1..=text.len() {
            let mut shown = PlainWriter::of(Vec::new());
            for piece in text.as_bytes().chunks(size) {
                shown.write_all(piece).expect("in memory");
            }
            let shown = String::from_utf8(shown.to).expect("text");
            assert!(!shown.contains(text::is_active), "{size}: {shown:?}");
            assert_eq!(shown, text::plain(text), "{size}");
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_written_as_they_are() {
        let mut shown = PlainWriter::of(Vec::new());
        shown
            .write_all(&[0xff, b'a', 0xfe, 0xc3, b'b'])
            .expect("in memory");
        assert_eq!(shown.to, [0xff, b'a', 0xfe, 0xc3, b'b']);
    }
}
