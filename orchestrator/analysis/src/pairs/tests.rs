use proptest::prelude::*;
use serde::Deserialize;

use super::*;

/// Reference values from scipy; `pairs.py` in the same folder produces them.
const REFERENCE: &str = include_str!("../../tests/fixtures/pairs.json");

#[derive(Deserialize)]
struct Case {
    name: String,
    differences: Vec<f64>,
    sign: f64,
    sign_above: f64,
    sign_below: f64,
    signed_rank: f64,
    signed_rank_above: f64,
    signed_rank_below: f64,
}

fn close(own: f64, reference: f64) -> bool {
    (own - reference).abs() <= 1e-9 * reference.max(1e-3)
}

#[test]
fn both_tests_say_what_scipy_says() {
    let cases: Vec<Case> = serde_json::from_str(REFERENCE).expect("the fixture");
    assert!(cases.len() > 2000);
    for case in cases {
        let (sign, rank) = (
            sign_test(&case.differences),
            signed_rank_test(&case.differences),
        );
        for (own, reference) in [
            (sign.either(), case.sign),
            (sign.above, case.sign_above),
            (sign.below, case.sign_below),
            (rank.either(), case.signed_rank),
            (rank.above, case.signed_rank_above),
            (rank.below, case.signed_rank_below),
        ] {
            assert!(
                close(own, reference),
                "{}: {own}, not {reference}",
                case.name
            );
        }
    }
}

#[test]
fn an_infinite_difference_is_the_largest_and_as_large_as_another() {
    let far = [1.0, 2.0, 1e300, -3.0, 1e301];
    let infinite = [1.0, 2.0, f64::INFINITY, -3.0, f64::INFINITY];
    // The same as two equal finite differences: 7 and 7 among 1, 2 and 3.
    let equal = [1.0, 2.0, 7.0, -3.0, 7.0];
    assert_eq!(signed_rank_test(&infinite), signed_rank_test(&equal));
    assert_eq!(sign_test(&infinite), sign_test(&far));
    let either = [f64::INFINITY, f64::NEG_INFINITY];
    let (sign, rank) = (sign_test(&either), signed_rank_test(&either));
    assert_eq!((sign.either(), rank.either()), (1.0, 1.0));
}

#[test]
fn of_nothing_and_of_no_difference_nothing_is_told() {
    for differences in [&[][..], &[0.0, 0.0, -0.0]] {
        assert_eq!(sign_test(differences), Sides::NONE);
        assert_eq!(signed_rank_test(differences), Sides::NONE);
    }
    assert_eq!(holm(&[]), Vec::<f64>::new());
    assert_eq!(worth_making(&[], 0.05), Vec::<bool>::new());
}

#[test]
fn five_pairs_are_the_fewest_that_can_tell_of_one_side() {
    assert_eq!(least_probability(5), 1.0 / 32.0);
    assert!(least_probability(4) > 0.05 && least_probability(5) < 0.05);
    assert_eq!((least_probability(0), least_probability(5000)), (1.0, 0.0));
    // Six of six in three groups, which are tested together; in four groups it takes seven.
    assert!(3.0 * least_probability(6) < 0.05 && 4.0 * least_probability(6) > 0.05);
}

#[test]
fn the_number_of_pairs_that_would_tell_is_that_of_the_sign_test() {
    // All beyond: 0.5^n below 0.05 in one test of one, of four, of eight.
    assert_eq!(to_tell(1, 1, 1, 0.05), Some(5));
    assert_eq!(to_tell(6, 6, 4, 0.05), Some(7));
    assert_eq!(to_tell(6, 6, 8, 0.05), Some(8));
    // None beyond needs no correction.
    assert_eq!(to_tell(2, 0, 8, 0.05), Some(5));
    // A quarter of them beyond: scipy.stats.binom.cdf(4, 16, 0.5) is 0.038, cdf(4, 15, 0.5) 0.059.
    assert_eq!(to_tell(8, 2, 1, 0.05), Some(16));
    // Half of them, and so near to half that a plan cannot have as many.
    assert_eq!(to_tell(8, 4, 1, 0.05), None);
    assert_eq!(to_tell(9_999, 5_000, 1, 0.05), None);
}

#[test]
fn the_median_s_bound_is_an_order_statistic_and_infinite_with_too_few() {
    assert_eq!(median_at_most(&[1.0, 2.0, 3.0, 4.0], 0.05), f64::INFINITY);
    assert_eq!(median_at_most(&[5.0, 2.0, 3.0, 4.0, 1.0], 0.05), 5.0);
    // binom.cdf(1, 10, 0.5) = 0.011 and cdf(2, 10, 0.5) = 0.055: the second largest of ten.
    let ten: Vec<f64> = (1..=10).map(f64::from).collect();
    assert_eq!(median_at_most(&ten, 0.05), 9.0);
    assert_eq!(median_at_most(&[], 0.05), f64::INFINITY);
}

