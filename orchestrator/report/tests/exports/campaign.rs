//! A small results folder, and a report of it with claims of its own.

use std::fs;
use std::path::{Path, PathBuf};

use analysis::Campaign;
use analysis::expect::Judgement;
use link::Epoch;
use plan::{Instead, Plan, ProfileText, Verdict};
use record::{FileFact, Machine, Manifest};
use report::Report;
use report::claim::{self, Finding, Part};
use report::group::Estimate;

const EXPERIMENT: &str = r#"
name = "exports"
about = "Four cells, of which two are run"
[[cells]]
topology = ["arima", "buccoo"]
client = ["native", "python"]
mode = "open"
h = ["100ms"]
duration = "200ms"
"#;

pub(crate) fn plan() -> Plan {
    let profile = |name: &str| {
        let source = link::Profile::builtin(name).expect("built in").to_owned();
        Ok(ProfileText {
            source,
            ..ProfileText::default()
        })
    };
    Plan::resolve(EXPERIMENT, "exports.toml", &Instead::default(), profile).expect("an experiment")
}

/// The files of a cell: two messages of an open loop, and of a link its first second.
const FILES: [(&str, &str); 7] = [
    (
        "ticks.csv",
        "k,t_due_ns,t_tick_ns,u,y,seq\n0,5000000000,5000001000,0.0,0.0,\n1,5100000000,5100001000,0.0,0.0,\n",
    ),
    (
        "arrivals.csv",
        "n,seq,t_send_ns,t_arrive_ns,tick,u,outcome\n0,0,5000100000,5000200000,0,1.0,acknowledged\n",
    ),
    (
        "messages.csv",
        "seq,t_due_ns,t_send_ns,t_receive_ns,t_arrive_ns,r,y,e,u,tick,outcome\n\
         0,5000100000,5000100000,5000300000,5000200000,1.0,,,1.0,,answered\n\
         1,5100100000,,,,1.0,,,,,missed\n",
    ),
    (
        "probes.csv",
        "phase,seq,t_send_ns,t_reach_ns,t_back_ns,due_up_ns,due_down_ns,due_lost\n\
         during,0,9000000,11000000,13030000,2000000,2000000,false\n",
    ),
    (
        "plant.json",
        r#"{"tick_rows":{"rows":2,"overflow":0},"arrival_rows":{"rows":1,"overflow":0}}"#,
    ),
    (
        "controller.json",
        r#"{"start_ns":5000100000,"stop_ns":5200100000,
            "counts":{"due":2,"sent":1,"missed":1,"answered":1,"timeout":0,"failed":0},
            "first_failure":null,"interrupted":false,"rows":{"rows":2,"overflow":0},
            "granted":{"controller":{"asked_priority":null,"policy":"other","priority":0,
                                     "slack_ns":50000,"refused":null},"open_files":1024}}"#,
    ),
    (
        "link.csv",
        "t_ns,way,packets,bytes,delivered,lost,overflow,foreign,dropped,late_mean_us,late_max_us\n\
         6000000000,up,64,5328,64,0,0,0,0,30.5,182.697\n",
    ),
];

/// A results folder with the first cell complete and the second invalid.
pub(crate) fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plan = plan();
    fs::write(folder.path().join("plan.json"), plan.to_json()).expect("a writable folder");
    let verdicts = [Verdict::Complete, Verdict::Invalid];
    for (second, (cell, verdict)) in plan.cells.iter().zip(verdicts).enumerate() {
        let path = folder.path().join(cell.folder());
        fs::create_dir_all(&path).expect("a writable folder");
        let profile = plan.profiles[&cell.topology].source.as_str();
        let files = FILES.into_iter();
        let files: Vec<_> = files.chain([("profile.toml", profile)]).collect();
        for (name, text) in &files {
            fs::write(path.join(name), text).expect("a writable folder");
        }
        let fact = |text: &str| FileFact::of(text.as_bytes()).expect("memory");
        let reason = "the link was <late> & \"lost\"\nits way".to_owned();
        let manifest = Manifest {
            version: Manifest::VERSION,
            verdict,
            reasons: (verdict == Verdict::Invalid)
                .then_some(reason)
                .into_iter()
                .collect(),
            disturbances: Vec::new(),
            earlier: Vec::new(),
            experiment: plan.experiment.clone(),
            campaign_seed: plan.seed,
            cell: cell.clone(),
            profile: cell.topology.clone(),
            backend: "netns".to_owned(),
            engine: None,
            player: "user".to_owned(),
            webloop: "0.1.0".to_owned(),
            machine: Machine {
                kernel: "Linux 6.1.0".to_owned(),
                architecture: "x86_64".to_owned(),
                processor: "unknown".to_owned(),
                cores: 2,
                memory_mib: 2048,
                clock_source: "tsc".to_owned(),
                awake: false,
            },
            authority: "privileged".to_owned(),
            started: format!("2026-01-01T00:00:0{second}Z"),
            wall_s: 2.5,
            epoch: Epoch::at_ns(0),
            start_ns: 5_000_000_000,
            messages: None,
            pulse: None,
            watched: None,
            end_faults: Vec::new(),
            ends: None,
            certificate: None,
            plant: None,
            controller: None,
            page: None,
            link: None,
            files: files
                .iter()
                .map(|(name, text)| ((*name).to_owned(), fact(text)))
                .collect(),
        };
        let json = manifest.to_json();
        fs::write(path.join(Manifest::FILE), json).expect("a writable folder");
    }
    folder
}

pub(crate) fn finding(id: &'static str, verdict: claim::Verdict, value: f64) -> Finding {
    let ours = Estimate {
        value,
        low: value,
        high: value,
        n: 20,
    };
    Finding {
        id,
        place: "Fig 6b",
        claim: "a step over the VPN settles later",
        check: "3 to 5 times that on arima".to_owned(),
        reading_of: None,
        verdict,
        reason: format!("it settles {value} times as late | later"),
        parts: vec![Part::judged(
            "settling",
            "",
            Some(4.0),
            Some(ours),
            (3.0, 5.0),
        )],
        runs: Vec::new(),
    }
}

/// A report of a campaign with two claims of its own.
pub(crate) fn report(campaign: &Campaign) -> Report<'_> {
    Report {
        campaign,
        brief: Vec::new(),
        claims: vec![
            finding("fig-6b-agrees", claim::Verdict::Agrees, 4.2),
            finding("fig-6b-differs", claim::Verdict::Differs, 7.0),
        ],
        tables: Vec::new(),
        figures: Vec::new(),
        damage: campaign.damage(),
        expectations: Judgement::default(),
    }
}

pub(crate) fn read(folder: &Path) -> Campaign {
    Campaign::read(folder).expect("a results folder")
}

/// Two files of a report, one of them a table.
pub(crate) fn files() -> Vec<(PathBuf, Vec<u8>)> {
    let csv = b"topology,the paper avg/ms\narima,0.108\ncouva,\n".to_vec();
    vec![
        ("report.html".into(), b"<p>".to_vec()),
        ("tables/table-2.csv".into(), csv),
    ]
}
