//! What belongs to each number of many, such as when each message arrived, found by the number.
//!
//! Runs have hundreds of thousands of messages, mostly numbered one after the other: a map's tree takes several times
//! as long.

/// Values by their numbers; where a number came twice, the first one counts.
#[derive(Debug, Clone)]
pub(crate) struct Numbered<T>(Vec<(u64, T)>);

impl<T> FromIterator<(u64, T)> for Numbered<T> {
    fn from_iter<I: IntoIterator<Item = (u64, T)>>(all: I) -> Self {
        let mut all: Vec<(u64, T)> = all.into_iter().collect();
        // Stable, and quick where they are in order already.
        all.sort_by_key(|(number, _)| *number);
        all.dedup_by_key(|(number, _)| *number);
        Self(all)
    }
}

impl<T> Numbered<T> {
    /// The value of a number; `None` if it has none.
    pub(crate) fn get(&self, number: u64) -> Option<&T> {
        let (first, _) = self.0.first()?;
        // Where it is if none before it is missing, and no later than that in any case.
        let most = usize::try_from(number.checked_sub(*first)?).unwrap_or(usize::MAX);
        let at = match self.0.get(most) {
            Some((there, _)) if *there == number => most,
            _ => self.0.binary_search_by_key(&number, |(one, _)| *one).ok()?,
        };
        self.0.get(at).map(|(_, value)| value)
    }

    /// All values, in the order of their numbers.
    pub(crate) fn values(&self) -> impl Iterator<Item = &T> {
        self.0.iter().map(|(_, value)| value)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn each_number_has_the_first_value_that_came_with_it(
            all in prop::collection::vec((0_u64..60, any::<u8>()), 0..80), far: bool, number in 0_u64..80,
        ) {
            let far = if far { u64::MAX - 100 } else { 0 };
            let all = || all.iter().map(|(number, value)| (number + far, *value));
            let mut due: BTreeMap<u64, u8> = BTreeMap::new();
            for (number, value) in all() {
                due.entry(number).or_insert(value);
            }
            let numbered: Numbered<u8> = all().collect();
            prop_assert_eq!(numbered.get(number + far), due.get(&(number + far)));
            prop_assert_eq!(numbered.get(number), due.get(&number));
            prop_assert!(numbered.values().eq(due.values()));
        }
    }
}
