//! Docker by hand: an image of one small program, and things that a test makes and removes.

use std::fs;
use std::process::Command;

/// What the containers of these tests run: it does one thing by its first argument.
///
/// As an orchestrator it leaves its arguments in the results and ends with the code that is in
/// the plan's place, or, where there is none, not at all.
const ACTOR: &str = r#"
    fn main() {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        match arguments.first().map(String::as_str) {
            Some("well") => return,
            Some("unwell") => {
                eprintln!("webloop: the agent has no scratch folder");
                std::process::exit(3);
            }
            Some("run-cell") => {
                std::fs::write("/results/said", arguments.join(" ")).unwrap();
                eprintln!("cell by cell");
                if let Ok(code) = std::fs::read_to_string("/results/plan.json").unwrap().parse() {
                    std::process::exit(code);
                }
            }
            _ => {}
        }
        loop {
            std::thread::sleep(std::time::Duration::from_secs(60));
        }
    }
"#;

/// The image that holds it; removed at the end.
pub(crate) struct Image;

impl Image {
    /// Builds it, with the compiler that built this test.
    pub(crate) fn build() -> Result<Image, String> {
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("actor.rs");
        fs::write(&source, ACTOR).unwrap();
        fs::write(
            folder.path().join("Dockerfile"),
            "FROM scratch\nCOPY actor /actor\nENTRYPOINT [\"/actor\"]\n",
        )
        .unwrap();
        let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
        let compiled = Command::new(&rustc)
            .args(["--edition=2024", "-C", "target-feature=+crt-static", "-o"])
            .arg(folder.path().join("actor"))
            .arg(&source)
            .output()
            .map_err(|problem| format!("{rustc}: {problem}"))?;
        if !compiled.status.success() {
            return Err(String::from_utf8_lossy(&compiled.stderr).into_owned());
        }
        let folder = folder.path().display().to_string();
        docker(&["build", "--quiet", "--tag", &tag(), &folder]).map(|_| Image)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        let _ = docker(&["image", "rm", "--force", &tag()]);
    }
}

/// The image's name, and the beginning of every other name that this test makes.
pub(crate) fn tag() -> String {
    format!("webloop-test-{}", std::process::id())
}

/// Calls docker; gives back what it said, or its complaint.
pub(crate) fn docker(arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("docker").args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(text(&output.stderr))
    }
}

/// How many containers and networks have this label.
pub(crate) fn count(label: &str) -> usize {
    let filter = format!("label={label}");
    let containers = docker(&["ps", "--all", "--quiet", "--filter", &filter]).unwrap();
    let networks = docker(&["network", "ls", "--quiet", "--filter", &filter]).unwrap();
    containers.lines().count() + networks.lines().count()
}

/// A container, network or volume made by a test, which removes it at its own end.
pub(crate) struct Decoy {
    kind: &'static str,
    name: String,
}

impl Decoy {
    /// Makes one with these labels; a container is `running` or only made.
    pub(crate) fn new(kind: &'static str, name: &str, labels: &[String], running: bool) -> Self {
        let name = format!("{}-{name}", tag());
        let mut arguments = vec![kind, "create"];
        for label in labels {
            arguments.extend(["--label", label]);
        }
        let tag = tag();
        match kind {
            "container" => arguments.extend(["--network", "none", "--name", &name, &tag]),
            _ => arguments.push(&name),
        }
        docker(&arguments).unwrap();
        if running {
            docker(&["container", "start", &name]).unwrap();
        }
        Decoy { kind, name }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is still there.
    pub(crate) fn exists(&self) -> bool {
        docker(&[self.kind, "inspect", &self.name]).is_ok()
    }

    /// Kills a container, so that it has run and does not any more.
    pub(crate) fn end(&self) {
        docker(&["container", "kill", &self.name]).unwrap();
    }
}

impl Drop for Decoy {
    fn drop(&mut self) {
        let force: &[&str] = if self.kind == "container" {
            &["--force"]
        } else {
            &[]
        };
        let arguments = [&[self.kind, "rm"], force, &[&self.name]].concat();
        let _ = docker(&arguments);
    }
}
