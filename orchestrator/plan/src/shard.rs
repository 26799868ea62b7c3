//! Divides cells into n shards that take about equally long, for machines that work in parallel.
//!
//! The caller says how long a cell takes. A [`Job`](crate::Job) can also be a share by topology.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt;
use std::str::FromStr;

use crate::cell::Cell;

/// One of n shards, counted from 1: `2/7`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    of: u32,
}

/// A text that is not a shard.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not i/n with i from 1 to n and n up to {most}; write the second of seven 2/7",
    most = Shard::MOST
)]
pub struct UnknownShard(String);

impl Shard {
    /// Largest number of shards; a larger one is more likely a typing error than that many machines.
    pub const MOST: u32 = 10_000;

    /// The cells of this shard, in the order given; none, if there are more shards than cells and this
    /// is one of the last.
    ///
    /// `time_ns` says how long a cell takes.
    #[must_use]
    pub fn of<'a>(self, cells: &[&'a Cell], time_ns: impl Fn(&Cell) -> u64) -> Vec<&'a Cell> {
        let shards = Shard::all(cells, self.of, time_ns);
        shards
            .into_iter()
            .find(|(shard, _)| *shard == self)
            .map_or_else(Vec::new, |(_, cells)| cells)
    }

    /// All shards that have at least one cell. Each cell is in one of them, and the longest shard takes
    /// at most one cell's time more than the shortest.
    ///
    /// Longest processing time first (Graham, "Bounds on multiprocessing timing anomalies", 1969):
    /// cells in order of decreasing time, equal ones by index, each go to the shard with the least work
    /// so far, and among equal shards to the first. The result depends on the cells and their times
    /// alone.
    #[must_use]
    pub fn all<'a>(
        cells: &[&'a Cell],
        of: u32,
        time_ns: impl Fn(&Cell) -> u64,
    ) -> Vec<(Shard, Vec<&'a Cell>)> {
        let mut places: Vec<usize> = (0..cells.len()).collect();
        places.sort_by_key(|place| (Reverse(time_ns(cells[*place])), cells[*place].index));
        let mut least: BinaryHeap<Reverse<(u64, u32)>> =
            (1..=of).map(|number| Reverse((0, number))).collect();
        let mut taken: Vec<(u32, usize)> = Vec::new();
        for place in places {
            let Some(Reverse((load_ns, number))) = least.pop() else {
                break;
            };
            taken.push((number, place));
            // A cell that takes no time counts as 1 ns, or the first shard would get all of them.
            let time_ns = time_ns(cells[place]).max(1);
            least.push(Reverse((load_ns.saturating_add(time_ns), number)));
        }
        taken.sort_unstable();
        taken
            .chunk_by(|one, other| one.0 == other.0)
            .filter_map(|shard| {
                let (number, _) = *shard.first()?;
                let cells = shard.iter().map(|(_, place)| cells[*place]).collect();
                Some((Shard { number, of }, cells))
            })
            .collect()
    }
}

impl FromStr for Shard {
    type Err = UnknownShard;

    fn from_str(text: &str) -> Result<Self, UnknownShard> {
        let unknown = || UnknownShard(text.to_owned());
        let (number, of) = text.split_once('/').ok_or_else(unknown)?;
        let count = |text: &str| text.parse::<u32>().map_err(|_| unknown());
        let (number, of) = (count(number)?, count(of)?);
        if (1..=of).contains(&number) && of <= Shard::MOST {
            Ok(Shard { number, of })
        } else {
            Err(unknown())
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}/{}", self.number, self.of))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instead::Instead;
    use crate::plan::Plan;
    use crate::profile_text::ProfileText;
    use proptest::prelude::*;

    /// A plan's cells, `count` of them.
    fn cells(count: usize) -> Vec<Cell> {
        let source = format!(
            "name = \"mine\"\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\n\
             mode = \"open\"\nh = [\"100ms\"]\nduration = \"1s\"\nrepeats = {count}\n"
        );
        let profile = |name: &str| {
            let source = link::Profile::builtin(name).expect("built in").to_owned();
            Ok(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        let plan = Plan::resolve(&source, "mine.toml", &Instead::default(), profile);
        plan.expect("an experiment").cells
    }

    fn indices(cells: &[&Cell]) -> Vec<usize> {
        cells.iter().map(|cell| cell.index).collect()
    }

    #[test]
    fn a_shard_is_read_as_it_is_written_and_nothing_else_is_one() {
        for text in ["1/1", "2/7", "10000/10000"] {
            let shard: Shard = text.parse().expect(text);
            assert_eq!(shard.to_string(), text);
        }
        for text in [
            "", "2", "0/7", "8/7", "1/0", "-1/2", "1/2/3", "1/10001", "a/b",
        ] {
            let problem = text.parse::<Shard>().expect_err(text).to_string();
            assert!(problem.contains("2/7"), "{problem}");
        }
    }

    #[test]
    fn the_textbook_s_jobs_are_shared_out_as_in_the_textbook() {
        // Graham's example for three machines: 5, 5, 4, 4, 3, 3, 3 end after 11, where 9 is possible.
        let times_s = [5, 5, 4, 4, 3, 3, 3];
        let cells = cells(times_s.len());
        let cells: Vec<&Cell> = cells.iter().collect();
        let shards = Shard::all(&cells, 3, |cell| times_s[cell.index]);
        let shared: Vec<_> = shards.iter().map(|(_, cells)| indices(cells)).collect();
        assert_eq!(shared, [vec![0, 4, 6], vec![1, 5], vec![2, 3]]);
    }

    proptest! {
        #[test]
        fn every_cell_is_in_one_shard_and_no_shard_is_a_cell_s_time_behind(
            times_s in prop::collection::vec(0u64..100, 1..60),
            of in 1u32..80,
        ) {
            let cells = cells(times_s.len());
            let given: Vec<&Cell> = cells.iter().collect();
            let time = |cell: &Cell| times_s[cell.index];
            let shards = Shard::all(&given, of, time);
            let mut shared: Vec<usize> = shards.iter().flat_map(|(_, cells)| indices(cells)).collect();
            shared.sort_unstable();
            prop_assert!(shared.into_iter().eq(0..cells.len()));
            // As many machines as possible have work.
            prop_assert_eq!(shards.len(), cells.len().min(of as usize));

            let loads = shards.iter().map(|(_, cells)| cells.iter().map(|cell| time(cell).max(1)).sum());
            let loads: Vec<u64> = loads.collect();
            let most = loads.iter().max().copied().unwrap_or(0);
            let least = if shards.len() == of as usize { loads.iter().min().copied().unwrap_or(0) } else { 0 };
            let longest = times_s.iter().max().copied().unwrap_or(0).max(1);
            prop_assert!(most - least <= longest, "{:?}", loads);
        }

        #[test]
        fn a_shard_is_the_same_whoever_asks_and_in_whatever_order(
            times_s in prop::collection::vec(0u64..5, 1..40),
            of in 1u32..10,
        ) {
            let cells = cells(times_s.len());
            let time = |cell: &Cell| times_s[cell.index];
            let given: Vec<&Cell> = cells.iter().collect();
            let turned: Vec<&Cell> = cells.iter().rev().collect();
            for number in 1..=of {
                let shard: Shard = format!("{number}/{of}").parse().expect("a shard");
                let mine = indices(&shard.of(&given, time));
                prop_assert!(mine.is_sorted(), "in the order of the plan");
                let mut other = indices(&shard.of(&turned, time));
                other.reverse();
                prop_assert_eq!(mine, other);
            }
        }
    }
}
