//! A kernel that has netem, with an engine of its own, where this machine's kernel has none: what its one slow core
//! can show. What only a quick machine can show, arms compared, is in `arms`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use link::certificate::{Beside, EachWay, LinkReport, OneWay};
use plan::Verdict;

use crate::docker::{TOP, docker};
use crate::webloop::{Experiment, code, manifest, said, too_busy, was_busy};

/// Time limit of a guest: an engine, its images and a testbed take two to three minutes on its one slow
/// core, a cell a quarter of a minute.
const TIMEOUT_S: &str = "600";

/// Exit code of a guest that exceeded this limit.
const ENDED: i32 = 124;

/// What a cell says that failed since an agent took too long.
pub(crate) const UNANSWERED: &str = "no answer in time";

fn run() -> Command {
    Command::new(Path::new(TOP).join("netem/kernel/run"))
}

/// Whether this machine's own kernel has no netem.
pub(crate) fn is_needed() -> bool {
    !run().arg("--check").output().unwrap().status.success()
}

/// Whether the kernel with netem would run in QEMU without KVM: `netem/kernel/run` takes it where the processor
/// has AMX. An engine and its images take minutes in it, and every cell is held up.
fn is_emulated() -> bool {
    let processor = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    processor.contains("amx_tile") && !Path::new("/dev/kvm").exists()
}

/// The program in a guest, with an engine that has the images; they are kept beside `file` meanwhile.
pub(crate) fn webloop(file: &Path) -> Result<Command, String> {
    if is_emulated() {
        return Err(too_busy("an engine in an emulated kernel"));
    }
    // Whoever types `cargo test` does not expect packages to be installed.
    let ready = run().args(["--no-install", "--", "true"]).output().unwrap();
    if !ready.status.success() {
        return Err(said(&ready).trim().to_owned());
    }
    let images = file.with_file_name("images.tar");
    let path = images.display().to_string();
    docker(&[
        "save",
        "--output",
        &path,
        "webloop",
        "webloop-link",
        "webloop-native",
    ])?;
    let mut guest = run();
    guest
        .args(["--no-install", "--timeout", TIMEOUT_S, "--docker"])
        .arg(images)
        .args(["--", env!("CARGO_BIN_EXE_webloop")]);
    Ok(guest)
}

/// Whether a guest exceeded its time limit on a machine that has no time for it: its cells were held up.
pub(crate) fn has_no_time(output: &Output, stolen: &serial::Stolen) -> bool {
    code(output) == Some(ENDED)
        && (said(output).contains("the machine was held up") || stolen.is_much())
}

/// Checks what two players by tc report: that netem was set on both ways, and carried the run's packets.
pub(crate) fn played_by_tc(link: &EachWay) {
    for way in [&link.up, &link.down] {
        let OneWay::Tc(Beside { report: tc, .. }) = way else {
            panic!("{way:?}");
        };
        // Output of `tc -s qdisc`, and what was there before, which is not netem.
        assert_eq!(tc.first[0]["kind"], "netem", "{tc:?}");
        let last = &tc.last[0];
        assert_eq!(last["kind"], "netem", "{tc:?}");
        assert!(last["packets"].as_u64().unwrap() > 100, "{last}");
        assert_ne!(tc.found[0]["kind"], "netem", "{tc:?}");
    }
}

/// One short run in a guest: on however slow a machine, tc plays both ways and the run is judged. If the run
/// was held up, that is all that this guest can show, and an error.
pub(crate) fn plays_a_link() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["buccoo"], "20ms", "2s");
    let mut command = experiment.run(webloop(&experiment.file)?);
    command.args(["--backend", "compose", "--no-build", "--player", "tc"]);
    command.args(["--tries", "1", "--no-report"]);
    let stolen = serial::Stolen::since_now();
    let output = command.output().unwrap();
    if has_no_time(&output, &stolen) {
        return Err(too_busy("the guest"));
    }
    assert!(matches!(code(&output), Some(0 | 1)), "{}", said(&output));
    let manifest = manifest(&experiment.cells()[0]);
    let reasons = manifest.reasons.join("; ");
    println!("  a short run by tc: {}: {reasons}", manifest.verdict);
    if reasons.contains(UNANSWERED) {
        return Err(too_busy("the guest"));
    }
    assert_eq!(manifest.player, "tc");
    if let Some(LinkReport::Each(link)) = &manifest.link {
        played_by_tc(link);
    } else {
        // Whatever was too slow to start has not played.
        assert!(was_busy(&manifest), "{}: {reasons}", manifest.verdict);
    }
    match manifest.verdict {
        Verdict::Complete => Ok(()),
        verdict => {
            assert!(was_busy(&manifest), "{verdict}: {reasons}");
            Err(too_busy("the guest"))
        }
    }
}
