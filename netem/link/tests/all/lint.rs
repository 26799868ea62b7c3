//! Profiles that cannot be played, or say something odd: each is refused or
//! warned of at its place, with a remedy. The findings are a snapshot that a
//! person has read.
#![allow(clippy::unwrap_used)]

use link::{Profile, Severity};

/// A profile around the keys of one direction.
fn path(keys: &str) -> String {
    format!("name = 'p'\nabout = ''\n[both]\n{keys}\n")
}

fn findings(source: &str) -> Vec<link::Diagnostic> {
    let files = |_: &str| Ok("t_ms,delay_ms\n0,1\n5,oops\n".to_owned());
    Profile::read(source, "p.toml", &files).1
}

#[test]
fn every_slip_is_found_at_its_place_with_a_remedy() {
    let delay = |keys: &str| path(&format!("delay = {{ base = '2ms', {keys} }}"));
    let with = |keys: &str| path(&format!("delay.base = '2ms'\n{keys}"));
    let fault = |keys: &str| format!("fault = [{{ {keys} }}]\n{}", path("delay.base = '2ms'"));
    let cases = [
        "name = ".to_owned(),
        "name = 'A b'\nabout = ''\nboth.delay.base = '1ms'".to_owned(),
        "name = 'p'\nabout = ''".to_owned(),
        "name = 'p'\nabout = ''\nup.delay.base = '1ms'".to_owned(),
        "name = 'p'\nabout = ''\nloopback = true\nboth.delay.base = '1ms'".to_owned(),
        path("delay.base = '-1ms'"),
        path("delay.base = '10'"),
        path("delay.base = 10"),
        path("delay.base = 'nan'"),
        path("delay.base = '1e30s'"),
        path("dleay.base = '1ms'"),
        path("rate = '1mbit'"),
        with("trace.steps = [{ t = '0s', delay = '1ms' }]"),
        delay("hold = '10ms'"),
        delay("spread.exponential.mean = '1ms'"),
        delay("hold = '0ms', spread.exponential.mean = '1ms'"),
        delay("hold = '1us', spread.exponential.mean = '1ms'"),
        delay("hold = '10ms', min = '5ms', max = '4ms', spread.exponential.mean = '1ms'"),
        delay("hold = '10ms', spread.normal = { mean = '0ms', sd = '1ms' }"),
        delay("hold = '10ms', min = '2ms', spread.normal = { mean = '0ms', sd = '1ms' }"),
        delay("hold = '10ms', spread.gamma = { mean = '1ms', sd = '0ms' }"),
        delay("hold = '10ms', spread.gamma = { mean = '1ms', sd = '1s' }"),
        delay(
            "hold = '10ms', spread.beta = { min = '0ms', max = '9ms', mean = '9ms', sd = '1ms' }",
        ),
        delay(
            "hold = '10ms', spread.beta = { min = '0ms', max = '9ms', mean = '1ms', sd = '5ms' }",
        ),
        delay("hold = '10ms', spread.pareto = { scale = '1ms', shape = -1.0 }"),
        delay("hold = '10ms', spread.pareto = { scale = '1ms', shape = nan }"),
        delay("hold = '10ms', spread.pareto = { scale = '1ms', shape = 1.0 }"),
        delay("hold = '10ms', spread.table = [['0%', '2ms'], ['100%', '1ms']]"),
        delay("hold = '10ms', spread.table = [['0%', '0ms'], ['50%', '1ms']]"),
        delay("hold = '10ms', spread.weibull.mean = '1ms'"),
        with("stall = { every = '1s', length.exponential.mean = '2s' }"),
        with("stall = { every = '3s', length.exponential.mean = '2s' }"),
        with("stall = { every = '3s', length.normal = { mean = '1s', sd = '1s' } }"),
        with("loss.random.share = '120%'"),
        with("loss.random.share = '100%'"),
        with("loss.gilbert-elliott = { good = '1s', bad = '1us' }"),
        with("loss.gilbert-elliott = { good = '1s', bad = '1s', in-good = '5%', in-bad = '1%' }"),
        with("limit = 10"),
        with("rate = '1mbit'\nlimit = 0"),
        with("rate = '1kbps'"),
        with("rate = '100bit'"),
        with("rate = '0mbit'"),
        fault("at = '1s', for = '1s'"),
        fault("at = '1s', down = true"),
        fault("at = '1s', for = '0s', down = true"),
        fault("at = '1s', for = '1s', down = true, reset = true"),
        fault("at = '1s', for = '1s', down = false"),
        fault("at = '1s', for = '1s', lost = '3%'"),
        fault("at = '1s', for = '1s', loss = '130%'"),
        fault("at = '1s', for = '1s', loss = '100%'"),
        fault("at = '1s', for = '1s', corrupt = '0%'"),
        fault("at = '1s', for = '1s', delay = '0ms'"),
        fault("at = '1s', for = '1s', delay = '2h'"),
        fault("at = '1s', for = '1s', delay = '4000s'"),
        fault("at = '1s', for = '1s', duplicate = '3%', by = '1ms'"),
        fault("at = '1s', for = '1s', every = '500ms', down = true"),
        fault("at = '1s', for = '1s', period = '500ms', down = true"),
        fault("at = '1s', for = '1s', every = '2s', period = '2s', down = true"),
        fault("at = '1s', for = '1s', period = '1s', down = true"),
        fault("at = '1s', for = '1s', times = 3, down = true"),
        fault("at = '1s', for = '1s', every = '2s', times = 0, down = true"),
        fault("at = '1s', for = '100us', every = '2s', loss = '50%'"),
        fault("at = '1s', for = '1us', period = '20us', delay = '1s'"),
        fault("way = 'across', at = '1s', for = '1s', down = true"),
        fault("way = 'up', at = '1s', for = '1s', rebind = true"),
        "name = 'p'\nabout = ''\nloopback = true\nfault = [{ at = '1s', for = '1s', down = true }]"
            .to_owned(),
        path("trace.steps = []"),
        path("trace.steps = [{ t = '1s', delay = '1ms' }]"),
        path("trace.steps = [{ t = '0s', delay = '1ms' }, { t = '0s', delay = '1ms' }]"),
        path(
            "trace = { repeat = '1s', steps = [{ t = '0s', delay = '1ms' }, { t = '2s', delay = '1ms' }] }",
        ),
        path("trace.file = 'walk.csv'"),
        "name = 'p'\nabout = ''\nboth.delay.base = '5ms'\nasked = { min = '9ms', avg = '8ms', \
         max = '20ms', sd = '9ms', loss = '0%' }"
            .to_owned(),
        "name = 'p'\nabout = ''\nboth.delay.base = '5ms'\nasked = { min = '7ms', avg = '8ms', \
         max = '20ms', sd = '9ms', loss = '0%' }"
            .to_owned(),
    ];
    let mut report = String::new();
    for source in cases {
        let found = findings(&source);
        assert!(!found.is_empty(), "nothing found in\n{source}");
        for finding in found {
            assert!(!finding.remedy.is_empty());
            assert!(finding.span.end <= source.len());
            let quoted = &source[finding.span.clone()];
            let quoted = quoted.lines().next().unwrap_or_default();
            report.push_str(&format!("{finding}\n    {quoted}\n"));
        }
    }
    insta::assert_snapshot!(report);
}

#[test]
fn one_reading_finds_every_error() {
    let source = path("limit = 0\nloss.random.share = '2'\ndelay = { base = '1', hold = '0ms' }");
    let found = findings(&source);
    assert_eq!(found.len(), 4, "{found:?}");
    assert!(found.is_sorted_by_key(|f| (f.line, f.column)));
}

#[test]
fn a_warning_alone_does_not_refuse_a_profile() {
    let source = path("delay.base = '2ms'\nloss.random.share = '100%'");
    let (profile, found) = Profile::read(&source, "p", &|_| Err(String::new()));
    assert!(profile.is_some());
    assert_eq!(found[0].severity, Severity::Warning);
    assert!(Profile::parse(&source, "p").is_ok());
}

#[test]
fn line_and_column_count_characters_from_one() {
    let source = "name = 'p'\nabout = 'Zürich' # ü\nboth.delay.base = '1'\n";
    let found = findings(source);
    assert_eq!((found[0].line, found[0].column), (3, 19));
}
