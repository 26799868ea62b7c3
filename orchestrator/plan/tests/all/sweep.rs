//! What is no sweep is refused with its place, the reason and the remedy.

use plan::sweep::Axis;
use plan::{Instead, Plan, ProfileText};

const HEAD: &str = "name = \"a\"\n[sweep]\nduration = \"1s\"\n";

fn refused(source: &str, instead: &Instead) -> String {
    let built_in = |name: &str| -> Result<ProfileText, String> {
        let source = link::Profile::builtin(name);
        let source = source.ok_or_else(|| format!("there is no topology `{name}`"))?;
        Ok(ProfileText {
            source: source.to_owned(),
            ..ProfileText::default()
        })
    };
    let refused = Plan::resolve(source, "test.toml", instead, built_in);
    refused.map(|_| ()).expect_err(source).to_string()
}

#[test]
fn mistakes_are_told_with_their_place_and_what_to_do() {
    let cases = [
        ("name = 7".to_owned(), "not even a name"),
        (HEAD.to_owned(), "no link"),
        (
            format!("{HEAD}rtt = \"1ms\"\ntopology = \"couva\"\n"),
            "a link twice",
        ),
        (format!("{HEAD}topology = \"nowhere\"\n"), "no such link"),
        (format!("{HEAD}rtt = 5\n"), "no unit"),
        (format!("{HEAD}rtt = \"5\"\n"), "no unit in a text"),
        (format!("{HEAD}rtt = []\n"), "an empty list"),
        (
            format!("{HEAD}rtt = [\"1ms\", \"1000us\"]\n"),
            "one level twice",
        ),
        (format!("{HEAD}rtt = \"1 from 0ms to 9ms\"\n"), "one step"),
        (
            format!("{HEAD}rtt = \"3 steps from 0ms to 9ms\"\n"),
            "a misspelt scale",
        ),
        (
            format!("{HEAD}rtt = \"3 log from 0ms to 9ms\"\n"),
            "a logarithm of nothing",
        ),
        (format!("{HEAD}rtt = \"1ms\"\nloss = \"1.5\"\n"), "no share"),
        (format!("{HEAD}rtt = \"1ms\"\nkp = \"loud\"\n"), "no gain"),
        (
            format!("{HEAD}rtt = \"1ms\"\nkp = nan\n"),
            "a gain that is no number",
        ),
        (
            format!("{HEAD}rtt = \"1ms\"\nh = \"100ms\"\n"),
            "ten samples",
        ),
        (
            format!("{HEAD}rtt = \"1ms\"\nclient = \"lynx\"\n"),
            "no client",
        ),
        (
            format!("{HEAD}rtt = \"1ms\"\noutstanding = 0\n"),
            "no requests",
        ),
        (
            format!("{HEAD}rtt = \"1ms\"\ndelay = \"1ms\"\n"),
            "no such axis",
        ),
        (
            format!("{HEAD}hold = \"1us\"\nrtt = \"80ms\"\njitter = \"9ms\"\n"),
            "a link that cannot be played",
        ),
        (format!("{HEAD}repeats = 0\nrtt = \"1ms\"\n"), "no repeats"),
        (
            format!("{HEAD}rho = -1.0\nrtt = \"1ms\"\n"),
            "a negative cost",
        ),
        (
            format!("{HEAD}rtt = \"1ms\"\n[expect]\nholds = \"all\"\n"),
            "expectations beside it",
        ),
        (
            format!(
                "{HEAD}rtt = \"9999 from 0ms to 9s\"\n\
                 kp = \"9999 from 0.1 to 0.2\"\n"
            ),
            "too many",
        ),
    ];
    let told: Vec<String> = cases
        .iter()
        .map(|(source, case)| format!("{case}:\n  {}", refused(source, &Instead::default())))
        .collect();
    insta::assert_snapshot!(told.join("\n"));
}

#[test]
fn what_is_fixed_takes_an_axis_s_place() {
    let source = format!("{HEAD}rtt = [\"1ms\", \"2ms\"]\nkp = [0.1, 0.2]\n");
    let none = |_: &str| Err("none".to_owned());
    let instead = Instead {
        seed: Some(9),
        fixed: vec![(Axis::Kp, "0.15".to_owned()), (Axis::H, "1ms".to_owned())],
        ..Instead::default()
    };
    let sweep = Plan::resolve(&source, "test.toml", &instead, none).expect("a sweep");
    let sweep = sweep.swept().expect("a sweep").expect("a sweep");
    assert_eq!((sweep.seed, sweep.grid.points()), (9, 2));
    assert_eq!(sweep.grid.point(1).kp, Some(0.15));
    let instead = Instead {
        fixed: vec![(Axis::Kp, "loud".to_owned())],
        ..Instead::default()
    };
    assert!(refused(&source, &instead).contains("`loud` is not a number"));
}
