use plan::Plan;

use super::*;
use crate::sample::{now_ns, plan, resolve};

fn natives() -> Plan {
    plan(&[
        ("\"native\"", "\"100ms\", \"200ms\", \"300ms\"", 2),
        ("\"native\"", "\"10ms\"", 1),
        ("\"native\"", "\"20ms\", \"30ms\"", 3),
    ])
}

fn indices(jobs: Option<u16>) -> Vec<Vec<usize>> {
    let plan = natives();
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    let batches = batches(&cells, jobs);
    let of = |batch: &Vec<&Cell>| batch.iter().map(|cell| cell.index).collect();
    batches.iter().map(of).collect()
}

#[test]
fn as_many_run_together_as_the_most_particular_of_them_allows_in_order() {
    // 0 to 2 run in pairs, 3 alone, 4 and 5 in threes.
    assert_eq!(indices(None), [vec![0, 1], vec![2], vec![3], vec![4, 5]]);
}

#[test]
fn a_batch_is_of_equal_length_where_it_can_be_and_shorter_ones_fill_it_up() {
    let block = |h: &str, duration: &str| {
        format!(
            "[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"open\"\n\
             h = [{h}]\nduration = \"{duration}\"\ntogether = 3\n"
        )
    };
    let source = ["\"10ms\", \"20ms\"", "\"30ms\"", "\"40ms\", \"50ms\""];
    let lengths = ["1s", "9s", "1s"];
    let source: String = source
        .iter()
        .zip(lengths)
        .map(|(h, length)| block(h, length))
        .collect();
    let plan = resolve(&source);
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    let batches = batches(&cells, None);
    let indices = batches
        .iter()
        .map(|batch| batch.iter().map(|cell| cell.index));
    let indices: Vec<Vec<usize>> = indices.map(Iterator::collect).collect();
    assert_eq!(indices, [vec![0, 1, 3], vec![2, 4]]);
}

#[test]
fn jobs_say_it_for_all() {
    assert_eq!(indices(Some(1)), [[0], [1], [2], [3], [4], [5]]);
    assert_eq!(indices(Some(6)), [[0, 1, 2, 3, 4, 5]]);
}

#[test]
fn nobody_is_measured_before_the_last_of_its_batch_is_up_and_none_starts_beside_one_that_is() {
    let plan = plan(&[
        ("\"native\", \"python\"", "\"100ms\"", 8),
        ("\"chromium\", \"firefox\"", "\"100ms\", \"300ms\"", 8),
    ]);
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    for jobs in [None, Some(1), Some(2), Some(5)] {
        for batch in batches(&cells, jobs) {
            let turns = turns(&batch);
            let starts = turns.iter().map(|turn| turn.start_ns);
            assert!(starts.is_sorted(), "one after another");
            for turn in &turns {
                assert_eq!(usize::from(turn.together), batch.len());
                // It is up before any cell is measured.
                let up_ns = turn.start_ns + backend::lead_ns(turn.cell.client);
                assert!(turns.iter().all(|any| up_ns <= any.not_before_ns));
            }
            let clients = batch.iter().map(|cell| cell.client.spec().start_time);
            assert!(clients.is_sorted_by(|a, b| a >= b), "the slowest first");
        }
    }
}

#[test]
fn the_next_batch_begins_when_all_of_this_one_have_ended() {
    let plan = natives();
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    let queue = Queue::new(&cells, None, now_ns);
    let go_on = AtomicBool::new(false);
    let next = || {
        queue
            .next(&go_on)
            .map(|turn| (turn.cell.index, turn.together))
    };
    assert_eq!((next(), next()), (Some((0, 2)), Some((1, 2))));
    let third = std::thread::scope(|scope| {
        let third = scope.spawn(next);
        queue.end();
        std::thread::sleep(3 * POLL);
        assert!(
            !third.is_finished(),
            "one of the first two is still measured"
        );
        queue.end();
        third.join().expect("no panic")
    });
    assert_eq!(third, Some((2, 1)));
    for (index, together) in [(3, 1), (4, 2)] {
        queue.end();
        assert_eq!(next(), Some((index, together)));
    }
    assert_eq!((next(), next()), (Some((5, 2)), None));
}

#[test]
fn without_a_measurement_each_begins_as_soon_as_there_is_room() {
    let plan = natives();
    let cells: Vec<&Cell> = plan.cells.iter().collect();
    let queue = Queue::unmeasured(&cells, 2);
    assert_eq!(queue.workers(), 2);
    let stop = AtomicBool::new(false);
    let order = std::iter::from_fn(|| queue.next(&stop).map(|turn| turn.cell.index));
    assert!(order.eq(0..6));
}

#[test]
fn whoever_is_told_to_stop_begins_nothing() {
    let plan = natives();
    let queue = Queue::new(&plan.cells.iter().collect::<Vec<_>>(), None, now_ns);
    assert_eq!(queue.workers(), 2);
    assert!(queue.next(&AtomicBool::new(true)).is_none());
}
