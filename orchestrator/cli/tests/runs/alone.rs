//! Of two runs into one folder, only one runs.

use std::process::Child;
use std::time::{Duration, Instant};

use crate::ending::kill;
use crate::webloop::{Experiment, code, command, said};

pub(crate) fn of_two_runs_into_one_folder_one_runs() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["office"], "3ms", "6s");
    // Started at once, so that both find the folder empty. The kernel decides which one wins.
    let mut runs = [(); 2].map(|()| experiment.run(command()).spawn().unwrap());
    // Being refused takes some ms; the run itself takes 10 s.
    let within = Duration::from_secs(2);
    let started = Instant::now();
    let ended = |run: &mut Child| run.try_wait().unwrap().is_some();
    while started.elapsed() < within && !runs.iter_mut().any(ended) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let [mut winner, loser] = match runs.each_mut().map(ended) {
        [false, true] => runs,
        [true, false] => {
            let [a, b] = runs;
            [b, a]
        }
        other => panic!("of two runs, have ended: {other:?}"),
    };
    let refused = loser.wait_with_output().unwrap();
    assert_eq!(code(&refused), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("in use"), "{}", said(&refused));
    assert!(said(&refused).contains("--out"), "{}", said(&refused));

    // The other one goes on.
    std::thread::sleep(Duration::from_secs(1));
    assert!(!ended(&mut winner));
    kill(&mut winner, &experiment.out);
    Ok(())
}
