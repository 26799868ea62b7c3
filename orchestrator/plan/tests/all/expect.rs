//! What experiments expect of their runs is kept in their plans, and mistakes in it are placed and answered.
#![allow(clippy::unwrap_used)]

use plan::{Instead, Plan, ProfileText};

const CELLS: &str = "[[cells]]\ntopology = [\"couva\", \"diego-vpn\"]\nclient = [\"native\", \"python\"]\n\
                     mode = [\"closed\", \"open\"]\nh = \"3ms\"\nduration = \"1s\"\nrepeats = 2\n";

fn resolve_with(lines: &str, cells: &str, instead: &Instead) -> Result<Plan, plan::Diagnostic> {
    let source = format!("name = \"mine\"\n{lines}\n{cells}");
    let profile = |name: &str| {
        Ok(ProfileText {
            source: link::Profile::builtin(name).unwrap().to_owned(),
            ..ProfileText::default()
        })
    };
    Plan::resolve(&source, "mine.toml", instead, profile)
}

fn resolve(lines: &str, cells: &str) -> Plan {
    resolve_with(lines, cells, &Instead::default()).unwrap()
}

/// Each clause, with the cells it is asked of, without what follows their rate.
fn asked(plan: &Plan) -> String {
    let of = |index: &usize| {
        let id = &plan.cell(*index).unwrap().id;
        let (words, _) = id.rsplit_once('-').unwrap();
        words.replace("-333hz", "")
    };
    let line = |expected: &plan::Expectation| {
        let clauses: Vec<String> = expected.clauses.iter().map(ToString::to_string).collect();
        let cells: Vec<String> = expected.cells.iter().map(of).collect();
        format!("{}: {}", clauses.join(", "), cells.join(" "))
    };
    let lines: Vec<String> = plan.expect.iter().map(line).collect();
    lines.join("\n")
}

const EXPECT: &str = "[expect]\nstable = \"all\"\nsettling = \"<= 400ms in 90%\"\nrtt.p99 = \"<= 80ms\"\n\
                      confidence = \"95%\"\n";

