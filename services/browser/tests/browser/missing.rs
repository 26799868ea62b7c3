//! A machine without a browser, in a process of its own: the environment is one
//! for all tests of a process.

use browser::Engine;

use crate::stand_in::alone;

#[test]
fn a_browser_that_is_not_there_is_said_with_what_to_do() {
    // A visit takes all that this process starts meanwhile for its own.
    let _alone = alone();
    let program = "/nonexistent/chromium";
    let run = std::process::Command::new(std::env::current_exe().expect("this test"))
        .args([
            "--ignored",
            "--exact",
            "missing::asked_by_the_other_test",
            "--nocapture",
        ])
        .env("WEBLOOP_CHROMIUM", program)
        .output()
        .expect("it can be run again");
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(
        said.contains(
            "there is no chromium on this machine: WEBLOOP_CHROMIUM names \
             /nonexistent/chromium, which is not a program; install the package chromium, or name \
             the program in WEBLOOP_CHROMIUM"
        ),
        "{said}"
    );
}

#[test]
#[ignore = "run by the other test, with an environment of its own"]
fn asked_by_the_other_test() {
    match browser::found(Engine::Chromium) {
        Ok(version) => println!("found {version}"),
        Err(missing) => println!("{missing}"),
    }
}
