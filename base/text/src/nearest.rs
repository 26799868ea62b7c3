//! The name that somebody may have meant: the nearest of those that there are.

/// How alike two words must be, by Jaro and Winkler.
const ALIKE: f64 = 0.8;

/// How alike are two words that one slip of a finger makes of each other.
const ONE_SLIP: f64 = 0.9;

/// The name most like a word that is none of them; `None` if none is like it.
///
/// ```
/// assert_eq!(text::nearest("topolgy", ["client", "topology"]), Some("topology"));
/// assert_eq!(text::nearest("colour", ["client", "topology"]), None);
/// ```
pub fn nearest<'a>(given: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let given = given.to_lowercase();
    let alike = |name: &str| {
        let name = name.to_lowercase();
        let likeness = strsim::jaro_winkler(&given, &name);
        // Of three letters two that changed places are not alike by Jaro.
        match name.len() >= 3 && strsim::osa_distance(&given, &name) == 1 {
            true => likeness.max(ONE_SLIP),
            false => likeness,
        }
    };
    let all = names.into_iter().map(|name| (alike(name), name));
    let likely = all.filter(|(likeness, _)| *likeness >= ALIKE);
    // The first of equally likely ones.
    let most = likely.reduce(|most, one| if one.0 > most.0 { one } else { most });
    most.map(|(_, name)| name)
}

/// A remedy that offers the nearest name first: `did you mean `couva`? If not, use one of arima, couva`.
#[must_use]
pub fn or_nearest<'a>(
    given: &str,
    names: impl IntoIterator<Item = &'a str>,
    remedy: &str,
) -> String {
    match nearest(given, names) {
        Some(name) => format!("did you mean `{name}`? If not, {remedy}"),
        None => remedy.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_meant_is_offered_and_nothing_is_where_nothing_is_like_it() {
        let links = ["arima", "buccoo", "couva", "diego-lan", "diego-vpn"];
        for (given, name) in [
            ("couvaa", Some("couva")),
            ("Buccoo", Some("buccoo")),
            ("diegovpn", Some("diego-vpn")),
            ("cafe", None),
            ("cuova", Some("couva")),
            ("", None),
        ] {
            assert_eq!(nearest(given, links), name, "{given}");
        }
        assert_eq!(
            or_nearest("arma", links, "use another"),
            "did you mean `arima`? If not, use another"
        );
        assert_eq!(nearest("rnu", ["run", "show"]), Some("run"));
        assert_eq!(or_nearest("x", links, "use another"), "use another");
    }
}
