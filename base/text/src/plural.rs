//! How many of something, in words.

/// `1 run`, `2 runs`: `many` is the word for any number but one.
#[must_use]
pub fn counted(n: usize, one: &str, many: &str) -> String {
    match n {
        1 => format!("1 {one}"),
        n => format!("{n} {many}"),
    }
}
