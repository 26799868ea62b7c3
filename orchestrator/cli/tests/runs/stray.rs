//! A fault that was asked for is no cover for a stop that nobody asked for.

use std::fs;
use std::thread;
use std::time::Duration;

use plan::Verdict;
use rustix::process::{Pid, Signal, kill_process};

use crate::ending::await_rows;
use crate::process;
use crate::webloop::{Experiment, command, manifest, too_busy, was_busy};

/// A run whose plant stands still as asked, and whose controller is stopped by somebody else.
pub(crate) fn a_fault_that_was_asked_for_hides_no_other() -> Result<(), String> {
    for _ in serial::tries() {
        let folder = tempfile::tempdir().unwrap();
        let experiment = Experiment::new(folder.path(), &["couva"], "10ms", "4s");
        let mut text = fs::read_to_string(&experiment.file).unwrap();
        text += "fault = [\"short\"]\n[[fault]]\nname = \"short\"\n[[fault.event]]\nat = \"3s\"\nfor = \"200ms\"\nfreeze = \"plant\"\n";
        fs::write(&experiment.file, text).unwrap();
        let mut run = experiment
            .run(command())
            .args(["--tries", "1"])
            .spawn()
            .unwrap();
        await_rows(&mut run, &experiment);
        let is_controller = |pid: &u32| {
            let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            String::from_utf8_lossy(&line).contains("serve\0controller")
        };
        let processes = process::of_run(&experiment.out);
        let controller = processes.into_iter().find(is_controller).unwrap();
        let controller = Pid::from_raw(controller.cast_signed()).unwrap();
        kill_process(controller, Signal::STOP).unwrap();
        thread::sleep(Duration::from_millis(300));
        kill_process(controller, Signal::CONT).unwrap();
        run.wait_with_output().unwrap();
        let manifest = manifest(&experiment.cells()[0]);
        let told = manifest.reasons.join("; ");
        if was_busy(&manifest) && !told.contains("the controller was") {
            println!("  too busy: {told}");
            continue;
        }
        assert_eq!(manifest.verdict, Verdict::Disturbed, "{told}");
        assert!(told.contains("the controller was"), "{told}");
        assert_eq!(manifest.end_faults.len(), 1);
        return Ok(());
    }
    Err(too_busy("this run"))
}
