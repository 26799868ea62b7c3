//! Faults of the ends, in real runs: done as asked, and told by the manifest.

use std::fs;
use std::path::Path;

use endpoint::Policy;
use plan::{Cell, End, EndEffect, Verdict};

use crate::webloop::{column, run_undisturbed};

const MS: u64 = 1_000_000;

/// Faults of each kind over a link that loses nothing.
const HITS: &str = r#"
name = "hits"

[[cells]]
topology = ["couva"]
system = ["motor-load"]
fault = ["still-controller", "still-plant", "starved", "gone-controller", "gone-plant"]
client = ["native"]
mode = "closed"
h = ["10ms"]
hold = "200ms"
lease = "address"
duration = "2500ms"

[[fault]]
name = "still-controller"
event = [{ at = "500ms", for = "250ms", freeze = "controller" }]
[[fault]]
name = "still-plant"
event = [{ at = "500ms", for = "250ms", period = "700ms", times = 2, freeze = "plant" }]
[[fault]]
name = "starved"
event = [
  { at = "300ms", for = "400ms", starve = "controller", share = "70%" },
  { at = "900ms", for = "400ms", starve = "plant", share = "70%" },
]
[[fault]]
name = "gone-controller"
event = [{ at = "500ms", for = "250ms", kill = "controller" }]
[[fault]]
name = "gone-plant"
event = [{ at = "500ms", for = "250ms", kill = "plant" }]
"#;

/// The other client that goes on where it was killed.
const PYTHON: &str = r#"
[[cells]]
topology = ["couva"]
fault = ["gone-controller", "gone-plant"]
client = ["python"]
mode = "closed"
h = ["10ms"]
duration = "4s"
"#;

/// Ends that ask for no real-time scheduling, on a machine that is kept busy.
const BUSY: &str = r#"
[[cells]]
topology = ["buccoo"]
fault = ["none", "loaded"]
client = ["native"]
scheduling = "other"
mode = "closed"
h = ["10ms"]
duration = "2s"

[[fault]]
name = "loaded"
event = [{ at = "200ms", for = "1h", busy = 3 }]
"#;

/// Runs an experiment's cells on a back-end and checks what became of each.
fn hit_each(backend: &str, experiment: &str) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hits.toml");
    fs::write(&file, experiment).unwrap();
    let out = folder.path().join("out");
    let mut latest_ms: f64 = 0.0;
    for manifest in run_undisturbed(&file, &out, backend)? {
        let cell = &manifest.cell;
        assert_eq!(
            manifest.verdict,
            Verdict::Complete,
            "{}: {:?}",
            cell.id,
            manifest.reasons
        );
        assert_eq!(
            manifest.end_faults.is_empty(),
            cell.fault.is_none(),
            "{}",
            cell.id
        );
        if cell.scheduling == Policy::Other {
            look_at_scheduling(&out.join(cell.folder()));
        }
        for done in &manifest.end_faults {
            latest_ms = latest_ms.max((done.from_ns - done.asked_from_ns) as f64 * 1e-6);
            if done.effect == EndEffect::Kill {
                look_at_gap(
                    &out.join(cell.folder()),
                    cell,
                    done.end,
                    [done.from_ns, done.to_ns],
                );
            }
        }
    }
    println!(
        "  {backend}: each fault of an end was done as asked, {latest_ms:.1} ms late at the most"
    );
    Ok(())
}

/// Both ends ran as ordinary programs do.
fn look_at_scheduling(folder: &Path) {
    for (file, thread) in [("plant.json", "ticker"), ("controller.json", "controller")] {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        let report: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(report["granted"][thread]["policy"], "other", "{file}");
    }
}

/// The rows of an end that was killed: none while it was gone, and before and after it on one grid, each once.
fn look_at_gap(folder: &Path, cell: &Cell, end: End, [from_ns, to_ns]: [u64; 2]) {
    let h_ns = cell.settings.h.ns();
    let (file, number) = match end {
        End::Controller => ("messages.csv", "seq"),
        End::Plant => ("ticks.csv", "k"),
    };
    let text = fs::read(folder.join(file)).unwrap();
    let numbers = |name: &str| -> Vec<u64> {
        let column = column(&text, name);
        column.iter().map(|text| text.parse().unwrap()).collect()
    };
    let mut rows: Vec<(u64, u64)> = numbers(number)
        .into_iter()
        .zip(numbers("t_due_ns"))
        .collect();
    rows.sort_unstable();
    let (before, after): (Vec<(u64, u64)>, Vec<_>) =
        rows.iter().partition(|(_, t_ns)| *t_ns < from_ns);
    let (first, first_ns) = rows[0];
    // A journal is flushed each 0.1 s, and what it had not written is lost with its process.
    let last_ns = before.last().unwrap().1;
    assert!(
        before.len() > 10 && from_ns - last_ns < 300 * MS,
        "{}: the last of {} rows, {} ms before it was killed",
        folder.display(),
        before.len(),
        (from_ns - last_ns) / MS
    );
    // How long it takes to start is the machine's affair; from then on it goes on to the end.
    let back_ns = after.first().unwrap().1;
    assert!(back_ns + h_ns >= to_ns.min(from_ns + 250 * MS));
    let left = (first_ns + cell.duration_ns - back_ns) / h_ns;
    assert!(
        left > 0 && 10 * after.len() as u64 >= 9 * left,
        "{}: {} rows of {left} after it came back, {} ms after it was killed",
        folder.display(),
        after.len(),
        (back_ns - from_ns) / MS
    );
    assert!(
        rows.iter()
            .all(|(n, t_ns)| *t_ns == first_ns + (n - first) * h_ns),
        "{}",
        folder.display()
    );
    assert!(
        rows.windows(2).all(|pair| pair[0].0 < pair[1].0),
        "{}",
        folder.display()
    );
}

#[allow(dead_code)] // The two test programs that share this file need one each.
pub(crate) fn a_fault_of_an_end_is_done_as_asked() -> Result<(), String> {
    hit_each("netns", &format!("{HITS}{PYTHON}{BUSY}"))
}

#[allow(dead_code)]
pub(crate) fn a_fault_of_an_end_is_done_in_containers_too() -> Result<(), String> {
    // One of each sort, since containers take their time to come and go.
    let all = HITS
        .lines()
        .find(|line| line.starts_with("fault ="))
        .unwrap();
    let some = HITS.replace(all, "fault = [\"still-controller\", \"gone-plant\"]");
    hit_each("compose", &some)
}
