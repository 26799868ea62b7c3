//! Several words in a sentence.

/// `open or closed`, `none, address or token`: one of these.
#[must_use]
pub fn one_of(words: &[&str]) -> String {
    match words {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => words.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::one_of;

    #[test]
    fn the_last_of_several_words_stands_behind_an_or() {
        assert_eq!(one_of(&["own", "shared", "none"]), "own, shared or none");
        assert_eq!(one_of(&["own", "shared"]), "own or shared");
        assert_eq!(one_of(&["own"]), "own");
        assert_eq!(one_of(&[]), "");
    }
}
