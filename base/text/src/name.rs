//! Names that people give: of links, systems, experiments, sweeps, faults and programs. They become parts of
//! folders' names, on any machine.

/// How to write a name.
pub(crate) const REMEDY: &str = "use up to 40 of a-z, 0-9 and -, a letter or digit first";

/// Longest name, bytes: with the other words of a cell it names a folder.
const LONGEST: usize = 40;

/// Whether a text can name a link, a system, an experiment or a sweep, and so a folder of results: up to 40
/// of a-z, 0-9 and -, not - first, and no name that some systems keep for a device.
#[must_use]
pub fn is_name(text: &str) -> bool {
    is_plain(text, LONGEST) && !is_device(text)
}

/// Whether a text is up to `longest` of a-z, 0-9 and -, not - first.
#[must_use]
pub fn is_plain(text: &str, longest: usize) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (1..=longest).contains(&text.len()) && text.chars().all(plain) && !text.starts_with('-')
}

/// Whether a file of this name, with any ending, is a device on Windows: such a folder cannot be copied there.
#[must_use]
pub fn is_device(text: &str) -> bool {
    let stem = text.split('.').next().unwrap_or_default();
    let stem = stem.trim_end().to_ascii_lowercase();
    matches!(
        stem.as_bytes(),
        b"con"
            | b"prn"
            | b"aux"
            | b"nul"
            | [b'c', b'o', b'm', b'0'..=b'9']
            | [b'l', b'p', b't', b'0'..=b'9']
    )
}
