//! Campaigns with a stand-in for webloop in the containers: one agent, and an orchestrator that
//! ends as its plan says.

use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::{MetadataExt, chown};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use containers::compose::{Cells, ComposeFile, Ended, Ends, Order, Project, gc};
use tempfile::TempDir;

use crate::docker::{count, tag};

/// The argument that makes this program a campaign, to be killed.
pub(crate) const CHILD: &str = "campaign-until-killed";

/// Generous: a project is up within two or three seconds.
const WITHIN: Duration = Duration::from_secs(60);

/// A compose file like webloop's, with the stand-in for its image.
fn file(agent: &str) -> String {
    let image = tag();
    format!(
        "name: webloop
services:
  plant:
    image: {image}
    pull_policy: never
    command: {agent}
    labels: &labels
      webloop.run: ${{WEBLOOP_RUN:-}}
      webloop.owner: ${{WEBLOOP_OWNER:-}}
    healthcheck: {{ test: [CMD, /actor, well], interval: 1s, timeout: 5s }}
    networks: [loop]
  orchestrator:
    image: {image}
    pull_policy: never
    init: true
    labels: *labels
    user: ${{OWNER:-0:0}}
    volumes: ['${{RESULTS:-./results}}:/results']
    depends_on: {{ plant: {{ condition: service_healthy }} }}
    networks: [loop]
networks:
  loop: {{ internal: true, labels: *labels }}
"
    )
}

/// A checkout with such a file, and a results folder whose plan is `plan`.
fn checkout(agent: &str, plan: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("docker-compose.yml"), file(agent)).unwrap();
    fs::create_dir(folder.path().join("results")).unwrap();
    fs::write(folder.path().join("results/plan.json"), plan).unwrap();
    folder
}

fn project(folder: &Path) -> Project {
    let file = ComposeFile::find(Some(folder)).unwrap();
    Project::new(
        file,
        &folder.join("results"),
        "",
        Ends::of_client("native"),
        |command| process::spawn::bind(command, None::<&fs::File>),
    )
    .unwrap()
}

fn wait(cells: &mut Cells<'_>) -> Ended {
    let deadline = Instant::now() + WITHIN;
    while Instant::now() < deadline {
        if let Some(ended) = cells.ended().unwrap() {
            return ended;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    panic!("the cells did not end");
}

fn left_of(project: &str) -> usize {
    count(&format!("com.docker.compose.project={project}"))
}

pub(crate) fn cells_end_with_their_code_and_leave_rows_of_the_folders_owner() {
    let folder = checkout("stay", "3");
    let results = folder.path().join("results");
    // Whoever that is, as far as this test may say it.
    let _ = chown(&results, Some(1001), Some(1001));
    let mut project = project(folder.path());
    let name = project.name().to_owned();
    let mut cells = project.run_cells(&[0, 2], &["--player", "user"]).unwrap();
    let ended = wait(&mut cells);
    assert_eq!(ended.code, Some(3), "{}", ended.words);
    assert!(cells.said().any(|line| line == "cell by cell"));
    drop(cells);
    assert_eq!(
        fs::read_to_string(results.join("said")).unwrap(),
        "run-cell --plan /results/plan.json --index 0,2 --out /results --backend attach --player user"
    );
    let owner = |path: &Path| fs::metadata(path).unwrap().uid();
    assert_eq!(owner(&results.join("said")), owner(&results));
    assert!(left_of(&name) > 0);
    project.down().unwrap();
    assert_eq!(left_of(&name), 0);
}

pub(crate) fn cells_that_are_told_to_end_do_so() {
    let folder = checkout("stay", "never");
    let mut project = project(folder.path());
    let name = project.name().to_owned();
    let mut cells = project.run_cells(&[0], &[]).unwrap();
    let deadline = Instant::now() + WITHIN;
    while !folder.path().join("results/said").exists() && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(cells.ended().unwrap(), None);
    cells.terminate();
    // By SIGTERM, and so not by any exit of its own.
    assert_eq!(wait(&mut cells).code, Some(128 + 15));
    drop(cells);
    drop(project);
    assert_eq!(left_of(&name), 0);
}

pub(crate) fn an_agent_that_does_not_start_is_quoted() {
    let folder = checkout("unwell", "0");
    let mut project = project(folder.path());
    let name = project.name().to_owned();
    let mut cells = project.run_cells(&[0], &[]).unwrap();
    let ended = wait(&mut cells);
    assert_ne!(ended.code, Some(0));
    assert!(
        ended
            .words
            .contains("webloop: the agent has no scratch folder"),
        "{}",
        ended.words
    );
    drop(cells);
    drop(project);
    assert_eq!(left_of(&name), 0);
}

pub(crate) fn what_a_killed_campaign_left_is_swept() {
    for after_ms in [300, 1_000, 4_000] {
        let folder = checkout("stay", "never");
        let mut child = Command::new(std::env::current_exe().unwrap())
            .arg(CHILD)
            .arg(folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut name = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut name)
            .unwrap();
        let project = name.trim().to_owned();
        std::thread::sleep(Duration::from_millis(after_ms));
        // It is its user's as long as it runs.
        let order = Order {
            force: true,
            project: Some(project.clone()),
            ..Order::default()
        };
        assert_eq!(gc(&order).unwrap().removed, []);
        child.kill().unwrap();
        child.wait().unwrap();
        let swept = gc(&order).unwrap();
        assert_eq!(swept.left, []);
        println!(
            "  killed after {after_ms} ms: swept {}",
            swept.removed.len()
        );
        assert_eq!(left_of(&project), 0);
    }
}

/// Says the project's name and runs cells that never end.
pub(crate) fn run_until_killed(folder: &Path) {
    let mut project = project(folder);
    println!("{}", project.name());
    let mut cells = project.run_cells(&[0], &[]).unwrap();
    let _ = wait(&mut cells);
}
