//! The commands on a page. Those that need nothing but a processor are run, in a folder that has
//! the files which the page names in the first line of a block (`# mine.toml`). The others are
//! parsed: with `--help` at its end a command does nothing, but its options must be known.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::book::page::{Page, ROOT};

const WEBLOOP: &str = env!("CARGO_BIN_EXE_webloop");

/// A page's commands as a shell has them, without comments.
fn lines(page: &Page) -> Vec<String> {
    let mut lines = Vec::new();
    for block in page.blocks("sh") {
        for line in block.text.lines() {
            let line = line.split(" #").next().unwrap_or_default().trim();
            if line.starts_with("webloop ") {
                lines.push(line.to_owned());
            }
        }
    }
    lines
}

/// Whether a command needs neither network, container, browser nor much time, has no blanks to be
/// filled in, and reads only folders that the commands before it left.
fn is_run(line: &str, folder: &Path) -> bool {
    let words: Vec<&str> = line.split_whitespace().collect();
    let has_blank = words.iter().any(|word| {
        word.len() == 1 && word.chars().all(char::is_uppercase) || word.contains("...")
    });
    // Built-in experiments are the tests of others, and take longer.
    let is_simulated = line.contains("--backend sim") || line.contains("--dry-run");
    match words.get(1) {
        _ if has_blank || line.contains("job-") => false,
        Some(&"run") => is_simulated && line.contains(".toml"),
        Some(&"gate") => line.contains("--sim-only") && line.contains(".toml"),
        Some(&"try") => line.contains("--print"),
        Some(&("margin" | "system" | "link" | "matrix")) => true,
        Some(&("compare" | "show" | "report")) => {
            let mut names = words[2..].iter().filter(|word| !word.starts_with('-'));
            names.all(|name| folder.join(name).is_dir())
        }
        _ => false,
    }
}

/// Writes the files that the page gives a name.
fn write_files(page: &Page, folder: &Path) {
    for language in ["toml", "text", "python"] {
        for block in page.blocks(language) {
            let first = block.text.lines().next().unwrap_or_default();
            let name = first.strip_prefix("# ").unwrap_or_default();
            let is_name = name.contains('.') && !name.contains(' ');
            if is_name {
                let (_, rest) = block.text.split_once('\n').unwrap_or_default();
                let text = if language == "text" { rest } else { block.text };
                fs::write(folder.join(name), text).unwrap();
            }
        }
    }
}

/// Runs or parses each command.
pub(crate) fn check(page: &Page) {
    let folder = tempfile::tempdir().unwrap();
    write_files(page, folder.path());
    let profiles = folder.path().join("netem");
    std::os::unix::fs::symlink(format!("{ROOT}/netem"), profiles).unwrap();
    for line in lines(page) {
        let script = if is_run(&line, folder.path()) {
            line.clone()
        } else {
            let command = line.split(['>', '|']).next().unwrap_or_default();
            // What follows is somebody's program.
            let command = command.split(" -- ").next().unwrap_or_default();
            format!("{command} --help")
        };
        let path = Path::new(WEBLOOP).parent().unwrap().display();
        let output = Command::new("sh")
            .args(["-c", &format!("PATH={path}:$PATH\n{script}")])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{}: {script}\n{}",
            page.name,
            String::from_utf8_lossy(&output.stderr)
        );
    }
}
