//! Every claim that the program carries has its point on the page about the paper, and every id there is a claim's.

use std::collections::BTreeSet;
use std::fs;

use crate::book::page::ROOT;

#[test]
fn each_claim_of_the_paper_is_a_point_of_its_page() {
    let text =
        |path: &str| fs::read_to_string(format!("{ROOT}/{path}")).expect("in the repository");
    let table: toml::Table = text("orchestrator/paper/claims.toml")
        .parse()
        .expect("TOML");
    let claims = table["claim"].as_array().expect("claims").iter();
    let claims: BTreeSet<String> = claims
        .filter_map(|claim| Some(claim["id"].as_str()?.to_owned()))
        .collect();
    let page = text("docs/paper.md");
    let (_, points) = page
        .split_once("## Every point of the text")
        .expect("its section");
    let named: BTreeSet<String> = points
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect();
    assert_eq!(named, claims);
    let numbers = points.lines().filter_map(|line| {
        let (number, _) = line.strip_prefix("| ")?.split_once(" |")?;
        number.parse::<usize>().ok()
    });
    assert!(numbers.eq(1..=39), "39 points, in the paper's order");
}
