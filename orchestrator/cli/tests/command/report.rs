//! The report on a folder that is whole, and on one that is not.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use plan::Plan;
use record::{FileFact, Manifest};
use tempfile::TempDir;

/// Two runs of a second each.
const RAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cmd/input/ran");

/// A copy of the two runs, removed afterwards.
struct Ran(TempDir);

impl Ran {
    fn new() -> Ran {
        let ran = Ran(tempfile::tempdir().unwrap());
        fs::copy(Path::new(RAN).join("plan.json"), ran.path("plan.json")).unwrap();
        for cell in ran.cells() {
            let from = Path::new(RAN).join("cells").join(cell.file_name().unwrap());
            fs::create_dir_all(&cell).unwrap();
            for entry in fs::read_dir(&from).unwrap() {
                let entry = entry.unwrap();
                fs::copy(entry.path(), cell.join(entry.file_name())).unwrap();
            }
        }
        ran
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn cells(&self) -> Vec<PathBuf> {
        let text = fs::read_to_string(self.path("plan.json")).unwrap();
        let plan = Plan::from_json(&text).unwrap();
        plan.cells
            .iter()
            .map(|cell| self.0.path().join(cell.folder()))
            .collect()
    }

    /// Makes the report. Returns the exit code, and what was printed about the folder.
    fn report(&self) -> (Option<i32>, String) {
        self.report_with(&[])
    }

    fn report_with(&self, options: &[&str]) -> (Option<i32>, String) {
        let output: Output = Command::new(env!("CARGO_BIN_EXE_webloop"))
            .arg("report")
            .arg(self.0.path())
            .args(options)
            .env_remove("RUST_LOG")
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), said)
    }

    /// Every file except rows and manifests, by name: what can be deleted and made again.
    fn made(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut made = BTreeMap::new();
        let mut folders = vec![self.0.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(self.0.path()).unwrap().to_owned();
                if path.is_dir() && !name.starts_with("cells") {
                    folders.push(path);
                } else if path.is_file() && name != Path::new("plan.json") {
                    made.insert(name, fs::read(path).unwrap());
                }
            }
        }
        made
    }
}

/// Updates the checksums in a manifest to the files.
fn seal(cell: &Path) {
    let path = cell.join(Manifest::FILE);
    let mut manifest = Manifest::from_json(&fs::read_to_string(&path).unwrap()).unwrap();
    let fact = |name: &str| FileFact::of(File::open(cell.join(name)).unwrap()).unwrap();
    for (name, of_it) in &mut manifest.files {
        *of_it = fact(name);
    }
    fs::write(path, manifest.to_json()).unwrap();
}

#[test]
fn a_report_is_made_again_byte_for_byte_elsewhere_too() {
    let (here, there) = (Ran::new(), Ran::new());
    let with_paper = ["--with", "paper"];
    assert_eq!(here.report_with(&with_paper), (Some(0), String::new()));
    let first = here.made();
    for name in [
        "report/report.html",
        "report/claims.json",
        "report/tables/table-2.csv",
        "report/figures/fig-3.svg",
        "report/figures/fig-3.pdf",
        "report/figures/fig-3.csv",
        "report/junit.xml",
        "report/summary.md",
        "summary.csv",
        "datapackage.json",
        "ro-crate-metadata.json",
    ] {
        assert!(first.contains_key(Path::new(name)), "{name}");
    }
    fs::remove_dir_all(here.path("report")).unwrap();
    here.report_with(&with_paper);
    there.report_with(&with_paper);
    for other in [here.made(), there.made()] {
        for (name, bytes) in &first {
            assert!(other.get(name) == Some(bytes), "{}", name.display());
        }
    }
}

#[test]
fn a_report_says_nothing_of_a_paper_unless_it_is_asked() {
    let ran = Ran::new();
    ran.report();
    for (name, bytes) in ran.made() {
        let text = String::from_utf8_lossy(&bytes).to_lowercase();
        // A profile's own text stands there as it is, and a link's numbers may be from the paper.
        let outside = text
            .split("<pre>")
            .map(|part| part.rsplit("</pre>").next().unwrap_or(part));
        for part in outside {
            assert!(!part.contains("the paper"), "{}", name.display());
        }
        assert!(
            !name.to_string_lossy().contains("claims"),
            "{}",
            name.display()
        );
    }
}

#[test]
fn each_figure_is_a_picture_too_if_that_is_asked_for() {
    let ran = Ran::new();
    assert_eq!(ran.report_with(&["--png"]), (Some(0), String::new()));
    let made = ran.made();
    let ending = |path: &PathBuf, ending: &str| path.extension().is_some_and(|of| of == ending);
    let drawn = made.keys().filter(|path| ending(path, "svg"));
    let drawn: Vec<PathBuf> = drawn.map(|path| path.with_extension("png")).collect();
    assert!(!drawn.is_empty());
    for path in drawn {
        assert!(made[&path].starts_with(b"\x89PNG"), "{}", path.display());
    }
    let crate_text = &made[Path::new("ro-crate-metadata.json")];
    assert!(String::from_utf8_lossy(crate_text).contains("image/png"));
}

#[test]
fn a_cell_that_is_gone_is_named_and_the_exit_code_says_so() {
    let ran = Ran::new();
    let gone = ran.cells().remove(1);
    fs::remove_dir_all(&gone).unwrap();
    let (code, said) = ran.report();
    let name = gone.file_name().unwrap().to_string_lossy();
    assert_eq!(code, Some(1));
    assert!(
        said.contains("1 of 2 cells") && said.contains(&*name),
        "{said}"
    );
    let page = fs::read_to_string(ran.path("report/report.html")).unwrap();
    assert!(page.contains(&*name));
}