#[test]
fn a_clause_is_asked_of_the_cells_that_have_its_figure() {
    insta::assert_snapshot!(asked(&resolve(EXPECT, CELLS)), @"
    holds, settling <= 400ms in 90% at 95%: couva-native-closed-r01 couva-python-closed-r01 diego-vpn-native-closed-r01 diego-vpn-python-closed-r01 couva-native-closed-r02 couva-python-closed-r02 diego-vpn-native-closed-r02 diego-vpn-python-closed-r02
    rtt.p99 <= 80ms: couva-native-closed-r01 couva-python-closed-r01 diego-vpn-native-closed-r01 diego-vpn-python-closed-r01 couva-native-open-r01 couva-python-open-r01 diego-vpn-native-open-r01 diego-vpn-python-open-r01 couva-native-closed-r02 couva-python-closed-r02 diego-vpn-native-closed-r02 diego-vpn-python-closed-r02 couva-native-open-r02 couva-python-open-r02 diego-vpn-native-open-r02 diego-vpn-python-open-r02
    ");
}

#[test]
fn a_block_has_clauses_of_its_own_and_replaces_those_on_the_same_figure() {
    let block = |topology: &str, more: &str| {
        let line = CELLS.replace("[\"couva\", \"diego-vpn\"]", &format!("\"{topology}\""));
        let line = line.replace("[\"native\", \"python\"]", "\"native\"");
        line.replace("[\"closed\", \"open\"]", "\"closed\"") + more
    };
    let blocks = block("couva", "")
        + &block(
            "diego-vpn",
            "expect = { settling = \"<= 2s\", sent = \">= 99%\", rtt.p99 = \"<= 200ms\" }\n",
        );
    insta::assert_snapshot!(asked(&resolve(EXPECT, &blocks)), @"
    holds: couva-native-closed-r01 diego-vpn-native-closed-r01 couva-native-closed-r02 diego-vpn-native-closed-r02
    settling <= 400ms in 90% at 95%, rtt.p99 <= 80ms: couva-native-closed-r01 couva-native-closed-r02
    settling <= 2s, sent >= 99%, rtt.p99 <= 200ms: diego-vpn-native-closed-r01 diego-vpn-native-closed-r02
    ");

    // Where both blocks have become the same cells, both are asked.
    let only = Instead {
        topology: vec!["arima".to_owned()],
        ..Instead::default()
    };
    let joined = resolve_with(EXPECT, &blocks, &only).unwrap();
    insta::assert_snapshot!(asked(&joined), @"holds, settling <= 400ms in 90% at 95%, rtt.p99 <= 80ms, settling <= 2s, sent >= 99%, rtt.p99 <= 200ms: arima-native-closed-r01 arima-native-closed-r02");
}

#[test]
fn what_is_expected_changes_no_cell_and_a_plan_without_it_says_nothing_of_it() {
    let bare = resolve("", CELLS);
    let text = bare.to_json();
    assert!(!text.contains("\"expect\"") && !text.contains("\"known\""));
    let known = "[[known]]\ncells = \"diego*\"\nexpect = \"rtt.p99\"\nreason = \"far\"\nuntil = \"2027-06-30\"\n";
    let expected = resolve(&format!("{EXPECT}{known}"), CELLS);
    assert_eq!(expected.cells, bare.cells);
    assert!(expected.has_runs_of(&bare) && expected != bare);
    assert_eq!(
        expected.difference(&bare).unwrap(),
        "what is expected of the runs in two ways"
    );
    assert!(!expected.has_runs_of(&resolve("seed = 2", CELLS)));
    assert_eq!(Plan::from_json(&expected.to_json()).unwrap(), expected);
}

#[test]
fn a_plan_that_expects_something_of_a_cell_it_does_not_have_is_refused() {
    let mut plan = resolve(EXPECT, CELLS);
    plan.expect[0].cells.insert(99);
    let said = Plan::from_json(&plan.to_json()).unwrap_err().to_string();
    assert!(said.contains("expects something of cell 99"), "{said}");
}

#[test]
fn a_known_failure_may_match_nothing_only_where_other_cells_took_the_place_of_the_experiment_s() {
    let known = "[[known]]\ncells = \"diego\"\nreason = \"far\"\n";
    let only = Instead {
        topology: vec!["arima".to_owned()],
        ..Instead::default()
    };
    assert_eq!(resolve_with(known, CELLS, &only).unwrap().known.len(), 1);
}

#[test]
fn a_mistake_in_what_is_expected_is_placed_and_answered() {
    let mistakes = [
        "[expect]\nsetling = \"<= 3ms\"",
        "[expect]\nsettling = \"<= 3\"",
        "[expect]\nsettling = \"3ms\"",
        "[expect]\nstable = \"most\"",
        "[expect]\nstable = true",
        "[expect]\nrtt.p95 = \"<= 3ms\"",
        "[expect]\nsent = \">= 99% in 101%\"",
        "[expect]\nsent = \">= 99% at 95%\"",
        "[expect]\nstable = \"all\"\nconfidence = \"sure\"",
        "[[known]]\ncells = \"atlantis\"\nreason = \"it sank\"",
        "[[known]]\ncells = \"couva\"",
        "[[known]]\ncells = \"couva\"\nexpect = \"speed\"\nreason = \"x\"",
        "[[known]]\ncells = \"couva\"\nuntil = \"June\"\nreason = \"x\"",
    ];
    let of_block = [
        "expect = { overshoot = \"<= 20\" }",
        "expect = { settling = \"<= 3ms\" }",
    ];
    let open = CELLS.replace("[\"closed\", \"open\"]", "\"open\"");
    let whole = mistakes.map(|lines| (lines, resolve_with(lines, CELLS, &Instead::default())));
    let own = of_block.map(|line| {
        (
            line,
            resolve_with("", &format!("{open}{line}\n"), &Instead::default()),
        )
    });
    let answers = whole.into_iter().chain(own);
    let answers: Vec<String> = answers
        .map(|(lines, answer)| format!("{}:\n  {}", lines.replace('\n', " "), answer.unwrap_err()))
        .collect();
    insta::assert_snapshot!(answers.join("\n"));
}
