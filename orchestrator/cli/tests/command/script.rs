//! What webloop prints, or its book has, to be run by a shell: under dash, bash and busybox, with mawk, gawk
//! and busybox's awk. Clock, `sleep`, `tc` and `curl` are functions of the test, so nothing waits.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use link::{LinkTime, Profile, Staircase, Verb, Way};

const WEBLOOP: &str = env!("CARGO_BIN_EXE_webloop");
const SHELLS: [&[&str]; 4] = [
    &["dash"],
    &["bash"],
    &["bash", "--posix"],
    &["busybox", "sh"],
];
const AWKS: [&str; 3] = ["mawk", "gawk", "busybox"];

/// A clock that only `sleep` and `tc` move, and a record of each call of `tc` with its time: `tc` takes
/// four milliseconds, as the start of a program does. Numbers are whole microseconds, which each shell can add.
const STUBS: &str = r#"
date() { us=$(cat "$PLACE/clock"); printf '%d.%06d' $((us / 1000000)) $((us % 1000000)); }
sleep() {
    case $1 in *[!0-9.]* | '') echo "sleep $1" >>"$PLACE/wrong" ;; esac
    whole=${1%.*} part=${1#*.}
    while case $part in 0?*) ;; *) false ;; esac do part=${part#0}; done
    echo $(($(cat "$PLACE/clock") + whole * 1000000 + part)) >"$PLACE/clock"
}
tc() {
    echo "$(cat "$PLACE/clock") $*" >>"$PLACE/calls"
    echo $(($(cat "$PLACE/clock") + 4000)) >"$PLACE/clock"
}
"#;
/// When the clock begins: some second of some year, and not a whole one.
const BEGINS_US: u64 = 1_795_828_326_123_457;

/// Whether a program is here; says if it is not.
fn is_here(program: &str) -> bool {
    let found = std::env::var_os("PATH").is_some_and(|path| {
        std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
    });
    if !found {
        println!("SKIPPED: no {program} here to run a printed script under");
    }
    found
}

/// Runs a script under each shell with each awk there is, in a folder of its own with the files that the
/// test `prepares`, and looks at what it left by `look`.
fn under_each(script: &str, prepares: impl Fn(&Path), look: impl Fn(&str, &Path, &str)) {
    let mut tried = 0;
    for shell in SHELLS.iter().filter(|shell| is_here(shell[0])) {
        for awk in AWKS.iter().filter(|awk| is_here(awk)) {
            let place = tempfile::tempdir().unwrap();
            let tools = place.path().join("tools");
            fs::create_dir(&tools).unwrap();
            let awk_path = which(awk);
            symlink(awk_path, tools.join("awk")).unwrap();
            prepares(place.path());
            let path = place.path().join("script");
            fs::write(&path, script).unwrap();
            let output = Command::new(shell[0])
                .args(&shell[1..])
                .arg(&path)
                .env("PLACE", place.path())
                .env(
                    "PATH",
                    format!("{}:{}", tools.display(), std::env::var("PATH").unwrap()),
                )
                // A locale with a decimal comma, where the machine has it.
                .env("LC_ALL", "de_DE.UTF-8")
                .output()
                .unwrap();
            let name = format!("{} with {awk}", shell.join(" "));
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{name}: {errors}");
            // bash says where the machine lacks that locale.
            let mut errors = errors.lines().filter(|line| !line.contains("setlocale"));
            assert_eq!(errors.next(), None, "{name}");
            look(
                &name,
                place.path(),
                &String::from_utf8_lossy(&output.stdout),
            );
            tried += 1;
        }
    }
    println!("tried under {tried} pairs of a shell and an awk");
}

fn which(program: &str) -> std::path::PathBuf {
    let path = std::env::var_os("PATH").unwrap();
    let mut folders = std::env::split_paths(&path).map(|folder| folder.join(program));
    folders.find(|path| path.is_file()).unwrap()
}