#[test]
fn holm_raises_by_how_many_are_left_and_never_turns_the_order() {
    // By hand: 3 x 0.01, 2 x 0.02, then 0.03 is raised to the one before it.
    let raised = holm(&[0.02, 0.01, 0.03]);
    let by_hand = [0.04, 0.03, 0.04];
    assert!(
        raised
            .iter()
            .zip(by_hand)
            .all(|(own, hand)| close(*own, hand))
    );
    assert_eq!(holm(&[0.9, 0.8]), [1.0, 1.0]);
}

#[test]
fn tests_that_cannot_tell_do_not_cost_those_that_can() {
    let least = [20, 4, 4, 4, 4, 4, 5].map(least_probability);
    // Five pairs give 0.031 at least, which becomes 0.062 beside a second such test.
    let worth = [true, false, false, false, false, false, false];
    assert_eq!(worth_making(&least, 0.05), worth);
    assert_eq!(worth_making(&[5].map(least_probability), 0.05), [true]);
    assert_eq!(
        worth_making(&[5, 5].map(least_probability), 0.05),
        [false, false]
    );
    assert_eq!(
        worth_making(&[6, 6, 6].map(least_probability), 0.05),
        [true, true, true]
    );
}

fn differences() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-9i32..=9).prop_map(f64::from), 0..16)
}

proptest! {
    #[test]
    fn the_signed_rank_test_counts_what_trying_every_sign_finds(differences in differences()) {
        let kept: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
        // Twice the mean rank, from the numbers of smaller and of equal magnitudes.
        let rank = |d: &f64| {
            let smaller = kept.iter().filter(|e| e.abs() < d.abs()).count();
            let equal = kept.iter().filter(|e| e.abs() == d.abs()).count();
            2 * smaller + equal + 1
        };
        let ranks: Vec<usize> = kept.iter().map(rank).collect();
        let all: usize = ranks.iter().sum();
        let off = |above: usize| (2 * above).abs_diff(all);
        let above: usize = kept.iter().zip(&ranks).filter(|(d, _)| **d > 0.0).map(|(_, r)| r).sum();
        let signs = 1u32 << kept.len();
        let as_far = (0..signs).filter(|signs| {
            let chosen = ranks.iter().enumerate().filter(|(i, _)| signs >> i & 1 == 1);
            off(chosen.map(|(_, rank)| rank).sum()) >= off(above)
        });
        let share = as_far.count() as f64 / f64::from(signs);
        prop_assert!((signed_rank_test(&differences).either() - share).abs() < 1e-12);
    }

    #[test]
    fn neither_side_is_favoured_and_no_probability_is_below_the_least(differences in differences()) {
        let turned: Vec<f64> = differences.iter().map(|d| -d).collect();
        let least = least_probability(differences.len());
        for test in [sign_test, signed_rank_test] {
            let (own, other) = (test(&differences), test(&turned));
            prop_assert_eq!((own.above, own.below), (other.below, other.above));
            for side in [own.above, own.below] {
                prop_assert!((least * (1.0 - 1e-12)..=1.0).contains(&side));
            }
        }
    }

    /// Whatever the distribution: the true median is above the bound in at most 5 % of draws.
    #[test]
    fn the_median_s_bound_leaves_out_no_more_than_its_level(n in 5usize..40) {
        // A draw is below the true median or not: all that counts. Each pattern has the same probability.
        let outside = outside_median(n, 0.9);
        prop_assert!(at_most(outside, n, 0.5) <= 0.05 && at_most(outside + 1, n, 0.5) > 0.05);
        let values: Vec<f64> = (0..n).map(|i| i as f64).collect();
        prop_assert_eq!(median_at_most(&values, 0.05), (n - 1 - outside) as f64);
    }

    #[test]
    fn holm_raises_the_least_as_bonferroni_does_and_the_others_by_no_more(
        probabilities in prop::collection::vec(0.0f64..=1.0, 1..20),
    ) {
        let raised = holm(&probabilities);
        let bonferroni = |p: f64| (p * probabilities.len() as f64).min(1.0);
        let mut pairs: Vec<(f64, f64)> = probabilities.iter().copied().zip(raised).collect();
        pairs.sort_by(|one, other| one.0.total_cmp(&other.0));
        prop_assert_eq!(pairs[0].1, bonferroni(pairs[0].0));
        for (own, raised) in &pairs {
            prop_assert!(own <= raised && *raised <= bonferroni(*own));
        }
        prop_assert!(pairs.is_sorted_by(|one, other| one.1 <= other.1), "in the order that they had");
    }
}
