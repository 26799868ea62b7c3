//! The two ways of a message, `tau_ca` to the actuator and `tau_sc` back from the sensor (section 3.2), and how the time
//! between two messages changes on the way (section 4).

use analysis::Run;
use analysis::statistics::mean;
use endpoint::MessageRow;
use record::{ReadError, rows};

use super::metric::Metric;

/// Two ways differ if they do by over a part of their mean: one in so many.
const DIFFER: f64 = 10.0;

/// An interval shrank if it is shorter by over h divided by this.
const SHRANK: u64 = 10;

pub(super) const FIGURES: &[Metric] = &[
    Metric::group(
        "rank correlation of the two ways of a message",
        "",
        |source| {
            source
                .group
                .try_median(|run| Ok(correlation(&Ways::read(run)?.each_ns)))
        },
    ),
    Metric::group(
        "share of messages whose two ways differ by over a tenth",
        "",
        |source| {
            source
                .group
                .try_median(|run| Ok(Ways::read(run)?.differing()))
        },
    ),
    Metric::group(
        "share of intervals that shrank on their way by over h/10",
        "",
        |source| {
            source
                .group
                .try_median(|run| Ok(Ways::read(run)?.shrunk(run.cell.settings.h.ns())))
        },
    ),
];

/// The messages of a run that were answered, in order of sending.
#[derive(Debug, Default)]
struct Ways {
    /// How long each took up and down, ns.
    each_ns: Vec<[u64; 2]>,
    /// When each was sent and when it arrived, ns.
    at_ns: Vec<[u64; 2]>,
}

impl Ways {
    fn read(run: &Run) -> Result<Ways, ReadError> {
        let mut ways = Ways::default();
        let path = run.folder.join(MessageRow::FILE);
        rows::read(&path, |row: &MessageRow| {
            if let (Some(send), Some(arrive), Some(receive)) =
                (row.t_send_ns, row.t_arrive_ns, row.t_receive_ns)
            {
                let (up, down) = (arrive.saturating_sub(send), receive.saturating_sub(arrive));
                ways.each_ns.push([up, down]);
                ways.at_ns.push([send, arrive]);
            }
        })?;
        ways.at_ns.sort_unstable();
        Ok(ways)
    }

    fn differing(&self) -> Option<f64> {
        let differ = |[up, down]: &&[u64; 2]| {
            let (up, down) = (*up as f64, *down as f64);
            (up - down).abs() * DIFFER > (up + down) / 2.0
        };
        let differing = self.each_ns.iter().filter(differ).count();
        analysis::statistics::share(differing as u64, self.each_ns.len() as u64)
    }

    fn shrunk(&self, h_ns: u64) -> Option<f64> {
        let pairs = || self.at_ns.windows(2);
        let shrank = |pair: &&[[u64; 2]]| {
            let [[send, arrive], [next_send, next_arrive]] = [pair[0], pair[1]];
            let (before, after) = (next_send - send, next_arrive.saturating_sub(arrive));
            after + h_ns / SHRANK < before
        };
        analysis::statistics::share(
            pairs().filter(shrank).count() as u64,
            pairs().count() as u64,
        )
    }
}

/// Spearman's rank correlation: by ranks, since one stall is longer than all other ways together. `None` with fewer
/// than three pairs, or where all of one side are equal.
fn correlation(pairs: &[[u64; 2]]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let side = |of: usize| ranks(&pairs.iter().map(|pair| pair[of]).collect::<Vec<_>>());
    let (a, b) = (side(0), side(1));
    let (a_mean, b_mean) = (mean(&a), mean(&b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(&b) {
        let (a, b) = (a - a_mean, b - b_mean);
        (ab, aa, bb) = (ab + a * b, aa + a * a, bb + b * b);
    }
    (aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}

/// The rank of each value from 0; equal ones share the mean of theirs.
fn ranks(values: &[u64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by_key(|at| values[*at]);
    let mut ranks = vec![0.0; values.len()];
    let mut from = 0;
    for tied in order.chunk_by(|one, next| values[*one] == values[*next]) {
        let rank = from as f64 + (tied.len() - 1) as f64 / 2.0;
        for at in tied {
            ranks[*at] = rank;
        }
        from += tied.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.spearmanr` of these pairs, version 1.17.1.
    #[test]
    fn the_correlation_is_scipy_s() {
        let pairs = |a: [u64; 7], b: [u64; 7]| -> Vec<[u64; 2]> {
            a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
        };
        let plain = pairs([1, 2, 3, 4, 5, 6, 7], [3, 1, 4, 2, 7, 6, 5]);
        let tied = pairs([1, 2, 2, 4, 5, 6, 6], [3, 1, 4, 4, 7, 6, 6]);
        for (pairs, by_scipy) in [(plain, PLAIN), (tied, TIED)] {
            let ours = correlation(&pairs).expect("seven pairs");
            assert!((ours - by_scipy).abs() < 1e-12, "{ours} {by_scipy}");
        }
        assert_eq!(correlation(&[[1, 2], [1, 3], [1, 4]]), None);
    }

    const PLAIN: f64 = 0.678_571_428_571_428_7;
    const TIED: f64 = 0.805_555_555_555_555_7;

    #[test]
    fn ways_and_intervals_are_counted_as_they_say() {
        let ways = Ways {
            each_ns: vec![[100, 100], [100, 112], [100, 109], [50, 100]],
            at_ns: vec![[0, 50], [1000, 1050], [2000, 2040], [3000, 2850]],
        };
        assert_eq!(ways.differing(), Some(0.5));
        // By 10, by 190: over a tenth of 1000 is one.
        assert_eq!(ways.shrunk(1000), Some(1.0 / 3.0));
    }
}
