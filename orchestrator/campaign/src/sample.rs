//! Made-up plans, manifests and clocks, for tests.

use std::sync::atomic::{AtomicU64, Ordering};

use plan::{Cell, Instead, Plan, ProfileText, Verdict};
use record::Manifest;
use serde_json::json;

/// A clock that advances by an hour at each reading, so that every start is due.
pub(crate) fn now_ns() -> u64 {
    static HOURS: AtomicU64 = AtomicU64::new(0);
    HOURS.fetch_add(1, Ordering::Relaxed) * 3_600_000_000_000
}

/// A plan of blocks, each with its clients, sample times, and how many cells may run together.
pub(crate) fn plan(blocks: &[(&str, &str, u16)]) -> Plan {
    let block = |(client, h, together): &(&str, &str, u16)| {
        format!(
            "[[cells]]\ntopology = [\"arima\"]\nclient = [{client}]\nmode = \"open\"\n\
             h = [{h}]\nduration = \"1s\"\ntogether = {together}\n"
        )
    };
    let blocks: String = blocks.iter().map(block).collect();
    resolve(&blocks)
}

/// A plan of blocks as written in an experiment.
pub(crate) fn resolve(blocks: &str) -> Plan {
    let profile = |name: &str| {
        let source = link::Profile::builtin(name).expect("built in").to_owned();
        Ok(ProfileText {
            source,
            ..ProfileText::default()
        })
    };
    let source = format!("name = \"mine\"\n{blocks}");
    Plan::resolve(&source, "mine.toml", &Instead::default(), profile).expect("an experiment")
}

/// The manifest of a cell's run that ended with this verdict.
pub(crate) fn manifest(cell: &Cell, verdict: Verdict, reasons: &[&str]) -> Manifest {
    let text = json!({
        "version": Manifest::VERSION,
        "verdict": verdict,
        "reasons": reasons,
        "experiment": "mine",
        "campaign_seed": 1,
        "cell": cell,
        "profile": cell.topology,
        "backend": "netns",
        "player": "user",
        "webloop": env!("CARGO_PKG_VERSION"),
        "machine": {
            "kernel": "", "architecture": "", "processor": "", "cores": 1, "memory_mib": 1,
            "clock_source": "",
        },
        "authority": "",
        "started": "",
        "wall_s": 0.0,
        "epoch_ns": 0,
        "start_ns": 0,
        "files": {},
    });
    Manifest::from_json(&text.to_string()).expect("a manifest")
}
