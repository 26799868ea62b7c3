//! Results folders that were tampered with: every command that prints a figure of one reports what
//! is wrong with it, ends with 1 or 2 within its time, and writes nothing outside it.
//!
//! `place` has an honest folder and what is around it, `forgery` the ways to falsify it.
#![allow(clippy::unwrap_used)]

mod forgery;
pub(crate) mod place;

use std::fs;
use std::os::unix::fs::symlink;

use crate::ended::Ended;
use crate::falsified::forgery::Forgery;
use crate::falsified::place::{Place, VERSIONED, edit, edit_json};

/// The commands that miss a forgery, or report it differently than expected.
fn complaints(place: &Place, forgery: &Forgery) -> Vec<String> {
    let mut complaints = Vec::new();
    for command in place::COMMANDS {
        // Commands that only read leave the folder as it is.
        if command == place::COMMANDS[0] || place::WRITING.contains(&command) {
            (forgery.forge)(&place.victim());
        }
        let before = place.outside();
        let Ended { code, said } = place.run(command);
        let names = forgery.words.iter().any(|words| said.contains(words));
        // A folder with another plan is not continued, so nobody looks at what is wrong with it.
        let passed_over = command == "run --resume" && forgery.of_plan && code == Some(2);
        // A user may name a plan by a link; what the link leads to is the plan here.
        let is_given = command == "run-cell" && forgery.name == "plan: linked to elsewhere";
        let fault = if is_given && code == Some(0) {
            continue;
        } else if !matches!(code, Some(1 | 2)) {
            format!("ended with {code:?}")
        } else if !names && !passed_over {
            format!("named none of {:?}", forgery.words)
        } else if said.contains("panicked") {
            "panicked".to_owned()
        } else if place.outside() != before {
            "wrote outside the folder".to_owned()
        } else {
            continue;
        };
        complaints.push(format!("{}, {command}: {fault}:\n{said}", forgery.name));
    }
    complaints
}

