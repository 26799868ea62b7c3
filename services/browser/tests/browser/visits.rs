//! Visits of real browsers to a plant that plays a script: every ending has its
//! name, and nothing is left of the browser. One after another, with limits
//! that a busy machine keeps.

use std::{
    fs,
    net::SocketAddr,
    path::Path,
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use crate::stand_in::{Request, Response, alone, engines, scratch, serve};
use browser::{Config, Confinement, Engine, Limits, VisitError, visit_until};
use endpoint::{Mode, Preset};
use tempfile::TempDir;

/// What the page does after it has claimed the session.
const BEAT: &str = "await fetch('/session/rows', {method: 'POST', body: ''});";
const PAUSE: &str = "await new Promise(done => setTimeout(done, 200));";

/// A page that claims the session, says what it is, and goes on with `script`.
fn page(script: &str) -> String {
    format!(
        "<!doctype html><title>test</title><script>(async () => {{\
         const client = `${{isSecureContext}} ${{crossOriginIsolated}} ${{typeof SharedArrayBuffer}}`;\
         await fetch('/session', {{method: 'POST', body: client}});\
         const end = outcome => fetch('/session/end', {{method: 'POST', body: outcome}});\
         {script} }})()</script>"
    )
}

/// A plant's session, as far as a launcher sees it.
struct Stage {
    state: &'static str,
    client: String,
    outcome: String,
    beats: u64,
    heard: Instant,
    /// What the page was told.
    query: String,
}

/// A plant whose page is `html`.
fn plant(html: String) -> (SocketAddr, Arc<Mutex<Stage>>) {
    let stage = Arc::new(Mutex::new(Stage {
        state: "free",
        client: String::new(),
        outcome: String::new(),
        beats: 0,
        heard: Instant::now(),
        query: String::new(),
    }));
    let shared = Arc::clone(&stage);
    let address =
        serve(move |request| answer(&mut shared.lock().expect("no panic"), &html, request));
    (address, stage)
}

fn answer(stage: &mut Stage, html: &str, request: &Request) -> Response {
    let path = (request.method.as_str(), request.path.as_str());
    if path.0 == "POST" {
        stage.heard = Instant::now();
    }
    match path {
        ("GET", "/") => {
            stage.query.clone_from(&request.query);
            return (200, "text/html", html.as_bytes().to_vec());
        }
        ("GET", "/session") => {
            let Stage {
                state,
                client,
                beats,
                heard,
                outcome,
                ..
            } = stage;
            let idle_ms = heard.elapsed().as_millis();
            let outcome = match outcome.as_str() {
                "" => "null".to_owned(),
                word => format!("\"{word}\""),
            };
            let text = format!(
                "{{\"state\":\"{state}\",\"client\":\"{client}\",\"commands\":{beats},\
                 \"rows\":{beats},\"idle_ms\":{idle_ms},\"outcome\":{outcome},\"reason\":\"so\"}}"
            );
            return (200, "application/json", text.into_bytes());
        }
        ("POST", "/session") => {
            stage.state = "held";
            stage.client.clone_from(&request.body);
        }
        ("POST", "/session/rows") => stage.beats += 1,
        ("POST", "/session/end") => {
            stage.state = "ended";
            stage.outcome.clone_from(&request.body);
        }
        ("GET", "/health") => {}
        _ => return (404, "text/plain", Vec::new()),
    }
    (200, "text/plain", Vec::new())
}

/// Limits of seconds, where the page is to break them.
fn limits() -> Limits {
    Limits {
        // What a busy machine takes to start a browser.
        open: Duration::from_secs(60),
        silence: Duration::from_secs(1),
        finish: Duration::from_secs(1),
        look: Duration::from_millis(100),
        ..Limits::default()
    }
}

fn config(engine: Engine, plant: SocketAddr, scratch: &TempDir, limits: Limits) -> Config {
    let preset = Preset::Worker;
    let mut settings = preset.settings(Mode::Closed, "3ms".parse().expect("a sample time"));
    settings.timeout_ns = 1_000_000_000;
    Config {
        engine,
        plant,
        settings,
        page: preset.page(),
        start_ns: None,
        duration_ns: 1_000_000_000,
        scratch: scratch.path().to_owned(),
        leash: |_| Ok(()),
        limits,
    }
}

/// A visit to a page, and that nothing is left of it. Each engine in turn.
fn visits(
    html: &str,
    limits: Limits,
    check: impl Fn(Result<endpoint::report::Visit, VisitError>, &Stage),
) {
    let _alone = alone();
    for engine in engines() {
        let scratch = scratch();
        let (address, stage) = plant(html.to_owned());
        let config = config(engine, address, &scratch, limits);
        let result = visit_until(&config, std::future::pending(), || {});
        check(result, &stage.lock().expect("no panic"));
        nothing_is_left(scratch.path());
    }
}

fn nothing_is_left(scratch: &Path) {
    assert_eq!(processes(scratch), Vec::<String>::new());
    let left = fs::read_dir(scratch).expect("it is there").count();
    assert_eq!(left, 0, "files of the browser are left");
}

/// Processes with the folder in their arguments.
fn processes(scratch: &Path) -> Vec<String> {
    let scratch = scratch.to_string_lossy();
    let entries = fs::read_dir("/proc").expect("/proc").flatten();
    entries
        .filter_map(|entry| {
            let line = fs::read(entry.path().join("cmdline")).ok()?;
            let line = String::from_utf8_lossy(&line).replace('\0', " ");
            line.contains(&*scratch).then_some(line)
        })
        .collect()
}

#[test]
fn a_page_runs_to_its_end_in_a_secure_isolated_context() {
    let html = page(&format!(
        "for (let k = 0; k < 5; ++k) {{ {BEAT} {PAUSE} }} end('complete');"
    ));
    visits(&html, limits(), |result, stage| {
        let report = result.expect("a visit to its end");
        let session = report.session.expect("a session");
        assert_eq!(session.client, "true true function");
        assert_eq!((session.rows, report.rows.rows), (5, 5));
        assert!(!report.interrupted && report.browser.opened_ms.is_some());
        // Whatever it is, it was looked at.
        let sandbox = report.browser.sandbox;
        assert_ne!(sandbox.kind, Confinement::Unknown);
        println!("{}: {sandbox:?}", report.browser.version);
        println!("session held after {:?} ms", report.browser.opened_ms);
        let query = &stage.query;
        assert!(query.starts_with("run=1&h_ns=3000000&"), "{query}");
        assert!(query.contains("&mode=closed&"), "{query}");
    });
}

#[test]
fn a_page_that_says_that_it_is_late_is_believed() {
    visits(&page("end('late');"), limits(), |result, _| {
        let error = result.expect_err("it was late");
        assert_eq!(error.name(), "late", "{error}");
        assert!(error.to_string().ends_with("ended as late: so"), "{error}");
    });
}

#[test]
fn a_page_that_takes_no_control_is_given_up() {
    let limits = Limits {
        open: Duration::from_secs(5),
        ..limits()
    };
    visits(
        "<!doctype html><title>empty</title>",
        limits,
        |result, _| {
            let error = result.expect_err("nobody took control");
            assert_eq!(error.name(), "never-opened", "{error}");
            assert!(error.to_string().contains("within 5 s"), "{error}");
        },
    );
}

#[test]
fn a_page_that_falls_silent_hangs() {
    visits(&page(""), limits(), |result, stage| {
        assert_eq!(stage.state, "held");
        let error = result.expect_err("it said nothing more");
        assert_eq!(error.name(), "hung", "{error}");
    });
}

#[test]
fn a_page_that_does_not_end_is_unfinished() {
    let html = page(&format!("for (;;) {{ {BEAT} {PAUSE} }}"));
    visits(&html, limits(), |result, stage| {
        assert!(stage.beats > 0);
        let error = result.expect_err("it goes on");
        assert_eq!(error.name(), "unfinished", "{error}");
    });
}

#[test]
fn a_browser_that_crashes_is_told_from_a_page_that_ends() {
    let _alone = alone();
    for engine in engines() {
        let scratch = scratch();
        let html = page(&format!("for (;;) {{ {BEAT} {PAUSE} }}"));
        let (address, _) = plant(html);
        let config = config(engine, address, &scratch, limits());
        let folder = scratch.path().to_owned();
        let result = visit_until(&config, std::future::pending(), move || kill_first(&folder));
        let error = result.expect_err("it was killed");
        assert_eq!(error.name(), "crashed", "{error}");
        assert!(error.to_string().contains("signal: 9"), "{error}");
        nothing_is_left(scratch.path());
    }
}

/// Kills the browser's own process: of those with its folder in their arguments
/// the one that this process started.
fn kill_first(scratch: &Path) {
    let scratch = scratch.to_string_lossy().into_owned();
    let this = std::process::id().to_string();
    for entry in fs::read_dir("/proc").expect("/proc").flatten() {
        let read = |name| fs::read(entry.path().join(name)).unwrap_or_default();
        let text = |name| String::from_utf8_lossy(&read(name)).into_owned();
        let parent = text("stat");
        let parent = parent.rsplit(')').next().unwrap_or_default();
        let ours = parent.split_whitespace().nth(1) == Some(&this);
        // A handler of crashes is an orphan, and so is ours, too.
        if ours && text("cmdline").contains(&scratch) && text("cmdline").contains("run=1") {
            let pid = entry.file_name().to_string_lossy().parse().ok();
            let pid = pid
                .and_then(rustix::process::Pid::from_raw)
                .expect("a number");
            rustix::process::kill_process(pid, rustix::process::Signal::KILL).expect("killed");
        }
    }
}

#[test]
fn a_visit_that_is_told_to_end_ends_and_says_so() {
    let _alone = alone();
    for engine in engines() {
        let scratch = scratch();
        let html = page(&format!("for (;;) {{ {BEAT} {PAUSE} }}"));
        let (address, _) = plant(html);
        let limits = Limits {
            finish: Duration::from_secs(120),
            ..limits()
        };
        let config = config(engine, address, &scratch, limits);
        let (opened, told) = std::sync::mpsc::channel();
        let stop = async {
            while told.try_recv().is_err() {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
            Ok(())
        };
        let report = visit_until(&config, stop, || opened.send(()).expect("it is heard"));
        assert!(report.expect("no error").interrupted);
        nothing_is_left(scratch.path());
    }
}

#[test]
fn a_plant_that_somebody_controls_is_left_alone() {
    let _alone = alone();
    for engine in engines() {
        let scratch = scratch();
        let (address, stage) = plant(page(""));
        {
            let mut stage = stage.lock().expect("no panic");
            (stage.state, stage.client) = ("held", "somebody".to_owned());
        }
        let config = config(engine, address, &scratch, limits());
        let result = visit_until(&config, std::future::pending(), || {});
        let error = result.expect_err("it is held");
        assert_eq!(error.name(), "taken");
        assert!(error.to_string().contains("`somebody`"), "{error}");
        nothing_is_left(scratch.path());
    }
}
