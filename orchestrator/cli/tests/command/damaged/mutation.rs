//! The ways to damage a file: as a disk does, as an editor does, and as somebody does who wants harm.

use rand_core::Rng;

/// What a number may become.
const NUMBERS: [&str; 17] = [
    "",
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "-inf",
    "9999999999999",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "99999999999999999999999999",
    "0.1",
];

/// A damaged copy of a file, and how it was damaged.
pub(crate) fn damaged(whole: &[u8], random: &mut impl Rng) -> (Vec<u8>, &'static str) {
    let mut below = |most: usize| (random.next_u64() % most.max(1) as u64) as usize;
    let mut bytes = whole.to_vec();
    let at = below(bytes.len());
    match below(10) {
        0 => {
            bytes[at] ^= 1 << below(8);
            (bytes, "a bit flipped")
        }
        1 => {
            bytes.truncate(at);
            (bytes, "truncated")
        }
        2 => {
            let end = (at + 1 + below(64)).min(bytes.len());
            bytes[at..end].fill(0);
            (bytes, "NULs")
        }
        3 => {
            let mut lines = lines(whole);
            lines.remove(below(lines.len()));
            (lines.concat(), "a line dropped")
        }
        4 => {
            let mut lines = lines(whole);
            let from = below(lines.len());
            lines.insert(below(lines.len()), lines[from]);
            (lines.concat(), "a line doubled")
        }
        5 => {
            let mut lines = lines(whole);
            let one = below(lines.len());
            let other = below(lines.len());
            lines.swap(one, other);
            (lines.concat(), "two lines swapped")
        }
        6 => {
            // Some digits of one number, and of a few.
            for _ in 0..=below(4) {
                if let Some((from, to)) = number(&bytes, below(bytes.len())) {
                    let digit = b'0' + below(10) as u8;
                    bytes[from + below(to - from)] = digit;
                }
            }
            (bytes, "digits changed")
        }
        7 => {
            let Some((from, to)) = number(&bytes, at) else {
                return (bytes, "left");
            };
            let digits = vec![b'0' + below(10) as u8; below(18)];
            bytes.splice(from..from + below(to - from), digits);
            (bytes, "a longer number")
        }
        _ => {
            let Some((from, to)) = number(&bytes, at) else {
                return (bytes, "left");
            };
            let other = NUMBERS[below(NUMBERS.len())];
            bytes.splice(from..to, other.bytes());
            (bytes, "another number")
        }
    }
}

/// A copy of a file for each of its numbers and each of what a number may become.
pub(crate) fn out_of_proportion(whole: &[u8]) -> Vec<Vec<u8>> {
    let mut copies = Vec::new();
    let mut at = 0;
    while let Some((from, to)) = number(whole, at) {
        copies
            .extend(NUMBERS.map(|other| [&whole[..from], other.as_bytes(), &whole[to..]].concat()));
        at = to;
    }
    copies
}

/// The lines, each with its end.
fn lines(bytes: &[u8]) -> Vec<&[u8]> {
    bytes.split_inclusive(|byte| *byte == b'\n').collect()
}

/// Where the next number from a place on begins and ends.
fn number(bytes: &[u8], from: usize) -> Option<(usize, usize)> {
    let begins = from + bytes.get(from..)?.iter().position(u8::is_ascii_digit)?;
    let is_digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let length = bytes[begins..].iter().position(|byte| !is_digit(byte));
    Some((begins, length.map_or(bytes.len(), |length| begins + length)))
}
