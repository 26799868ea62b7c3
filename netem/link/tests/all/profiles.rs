//! The files in `netem/profiles`: valid, described, and their schema current.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use link::{Link, LinkTime, Profile, describe, schema};

const EXAMPLE: &str = include_str!("../../../profiles/example.toml");
const SCHEMA: &str = include_str!("../../../profiles/profile.schema.json");

fn read(source: &str, name: &str) -> Profile {
    let (profile, findings) = Profile::read(source, name, &|_| Err(String::new()));
    assert_eq!(findings, vec![], "{name}");
    profile.unwrap()
}

#[test]
fn every_profile_is_valid_without_a_warning_and_called_as_its_file() {
    for name in Profile::BUILTIN.iter().chain(Profile::READINGS) {
        let profile = read(Profile::builtin(name).unwrap(), name);
        assert_eq!(profile.name(), *name);
        assert_eq!(profile.is_loopback(), *name == "arima");
    }
    read(EXAMPLE, "example");
    assert_eq!(Profile::builtin("tobago"), None);
    // Each of the paper's has one plain name, which is the same link.
    let papers = Profile::PLAIN.iter().map(|(_, papers)| *papers);
    assert!(papers.eq(Profile::BUILTIN.iter().copied()));
    for (plain, papers) in Profile::PLAIN {
        assert_eq!(Profile::builtin(plain), Profile::builtin(papers));
    }
}

#[test]
fn the_smallest_profile_is_three_lines() {
    let profile = read("name = 'p'\nabout = ''\nboth.delay.base = '2ms'\n", "p");
    let mut link = Link::new(&profile, 1);
    let mut empty = Link::new(&Profile::empty(), 1);
    let at = LinkTime::from_ns(5);
    assert_eq!(link.up.state_at(at), empty.up.state_at(at));
    assert_eq!(link.down.state_at(at).delay_ns, 2_000_000);
}

#[test]
fn the_committed_schema_is_current() {
    if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../profiles/profile.schema.json"
        );
        return std::fs::write(path, schema()).unwrap();
    }
    assert!(
        schema() == SCHEMA,
        "WEBLOOP_TEST_WRITE=1 writes profile.schema.json anew"
    );
}

#[test]
fn links_are_described_in_plain_words() {
    for name in Profile::BUILTIN.iter().chain(Profile::READINGS) {
        let profile = read(Profile::builtin(name).unwrap(), name);
        insta::assert_snapshot!(*name, describe(&profile));
    }
    insta::assert_snapshot!("example", describe(&read(EXAMPLE, "example")));
}

#[test]
fn a_manifest_holds_everything_that_the_link_follows_from() {
    let couva = read(Profile::builtin("couva").unwrap(), "couva");
    insta::assert_snapshot!(serde_json::to_string_pretty(&couva).unwrap());
}
