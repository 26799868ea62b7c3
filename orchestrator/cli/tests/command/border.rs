//! Margins of a plant that is a program: the border by simulation is that of the same plant as a model, and a program
//! that breaks its contract is told by name.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use control::Analysis;
use endpoint::SampleTime;
use plan::system::System;

/// 1/(s + 1)^3, sampled exactly for an input that is held over h. It prints y as it is when u arrives, as webloop's own
/// model without a direct path does; one that prints it after the step is a loop of one sample less.
const LAGS: &str = "
import math, os, sys
h = float(os.environ['WEBLOOP_H_S'])
e = math.exp(-h)
rows = (
    (e, 0.0, 0.0, 1 - e),
    (h * e, e, 0.0, 1 - (1 + h) * e),
    (h * h / 2 * e, h * e, e, 1 - (1 + h + h * h / 2) * e),
)
x = (0.0, 0.0, 0.0)
print(0.0, flush=True)
for k, line in enumerate(sys.stdin):
    y = x[2]
";

const GOOD: &str = "
    print(repr(y), flush=True)
    s = (*x, float(line))
    x = tuple(sum(a * b for a, b in zip(row, s)) for row in rows)
";

const LAW: &str = "[controller]\nlaw = \"pid\"\nkp = 1.0\nki = 0.4\n";

fn margin(folder: &Path, fault: &str, more: &[&str]) -> Output {
    fs::write(folder.join("lags.py"), format!("{LAGS}{fault}{GOOD}")).unwrap();
    let text = format!("name = \"lags\"\n[plant]\nrun = [\"python3\", \"./lags.py\"]\n{LAW}");
    let file = folder.join("lags.toml");
    fs::write(&file, text).unwrap();
    Command::new(env!("CARGO_BIN_EXE_webloop"))
        .args([
            "margin",
            "--topology",
            "arima",
            "--system",
            file.to_str().unwrap(),
        ])
        .args(more)
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

/// The numbers of the table's row with these words; `-` and `any` are none.
fn numbers(printed: &str, words: &str) -> Vec<Option<f64>> {
    let row = printed
        .lines()
        .find(|line| line.contains(words))
        .expect(words);
    let (_, numbers) = row.split_once(words).unwrap();
    numbers.split_whitespace().map(|x| x.parse().ok()).collect()
}

#[test]
fn the_border_of_a_program_is_that_of_the_same_plant_as_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let output = margin(folder.path(), "", &["--h", "200ms", "--duration", "60s"]);
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let model =
        format!("name = \"model\"\n[plant]\nnum = [1.0]\nden = [1.0, 3.0, 3.0, 1.0]\n{LAW}");
    let h = SampleTime::try_new(200_000_000).unwrap();
    let open = System::read(&model).unwrap().at(h).unwrap().open().unwrap();
    let margins = Analysis::of(&open).unwrap().margins;
    let [
        Some(at),
        Some(not_at),
        None,
        None,
        Some(delay_ms),
        Some(later_ms),
    ] = numbers(&printed, "dies out")[..]
    else {
        panic!("{printed}");
    };
    // Within one step of the bracket, of 1 % and of one sample; what is printed has three digits.
    let step = 1.01 * 1.005;
    assert!(
        at / step <= margins.gain && margins.gain <= not_at * step,
        "{at} {margins:?}"
    );
    let (h_ms, expected_ms) = (200.0, margins.delay_s * 1e3);
    assert!(
        delay_ms - h_ms <= expected_ms && expected_ms <= later_ms + h_ms,
        "{delay_ms} {margins:?}"
    );
    // To settle within the run it has to stay well inside.
    let holds = numbers(&printed, "holds");
    assert!(
        holds[0] < Some(at) && holds[4] < Some(delay_ms),
        "{printed}"
    );
    assert!(
        printed.contains("runs of 60 s, each from a fresh start"),
        "{printed}"
    );
}

#[test]
fn a_program_that_dies_or_answers_no_number_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let short = ["--h", "100ms", "--duration", "10s"];
    for (fault, says) in [
        (
            "    if k == 7: sys.exit(3)\n",
            "ended with exit code 3 before y of step 7",
        ),
        (
            "    if k == 7: y = float('nan')\n",
            "printed `nan` as y of step 7, which is no number",
        ),
    ] {
        let output = margin(folder.path(), fault, &short);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(says) && output.stdout.is_empty(), "{said}");
    }
}

#[test]
fn a_loop_that_is_lost_as_it_is_has_no_border_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let short = ["--h", "100ms", "--duration", "20s", "--kp", "40"];
    let output = margin(folder.path(), "", &short);
    let printed = String::from_utf8_lossy(&output.stdout);
    assert_eq!(numbers(&printed, "holds"), [None; 6], "{printed}");
    assert!(
        printed.contains("the loop with its own gains is lost"),
        "{printed}"
    );
}
