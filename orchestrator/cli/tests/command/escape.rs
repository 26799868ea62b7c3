//! No command prints a control character that somebody else wrote: into a file's name, a file, or a word of the
//! command line.

use std::fs;
use std::process::Command;

/// Clears the screen, turns the text red and sets the terminal's title.
const ESCAPE: &str = "\x1b[2J\x1b[31m\x1b]0;x\x07\u{9b}31m\u{202e}";

/// The same in TOML.
const WRITTEN: &str = r"\u001b[2J\u001b[31m\u009b31m\u202e";

#[test]
fn no_command_prints_an_escape_of_somebody_elses() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bad = format!("bad{ESCAPE}.toml");
    fs::write(folder.path().join(&bad), "x").expect("a writable folder");
    let results = format!("results{ESCAPE}");
    fs::create_dir(folder.path().join(&results)).expect("a writable folder");
    fs::write(folder.path().join(&results).join("plan.json"), ESCAPE).expect("a writable folder");
    let files = [
        format!("name = \"{WRITTEN}\"\nabout = \"a\""),
        format!("name = \"a\"\nabout = \"{WRITTEN}\""),
        format!("\"{WRITTEN}\" = 1"),
        format!("name = \"a\"\nabout = \"a\"\n[both]\ndelay = \"{WRITTEN}\""),
        format!("name = \"a\"\n[plant]\nrun = [\"{WRITTEN}\"]"),
        format!(
            "name = \"a\"\nabout = \"b\"\n[[cells]]\ntopology = [\"{WRITTEN}\"]\nclient = [\"native\"]\nmode = \"open\"\nh = [\"10ms\"]\nduration = \"6s\""
        ),
        format!(
            "name = \"a\"\nabout = \"b\"\n[[cells]]\ntopology = [\"couva\"]\nclient = [\"{WRITTEN}\"]\nmode = \"{WRITTEN}\""
        ),
        format!("# {ESCAPE}\nname = 1"),
    ];
    let mut named = vec![bad, results, format!("none{ESCAPE}")];
    for (index, text) in files.iter().enumerate() {
        let name = format!("{index}.toml");
        fs::write(folder.path().join(&name), text).expect("a writable folder");
        named.push(name);
    }
    let commands: [&[&str]; 16] = [
        &["show"],
        &["run"],
        &["run", "--only"],
        &["run", "smoke", "--topology"],
        &["gate"],
        &["report"],
        &["compare", "x"],
        &["collect", "--out", "out"],
        &["matrix"],
        &["margin"],
        &["sweep"],
        &["link", "show"],
        &["link", "lint"],
        &["system", "show"],
        &["system", "lint"],
        &["serve", "plant", "--system"],
    ];
    for command in commands {
        for name in &named {
            let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
                .args(command)
                .arg(name)
                .current_dir(folder.path())
                .output()
                .expect("webloop runs");
            let said = [output.stdout, output.stderr].concat();
            let text = String::from_utf8_lossy(&said);
            let acts = |letter: char| {
                (letter.is_control() && !matches!(letter, '\n' | '\t')) || letter == '\u{202e}'
            };
            assert!(!text.contains(acts), "{command:?} {name:?}: {text:?}");
        }
    }
}