fn printed(profile: &str, span: &str, folder: &Path) -> String {
    let output = Command::new(WEBLOOP)
        .args([
            "link", "show", profile, "--tc", "--seed", "3", "--way", "down", "--for", span,
        ])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_script_of_a_link_makes_each_change_at_its_time_under_every_shell_and_awk() {
    let traced = "name = \"traced\"\nabout = \"\"\n[both.trace]\nsteps = [{ t = \"0s\", delay = \"5ms\" }, \
                  { t = \"700ms\", delay = \"90ms\" }, { t = \"900ms\", delay = \"7ms\", loss = \"100%\" }]\n";
    let constant = "name = \"constant\"\nabout = \"\"\nboth.delay.base = \"5ms\"\n";
    // A call costs some processes, so busy links are tried for a short time.
    for (text, span_ms) in [
        (traced, 1_000),
        (constant, 3_000),
        (Profile::builtin("couva").unwrap(), 100),
    ] {
        let end = LinkTime::from_ns(span_ms * 1_000_000);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("own.toml"), text).unwrap();
        let script = printed("own.toml", &format!("{span_ms}ms"), folder.path());
        let mut staircase = Staircase::new(&Profile::parse(text, "own").unwrap(), 3, Way::Down);
        let changes = std::iter::from_fn(|| staircase.next_before(end));
        let mut due: Vec<(u64, String)> = changes
            .map(|change| {
                (
                    change.at.ns() / 1000,
                    change.setting.command(Verb::Change, "eth0"),
                )
            })
            .collect();
        due.push((
            end.ns() / 1000,
            "qdisc del dev eth0 root handle 77:".to_owned(),
        ));
        let prepare = |place: &Path| {
            fs::write(place.join("clock"), format!("{BEGINS_US}\n")).unwrap();
        };
        under_each(&format!("{STUBS}{script}"), prepare, |name, place, _| {
            assert!(
                !place.join("wrong").exists(),
                "{name}: a sleep that some sleep cannot read"
            );
            let calls = fs::read_to_string(place.join("calls")).unwrap();
            let mut calls = calls.lines().map(|line| line.split_once(' ').unwrap());
            let (_, first) = calls.next().unwrap();
            assert!(
                first.starts_with("qdisc add dev eth0 root handle 77: netem"),
                "{name}: {first}"
            );
            // The set-up took the four milliseconds of a call.
            let start_us = BEGINS_US + 4_000;
            let calls: Vec<(u64, String)> = calls
                .map(|(us, words)| (us.parse::<u64>().unwrap() - start_us, words.to_owned()))
                .collect();
            assert_eq!(calls.len(), due.len(), "{name}");
            let mut free_us = 0;
            for ((us, words), (due_us, due_words)) in calls.iter().zip(&due) {
                assert_eq!(words, due_words, "{name}");
                // It waits for its time, or for the call before it, to the microseconds of awk's numbers.
                let due_us = (*due_us).max(free_us);
                assert!(us.abs_diff(due_us) <= 3, "{name}: {us} us for {due_us}");
                free_us = us + 4_000;
            }
        });
    }
}

#[test]
fn a_link_that_tc_cannot_play_prints_a_script_that_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name = \"p\"\nabout = \"\"\nboth.delay.base = \"5ms\"\n\
                [[fault]]\nat = \"1s\"\nfor = \"1s\"\nreset = true\n";
    fs::write(folder.path().join("own.toml"), text).unwrap();
    for profile in ["own.toml", "arima"] {
        let script = format!("{STUBS}{}", printed(profile, "1s", folder.path()));
        under_each(
            &script,
            |_| {},
            |name, place, told| {
                assert!(!place.join("calls").exists(), "{name}");
                assert_eq!(told, "", "{name}");
            },
        );
    }
}

/// The plant that the book's shell controls: a lag that takes a third of the way to u each time. Its
/// answers are as `GET /closed` gives them.
const CURL: &str = r#"
sleep() { n=$((${n:-0} + 1)); [ $n -le 40 ]; }
curl() {
    u=${2#*u=}
    echo "$u" >>"$PLACE/sent"
    LC_ALL=C awk -v u="$u" -v y="$(cat "$PLACE/y")" 'BEGIN { printf "%.6f\n", y + (u - y) / 3 }' >"$PLACE/next"
    mv "$PLACE/next" "$PLACE/y"
    echo "seq=$n&y=$(cat "$PLACE/y")&t=5"
}
"#;

#[test]
fn the_shell_of_the_book_closes_the_loop_under_every_shell_and_awk() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/your-controller.md");
    let page = fs::read_to_string(page).unwrap();
    let block = page
        .split("```sh\n")
        .find(|block| block.contains("| awk '"))
        .unwrap();
    let block = block.split("```").next().unwrap();
    let script: String = block
        .lines()
        .filter(|line| !line.starts_with("webloop "))
        .map(|line| format!("{line}\n"))
        .collect();
    let prepare = |place: &Path| fs::write(place.join("y"), "0\n").unwrap();
    under_each(&format!("{CURL}{script}"), prepare, |name, place, told| {
        let sent = fs::read_to_string(place.join("sent")).unwrap();
        let (mut y, mut i) = (0.0, 0.0);
        for (count, u) in sent.lines().enumerate() {
            let e = 1.0 - y;
            i += 0.378 * 0.03 * e;
            let due: f64 = 0.1701 * e + i;
            let u: f64 = u.parse().unwrap_or_else(|_| panic!("{name}: u = {u}"));
            assert!(
                (u - due).abs() < 1e-4,
                "{name}: the command {count} is {u}, not {due}"
            );
            y += (u - y) / 3.0;
        }
        assert_eq!(sent.lines().count(), 40, "{name}");
        assert_eq!(told.lines().count(), 40, "{name}");
    });
}
