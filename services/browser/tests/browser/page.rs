//! The page's own tests, run by real browsers: its state machine and its laws
//! against the vectors of the crates `endpoint` and `system`. What is tested is in
//! the JavaScript beside.

use std::{
    fs,
    path::Path,
    sync::{Arc, Mutex},
    time::Duration,
};

use crate::stand_in::{Request, Response, alone, engines, scratch, serve};
use browser::{Config, Limits, visit_until};
use endpoint::{Mode, Preset};
use serde_json::Value;

/// Where the page's modules, their tests and the vectors are. A browser sees all
/// of them in one folder, as a plant serves the page.
const FOLDERS: [&str; 3] = ["page", "tests", "../endpoint/tests/vectors"];

#[test]
fn the_page_is_the_state_machine_and_the_laws_that_the_vectors_tell_of() {
    let _alone = alone();
    for engine in engines() {
        let scratch = scratch();
        let told = Arc::new(Mutex::new(None));
        let result = Arc::clone(&told);
        let plant = serve(move |request| answer(request, &mut told.lock().expect("no panic")));
        let preset = Preset::Worker;
        let h = "3ms".parse().expect("a sample time");
        let config = Config {
            engine,
            plant,
            settings: preset.settings(Mode::Closed, h),
            page: preset.page(),
            start_ns: None,
            duration_ns: 1,
            scratch: scratch.path().to_owned(),
            leash: |_| Ok(()),
            limits: Limits {
                // On the busiest of machines.
                open: Duration::from_secs(120),
                finish: Duration::from_secs(120),
                ..Limits::default()
            },
        };
        visit_until(&config, std::future::pending(), || {}).expect("a result in time");
        let result = result.lock().expect("no panic").take().expect("a result");
        let result: Value = serde_json::from_str(&result).expect("JSON");
        let failed = result["failed"].as_array().expect("a list");
        assert!(failed.is_empty(), "{engine}: {failed:#?}");
        assert!(result["passed"].as_u64().is_some_and(|n| n > 0), "{result}");
        println!("{engine}: {} passed", result["passed"]);
    }
}

/// To the launcher a plant whose session ends with the result.
fn answer(request: &Request, told: &mut Option<String>) -> Response {
    let json = |text: &str| (200, "application/json", text.as_bytes().to_vec());
    match (request.method.as_str(), request.path.as_str()) {
        ("GET", "/") => file("vectors.html"),
        ("GET", "/health") => json("{}"),
        ("GET", "/session") if told.is_some() => json(r#"{"state":"ended"}"#),
        ("GET", "/session") => json(r#"{"state":"free"}"#),
        ("POST", "/result") => {
            *told = Some(request.body.clone());
            json("{}")
        }
        ("GET", path) => file(path.trim_start_matches('/')),
        _ => (405, "text/plain", Vec::new()),
    }
}

fn file(name: &str) -> Response {
    let kind = match Path::new(name).extension().and_then(|kind| kind.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("json") => "application/json",
        _ => "application/octet-stream",
    };
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    FOLDERS
        .iter()
        .filter(|_| !name.contains('/'))
        .find_map(|folder| fs::read(here.join(folder).join(name)).ok())
        .map_or_else(
            || (404, "text/plain", Vec::new()),
            |bytes| (200, kind, bytes),
        )
}