#[test]
fn every_forgery_is_named_by_whatever_prints_a_figure() {
    let forgeries = forgery::all();
    assert!(forgeries.len() >= 40, "{}", forgeries.len());
    let half = forgeries.len() / 2;
    let complaints: Vec<String> = std::thread::scope(|scope| {
        let shares = [&forgeries[..half], &forgeries[half..]].map(|share| {
            scope.spawn(move || {
                let place = Place::new();
                let all = share.iter().map(|forgery| complaints(&place, forgery));
                all.flatten().collect::<Vec<_>>()
            })
        });
        let ended = shares.into_iter().map(|share| share.join().unwrap());
        ended.flatten().collect()
    });
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn an_honest_folder_is_believed_and_a_hard_link_is_a_file_too() {
    let place = Place::new();
    for command in place::COMMANDS {
        let victim = place.victim();
        fs::hard_link(victim.cell.join("ticks.csv"), place.path("outside/hard")).unwrap();
        let Ended { code, said } = place.run(command);
        // The folder's clients are not those that a calibration needs.
        let expected = if command == "calibrate" { 1 } else { 0 };
        assert_eq!(code, Some(expected), "{command}: {said}");
        assert!(!said.contains("not whole"), "{command}: {said}");
        fs::remove_file(place.path("outside/hard")).unwrap();
    }
}

/// One that was not waited for long enough on a busy machine.
#[test]
fn an_echo_that_says_nothing_is_in_the_rows_and_not_in_the_certificate() {
    let place = Place::new();
    let victim = place.victim();
    edit_json(&victim.cell.join("manifest.json"), |manifest| {
        let sent = &mut manifest["certificate"]["sent"];
        *sent = (sent.as_u64().unwrap() - 1).into();
    });
    let Ended { code, said } = place.run("show");
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_run_without_its_manifest_did_not_end_and_is_made_again_where_that_is_asked() {
    let place = Place::new();
    for whole in [false, true] {
        let gone = |command: &str| {
            let victim = place.victim();
            if whole {
                fs::remove_dir_all(&victim.cell).unwrap();
            } else {
                fs::remove_file(victim.cell.join("manifest.json")).unwrap();
            }
            place.run(command)
        };
        for command in ["compare", "compare back", "agree", "report", "collect"] {
            let Ended { code, said } = gone(command);
            assert_eq!(code, Some(1), "{command}: {said}");
            assert!(said.contains(place.cell_id()), "{command}: {said}");
        }
        let Ended { code, said } = gone("run --resume");
        assert_eq!(code, Some(0), "{said}");
        let Ended { code, said: shown } = gone("show");
        assert_eq!(code, Some(1), "{shown}");
        assert!(
            shown.contains("1 of the plan's 4 cells have not been run"),
            "{shown}"
        );
        for command in ["compare --allow-missing", "agree --allow-missing"] {
            let Ended { code, said } = gone(command);
            assert_eq!(code, Some(0), "{command}: {said}");
        }
    }
}

#[test]
fn a_run_that_is_not_complete_is_no_pass_unless_that_is_allowed() {
    let place = Place::new();
    for verdict in ["failed", "invalid", "unsupported"] {
        for (command, code) in [
            ("compare", 1),
            ("compare back", 1),
            ("agree", 1),
            ("compare --allow-missing", 0),
            ("agree --allow-missing", 0),
        ] {
            let victim = place.victim();
            edit_json(&victim.manifest(), |manifest| {
                manifest["verdict"] = verdict.into();
                manifest["reasons"] = ["it was so"].into();
            });
            let ended = place.run(command);
            assert_eq!(ended.code, Some(code), "{command}: {}", ended.said);
            let is_named = ended
                .said
                .contains(&format!("{} is {verdict}", place.cell_id()));
            assert_eq!(is_named, code == 1, "{command}: {}", ended.said);
        }
    }
}

#[test]
fn runs_of_another_kind_are_not_gone_on_with() {
    let place = Place::new();
    let other = |at: &'static str, value: &'static str| {
        move |victim: &place::Victim| {
            // In all manifests, so that they are of one kind.
            for manifest in victim.manifests() {
                edit_json(&manifest, |manifest| manifest[at] = value.into());
            }
        }
    };
    for command in VERSIONED {
        let victim = place.victim();
        other("webloop", "0.0.7")(&victim);
        let Ended { code, said } = place.run(command);
        assert_eq!(code, Some(2), "{command}: {said}");
        assert!(said.contains("version of webloop is 0.0.7"), "{said}");

        let victim = place.victim();
        other("backend", "netns")(&victim);
        other("player", "user")(&victim);
        let Ended { code, said } = place.run(command);
        assert_eq!(code, Some(2), "{command}: {said}");
        assert!(said.contains("back-end is netns, and now sim"), "{said}");
    }
    // The other way round, before anything is started.
    place.victim();
    for command in ["run by netns", "run-cell by netns"] {
        let Ended { code, said } = place.run(command);
        assert_eq!(code, Some(2), "{command}: {said}");
        assert!(said.contains("back-end is sim, and now netns"), "{said}");
    }
    // The player is compared only if one is requested.
    let victim = place.victim();
    other("backend", "netns")(&victim);
    other("player", "user")(&victim);
    let Ended { code, said } = place.run("run by netns and tc");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("player is user, and now tc"), "{said}");
}

#[test]
fn what_is_damaged_is_made_again_where_that_is_asked_and_kept_aside() {
    let place = Place::new();
    let victim = place.victim();
    edit(&victim.cell.join("ticks.csv"), |text| {
        text.replacen("1,", "2,", 1)
    });
    let refused = place.run("run --resume");
    assert_eq!(refused.code, Some(1), "{}", refused.said);
    assert!(refused.said.contains("--failed"), "{}", refused.said);
    let again = place.run("run --failed");
    assert_eq!(again.code, Some(0), "{}", again.said);
    let aside = format!("{}.unfinished-1", victim.cell.display());
    assert!(fs::exists(aside).unwrap());
    assert_eq!(place.run("show").code, Some(0));
}

#[test]
fn what_is_written_goes_into_the_folder_and_nowhere_else() {
    let place = Place::new();
    // Names that lead out of the folder are refused, or replaced if the file can be made again.
    for (name, command, code) in [
        (".lock", "run --resume", 2),
        ("plan.partial", "run --resume", 0),
        ("summary.csv", "run --resume", 0),
        ("summary.partial", "run --resume", 0),
        ("table.txt", "run --resume", 0),
        ("summary.csv", "report", 0),
        ("report", "report", 2),
        ("report/figures", "report", 2),
        ("report/report.html", "report", 0),
    ] {
        let victim = place.victim();
        let path = victim.folder.join(name);
        let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let is_folder = matches!(name, "report" | "report/figures");
        let target = if is_folder {
            "outside"
        } else {
            "outside/decoy"
        };
        symlink(place.path(target), &path).unwrap();
        let before = place.outside();
        let ended = place.run(command);
        assert_eq!(ended.code, Some(code), "{name}, {command}: {}", ended.said);
        assert_eq!(place.outside(), before, "{name}, {command}");
        if code != 0 {
            assert!(ended.said.contains(name), "{name}: {}", ended.said);
        }
    }
}
