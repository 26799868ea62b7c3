//! The package's own tests, in Python, with the standard library's `unittest`.
#![allow(clippy::print_stdout, reason = "it says what is skipped")]

use std::process::Command;

#[test]
fn the_package_s_tests_pass() {
    if let Err(error) = python::version() {
        println!("SKIPPED: {error}");
        return;
    }
    let interpreter = std::env::var_os("WEBLOOP_PYTHON").unwrap_or_else(|| "python3".into());
    let output = Command::new(interpreter)
        .args(["-B", "-m", "unittest", "discover", "tests"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("there is an interpreter");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(!said.contains("Ran 0 tests"), "{said}");
}
