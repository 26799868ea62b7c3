//! A comparison of folders of which one lacks runs.
#![allow(clippy::unwrap_used)]

use std::fs;

use crate::gate::{experiment, far, webloop};

#[test]
fn a_comparison_fails_when_runs_are_gone_unless_they_are_allowed_by_name() {
    let place = tempfile::tempdir().unwrap();
    experiment(place.path(), "");
    for folder in ["a", "b"] {
        let run = format!("run mine.toml --backend sim --out {folder}");
        assert_eq!(webloop(place.path(), &run).0, Some(0));
    }
    assert_eq!(webloop(place.path(), "compare a b").0, Some(0));
    let cell = far(place.path(), "b");
    let id = cell.file_name().unwrap().to_str().unwrap().to_owned();
    fs::remove_dir_all(&cell).unwrap();
    let (code, said) = webloop(place.path(), "compare a b");
    assert!(
        code == Some(1) && said.contains(&format!("b: {id} has not been run")),
        "{said}"
    );
    assert_eq!(
        webloop(place.path(), "compare a b --allow diego*").0,
        Some(0)
    );
    assert_eq!(
        webloop(place.path(), "compare a b --allow arima").0,
        Some(1)
    );
    let (code, said) = webloop(place.path(), "compare a b --allow atlantis");
    assert!(
        code == Some(2) && said.contains("no cell of either folder matches"),
        "{said}"
    );

    // Damaged as well, and allowed too.
    let other = far(place.path(), "b");
    fs::write(other.join("ticks.csv"), "nothing").unwrap();
    let (code, said) = webloop(place.path(), &format!("compare a b --allow {id}"));
    assert!(code == Some(1) && said.contains("ticks.csv"), "{said}");
    let name = other.file_name().unwrap().to_str().unwrap();
    let both = format!("compare a b --allow {id} --allow {name}");
    assert_eq!(webloop(place.path(), &both).0, Some(0));

    // Gone from the plan itself.
    let text = fs::read_to_string(place.path().join("mine.toml")).unwrap();
    fs::write(
        place.path().join("mine.toml"),
        text.replace("repeats = 2", "repeats = 1"),
    )
    .unwrap();
    assert_eq!(
        webloop(place.path(), "run mine.toml --backend sim --out c").0,
        Some(0)
    );
    let (code, said) = webloop(place.path(), "compare a c");
    assert!(
        code == Some(1) && said.contains(&format!("a: {id} is complete, and c does not have it")),
        "{said}"
    );
    assert_eq!(webloop(place.path(), "compare a c --allow r02").0, Some(0));
    assert_eq!(
        webloop(place.path(), "compare a c --allow-missing").0,
        Some(0)
    );
}
