//! Runs the same cell in each way: in namespaces, in containers, and in containers whose link the
//! kernel's netem plays. The link and the loop have to behave alike.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use analysis::statistics::{Quantiles, median};
use analysis::{CellFacts, Metrics};
use link::certificate::LinkReport;
use link::certificate::Verdict::Holds;
use plan::{Phase, ProbeRow, Verdict};
use record::Manifest;

use crate::guest::{self, played_by_tc};
use crate::webloop::{Experiment, code, command, doctor, manifest, said, too_busy, was_busy};

/// Nothing is begun after this time: a machine that needs longer is too busy.
const LONGEST: Duration = Duration::from_secs(4 * 60);

/// Round trips agree within the larger of the two. The link is the same, and the player's cost is
/// measured by echoes on the empty link and subtracted.
const RTT_SHARE: f64 = 0.05;
const RTT_MS: f64 = 0.5;

/// While a delay falls, netem is changed in steps of this length.
const TC_STEP_MS: f64 = 2.0;

/// One way to run a cell.
struct Arm {
    backend: &'static str,
    player: &'static str,
    /// How often the cells are run at the most until none was disturbed.
    tries: usize,
    /// How far round trips may be off in addition.
    step_ms: f64,
    /// How far settling may be off, as a share of its value in namespaces: over buccoo, where the
    /// loop is well damped, and over diego-vpn, where it rings and each half-wave that is just
    /// inside 2 % or just outside makes it 15 % longer.
    settling_shares: [f64; 2],
    /// Builds the command that runs the experiment, or says why this machine cannot.
    command: fn(&Experiment) -> Result<Command, String>,
}

const ARMS: [Arm; 3] = [
    Arm {
        backend: "netns",
        player: "user",
        tries: usize::MAX,
        step_ms: 0.0,
        settling_shares: [0.0, 0.0],
        command: in_namespaces,
    },
    Arm {
        backend: "compose",
        player: "user",
        tries: usize::MAX,
        step_ms: 0.0,
        settling_shares: [0.1, 0.2],
        command: in_containers,
    },
    Arm {
        backend: "compose",
        player: "tc",
        // Each costs minutes, and a guest that was too slow once is too slow again.
        tries: 1,
        step_ms: TC_STEP_MS,
        // Two half-waves. Seen in the guest: 1620 and 1720 ms where it is 1430 in namespaces.
        settling_shares: [0.2, 0.35],
        command: in_containers_by_tc,
    },
];

/// 100 Hz: at the paper's 333 Hz the guest's one slow core misses a third of the messages, which
/// makes another loop.
const H: &str = "10ms";

/// One over which the loop rings little, and one over which it rings much. Not couva: whether the
/// last of its spikes is inside 2 % depends on one message, so settling jumps by half between two
/// runs of equal links.
const TOPOLOGIES: [&str; 2] = ["buccoo", "diego-vpn"];

/// Number of pairs over equal links to compare; the middle one counts. A machine that holds up a
/// single message in the first third of a second changes a step response. (In virtual time, where
/// nothing is held up, forty repeats over buccoo settle within one tick of each other.)
const REPEATS: usize = 3;

/// How often an arm, and with it the one in namespaces, is run until the two agree. A machine that
/// is slow for minutes spoils two of three pairs; arms that really differ fail each time.
const COMPARISONS: usize = 3;

/// The figures to compare.
#[derive(Debug, Clone)]
struct Measured {
    rtt_p50_ms: f64,
    rtt_p90_ms: f64,
    settling_ms: f64,
}

pub(crate) fn the_same_cell_gives_the_same_in_namespaces_in_containers_and_by_tc()
-> Result<(), String> {
    doctor(command())?;
    let [reference, others @ ..] = &ARMS;
    let deadline = Instant::now() + LONGEST;
    let mut by_reference = measure(reference, deadline)?;
    for arm in others {
        for left in (0..COMPARISONS).rev() {
            let by_arm = match measure(arm, deadline) {
                Ok(by_arm) => by_arm,
                Err(lack) => {
                    println!("  SKIPPED {} by {}: {lack}", arm.backend, arm.player);
                    break;
                }
            };
            match agree(arm, &by_arm, &by_reference) {
                Ok(()) => break,
                Err(apart) => {
                    assert!(left > 0, "{apart}");
                    println!("  once more, because {apart}");
                    by_reference = measure(reference, deadline)?;
                }
            }
        }
    }
    Ok(())
}

/// The repeats of each topology by an arm, or why this machine cannot run it.
fn measure(arm: &Arm, deadline: Instant) -> Result<[Vec<Measured>; 2], String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &TOPOLOGIES, H, "4s").repeated(REPEATS);
    let cells = run(arm, &experiment, deadline)?;
    Ok(TOPOLOGIES.map(|topology| {
        let own = cells
            .iter()
            .filter(|cell| manifest(cell).cell.topology == topology);
        let repeats: Vec<Measured> = own.map(|cell| Measured::of(cell)).collect();
        assert_eq!(repeats.len(), REPEATS);
        let (backend, player) = (arm.backend, arm.player);
        println!("  {backend} by {player}, {topology}: {repeats:.1?}");
        repeats
    }))
}