#[test]
fn a_flipped_byte_is_found_and_its_file_named() {
    let ran = Ran::new();
    let file = ran.cells().remove(0).join("arrivals.csv");
    let mut bytes = fs::read(&file).unwrap();
    // Change a digit of the last row; it is still a row.
    let at = bytes.iter().rposition(u8::is_ascii_digit).unwrap();
    bytes[at] = if bytes[at] == b'1' { b'2' } else { b'1' };
    fs::write(&file, bytes).unwrap();
    let (code, said) = ran.report();
    assert_eq!(code, Some(1));
    assert!(
        said.contains("arrivals.csv") && said.contains("checksum"),
        "{said}"
    );
}

#[test]
fn a_torn_last_row_is_dropped_and_counted_where_checksum_and_count_are_those_of_the_others() {
    let ran = Ran::new();
    let cell = ran.cells().remove(0);
    let file = cell.join("ticks.csv");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, &text[..text.len() - 3]).unwrap();
    seal(&cell);
    let (code, said) = ran.report();
    assert_eq!(code, Some(1));
    assert!(
        said.contains("it has 10 rows, and plant.json says 11"),
        "{said}"
    );

    let plant = cell.join("plant.json");
    let report = fs::read_to_string(&plant).unwrap();
    fs::write(&plant, report.replace("\"rows\": 11", "\"rows\": 10")).unwrap();
    seal(&cell);
    assert_eq!(ran.report(), (Some(0), String::new()));
    let summary = fs::read_to_string(ran.path("summary.csv")).unwrap();
    let mut lines = summary.lines();
    let column = lines
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "torn_lines");
    let row = lines.next().unwrap();
    assert_eq!(row.split(',').nth(column.unwrap()), Some("1"), "{row}");
}

#[test]
fn a_folder_that_is_none_is_refused_with_what_it_lacks() {
    let empty = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .arg("report")
        .arg(empty.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("plan.json"));
}

#[test]
fn a_folder_whose_rows_were_not_kept_keeps_its_report() {
    let ran = Ran::new();
    ran.report();
    fs::remove_dir_all(ran.path("cells")).unwrap();
    let before = ran.made();
    let (code, said) = ran.report();
    assert_eq!(code, Some(2));
    assert!(said.contains("no cell"), "{said}");
    assert!(ran.made() == before);
}

#[test]
fn a_run_ends_with_its_report_unless_told_not_to() {
    let folder = tempfile::tempdir().unwrap();
    let run = |options: &[&str], name: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
            .args([
                "run",
                "quick",
                "--backend",
                "sim",
                "--progress",
                "quiet",
                "--out",
            ])
            .arg(folder.path().join(name))
            .args(options)
            .output()
            .unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
        )
    };
    let page = |name: &str| folder.path().join(name).join("report/report.html");
    let (code, said) = run(&[], "with");
    assert_eq!(code, Some(0));
    assert!(
        said.contains(&format!("Report: {}", page("with").display())),
        "{said}"
    );
    assert!(page("with").exists());
    let (code, said) = run(&["--no-report"], "without");
    assert_eq!((code, said.contains("Report:")), (Some(0), false));
    assert!(!page("without").exists());
}

#[test]
fn a_live_report_is_for_this_machine_alone() {
    let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .args([
            "run",
            "quick",
            "--backend",
            "sim",
            "--live",
            "0.0.0.0:0",
            "--out",
        ])
        .arg(tempfile::tempdir().unwrap().path().join("out"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("an address of this machine alone"), "{said}");
}

/// Six seconds at 10 Hz, 333 Hz and 1 kHz: enough messages for a median, for p99, for p99.9.
#[test]
fn a_percentile_that_too_few_messages_vouch_for_is_not_printed() {
    let place = tempfile::tempdir().unwrap();
    let (experiment, out) = (place.path().join("three.toml"), place.path().join("out"));
    let text = "name = \"three\"\n[[cells]]\ntopology = [\"arima\", \"diego-vpn\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
                h = [\"100ms\", \"3ms\", \"1ms\"]\nduration = \"6s\"\n";
    fs::write(&experiment, text).unwrap();
    let ran = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .arg("run")
        .arg(&experiment)
        .args(["--backend", "sim", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(ran.status.code(), Some(0));
    let mut table = csv::Reader::from_path(out.join("report/tables/delays.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let (mut printed, mut left_out, mut fewest) = (0, 0, u64::MAX);
    for row in table.records() {
        let row = row.unwrap();
        let field = |name: &str| {
            let at = header.iter().position(|one| one == name).unwrap();
            row[at].to_owned()
        };
        let messages: u64 = field("messages").parse().unwrap();
        fewest = fewest.min(messages);
        for (name, share) in [
            ("p50", 0.5),
            ("p90", 0.9),
            ("p99", 0.99),
            ("p99.9", 0.999_f64),
        ] {
            let vouching = (0.01_f64.ln() / share.ln()).ceil() as u64;
            let is_printed = !field(&format!("round trip/ms {name}")).is_empty();
            assert!(!is_printed || messages >= vouching, "{name} of {messages}");
            *if is_printed {
                &mut printed
            } else {
                &mut left_out
            } += 1;
        }
    }
    assert!(
        printed > 0 && left_out > 0 && fewest < 100,
        "{printed} {left_out} {fewest}"
    );
    let mut summary = csv::Reader::from_path(out.join("summary.csv")).unwrap();
    let header = summary.headers().unwrap().clone();
    let at = header.iter().position(|name| name == "verdict").unwrap();
    let runs: Vec<_> = summary.records().map(Result::unwrap).collect();
    assert!(runs.len() == 6 && runs.iter().all(|run| !run[at].is_empty()));
    println!(
        "row 24: {printed} percentiles printed, {left_out} left out for too few messages, each beside its n; 6 of 6 runs with their verdict"
    );
}