/// Runs the cells until their runs are valid. Returns their folders.
fn run(arm: &Arm, experiment: &Experiment, deadline: Instant) -> Result<Vec<PathBuf>, String> {
    for _ in serial::tries().take(arm.tries) {
        if Instant::now() > deadline {
            break;
        }
        let stolen = serial::Stolen::since_now();
        let output = (arm.command)(experiment)?.output().unwrap();
        let exit = code(&output);
        if guest::has_no_time(&output, &stolen) {
            return Err(too_busy("the guest"));
        }
        assert!(matches!(exit, Some(0 | 1)), "{exit:?}: {}", said(&output));
        let cells = experiment.cells();
        let manifests: Vec<Manifest> = cells.iter().map(|cell| manifest(cell)).collect();
        let mut busy = false;
        for manifest in &manifests {
            if manifest.verdict != Verdict::Complete {
                let reasons = manifest.reasons.join("; ");
                // On the guest's one slow core an agent may take longer than is waited for it.
                if arm.tries == 1 && reasons.contains(guest::UNANSWERED) {
                    println!("  {reasons}");
                    return Err(too_busy("the guest"));
                }
                assert!(
                    was_busy(manifest) || stolen.is_much(),
                    "{}: {reasons}",
                    manifest.verdict
                );
                println!("  too busy: {:?}", manifest.reasons);
                busy = true;
            }
        }
        if !busy {
            manifests
                .iter()
                .for_each(|manifest| proves_itself(manifest, arm));
            return Ok(cells);
        }
    }
    Err(too_busy("the link"))
}

fn proves_itself(manifest: &Manifest, arm: &Arm) {
    assert_eq!(manifest.backend, arm.backend);
    assert_eq!(manifest.player, arm.player);
    let certificate = manifest.certificate.as_ref().unwrap();
    assert_eq!(certificate.verdict, Holds, "{certificate:?}");
    if arm.backend == "compose" {
        let engine = manifest.engine.as_deref().unwrap_or_default();
        assert!(engine.contains("Compose"), "{engine}");
    }
    if arm.player == "tc" {
        let Some(LinkReport::Each(link)) = &manifest.link else {
            panic!("{:?}", manifest.link);
        };
        played_by_tc(link);
    }
}

impl Measured {
    /// From the echoes at the same instants of link time, and from the response.
    fn of(cell: &Path) -> Measured {
        let manifest = manifest(cell);
        let baseline_ms = manifest.certificate.as_ref().unwrap().baseline.rtt_ms;
        let rtts_ns: Vec<u64> = csv::Reader::from_path(cell.join("probes.csv"))
            .unwrap()
            .into_deserialize()
            .map(Result::<ProbeRow, _>::unwrap)
            .filter(|row| matches!(row.phase, Phase::Before | Phase::During))
            .filter_map(|row| Some(row.t_back_ns? - row.t_send_ns))
            .collect();
        let rtts = Quantiles::of(rtts_ns);
        let metrics = Metrics::read(cell, &CellFacts::from(&manifest.cell)).unwrap();
        Measured {
            rtt_p50_ms: rtts.p50_ms.unwrap() - baseline_ms,
            rtt_p90_ms: rtts.p90_ms.unwrap() - baseline_ms,
            // A run that was held up may not settle in its time; the others decide.
            settling_ms: metrics
                .response
                .and_then(|response| response.settling_ms)
                .unwrap_or(f64::INFINITY),
        }
    }
}

/// Whether two arms' repeats agree, in each topology and figure.
fn agree(
    arm: &Arm,
    own: &[Vec<Measured>; 2],
    reference: &[Vec<Measured>; 2],
) -> Result<(), String> {
    for (n, topology) in TOPOLOGIES.iter().enumerate() {
        let near =
            |what: &str, of: fn(&Measured) -> f64, share: f64, [least_ms, step_ms]: [f64; 2]| {
                let (off_ms, usual_ms) = off(&own[n], &reference[n], of);
                let within_ms = (usual_ms * share).max(least_ms) + step_ms;
                if off_ms.abs() <= within_ms {
                    Ok(())
                } else {
                    Err(format!(
                        "over {topology} by {} {what} is {off_ms:.2} ms off {usual_ms:.2} ms in \
                     namespaces; they are to agree within {within_ms:.2} ms",
                        arm.player
                    ))
                }
            };
        let of_rtt = [RTT_MS, arm.step_ms];
        near(
            "the median round trip",
            |of| of.rtt_p50_ms,
            RTT_SHARE,
            of_rtt,
        )?;
        near("the 90 % round trip", |of| of.rtt_p90_ms, RTT_SHARE, of_rtt)?;
        near(
            "settling",
            |of| of.settling_ms,
            arm.settling_shares[n],
            [0.0; 2],
        )?;
    }
    Ok(())
}

/// How far a figure of one arm is off the other's, and its value there. Repeats have their links in
/// common one by one, so this is the median of their differences.
fn off(own: &[Measured], reference: &[Measured], of: fn(&Measured) -> f64) -> (f64, f64) {
    let pairs = std::iter::zip(own, reference);
    let differences: Vec<f64> = pairs
        .map(|(own, reference)| of(own) - of(reference))
        .collect();
    let usual: Vec<f64> = reference.iter().map(of).collect();
    // If neither loop settled there is no difference, and nothing agrees.
    let middle = |values: &[f64]| median(values).unwrap_or(f64::NAN);
    (middle(&differences), middle(&usual))
}

fn in_namespaces(experiment: &Experiment) -> Result<Command, String> {
    Ok(experiment.run(command()))
}

fn in_containers(experiment: &Experiment) -> Result<Command, String> {
    let mut command = experiment.run(command());
    command.args(["--backend", "compose", "--no-build", "--player", "user"]);
    Ok(command)
}

/// Runs on this machine's kernel, or in one that has netem, if that is quick enough to compare it.
fn in_containers_by_tc(experiment: &Experiment) -> Result<Command, String> {
    let mut command = if guest::is_needed() {
        guest::plays_a_link()?;
        guest::webloop(&experiment.file)?
    } else {
        command()
    };
    command = experiment.run(command);
    command.args(["--backend", "compose", "--no-build", "--player", "tc"]);
    if guest::is_needed() {
        command.args(["--tries", "1"]);
    }
    Ok(command)
}
