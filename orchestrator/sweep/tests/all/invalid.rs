//! What is no sweep is refused with its place, the reason and the remedy.

use plan::ProfileText;
use sweep::{Axis, Instead, Sweep};

const HEAD: &str = "name = \"a\"\nduration = \"1s\"\n";

fn refused(source: &str, instead: &Instead) -> String {
    let none = |name: &str| -> Result<ProfileText, String> {
        Err(format!("there is no topology `{name}`"))
    };
    let refused = Sweep::resolve(source, "test.toml", instead, none);
    refused.map(|_| ()).expect_err(source).to_string()
}

#[test]
fn mistakes_are_told_with_their_place_and_what_to_do() {
    let cases = [
        ("name = 7".to_owned(), "not even a name"),
        (format!("{HEAD}[axes]\n"), "no link"),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\ntopology = \"couva\"\n"),
            "a link twice",
        ),
        (
            format!("{HEAD}[axes]\ntopology = \"nowhere\"\n"),
            "no such link",
        ),
        (format!("{HEAD}[axes]\nrtt = 5\n"), "no unit"),
        (format!("{HEAD}[axes]\nrtt = \"5\"\n"), "no unit in a text"),
        (format!("{HEAD}[axes]\nrtt = []\n"), "an empty list"),
        (
            format!("{HEAD}[axes]\nrtt = [\"1ms\", \"1000us\"]\n"),
            "one level twice",
        ),
        (
            format!("{HEAD}[axes]\nrtt = {{ from = \"0ms\", to = \"9ms\", steps = 1 }}\n"),
            "one step",
        ),
        (
            format!("{HEAD}[axes]\nrtt = {{ from = \"0ms\", to = \"9ms\", step = 1 }}\n"),
            "a misspelt key of a range",
        ),
        (
            format!(
                "{HEAD}[axes]\nrtt = {{ from = \"0ms\", to = \"9ms\", steps = 3, scale = \"log\" }}\n"
            ),
            "a logarithm of nothing",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\nloss = \"1.5\"\n"),
            "no share",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\nkp = \"loud\"\n"),
            "no gain",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\nkp = nan\n"),
            "a gain that is no number",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\nh = \"100ms\"\n"),
            "ten samples",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\nclient = \"lynx\"\n"),
            "no client",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\noutstanding = 0\n"),
            "no requests",
        ),
        (
            format!("{HEAD}[axes]\nrtt = \"1ms\"\ndelay = \"1ms\"\n"),
            "no such axis",
        ),
        (
            format!("{HEAD}hold = \"1us\"\n[axes]\nrtt = \"80ms\"\njitter = \"9ms\"\n"),
            "a link that cannot be played",
        ),
        (
            format!("{HEAD}repeats = 0\n[axes]\nrtt = \"1ms\"\n"),
            "no repeats",
        ),
        (
            format!("{HEAD}rho = -1.0\n[axes]\nrtt = \"1ms\"\n"),
            "a negative cost",
        ),
        (
            format!(
                "{HEAD}[axes]\nrtt = {{ from = \"0ms\", to = \"9s\", steps = 9999 }}\n\
                 kp = {{ from = 0.1, to = 0.2, steps = 9999 }}\n"
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
    let source = format!("{HEAD}[axes]\nrtt = [\"1ms\", \"2ms\"]\nkp = [0.1, 0.2]\n");
    let none = |_: &str| Err("none".to_owned());
    let instead = Instead {
        seed: Some(9),
        fixed: vec![(Axis::Kp, "0.15".to_owned()), (Axis::H, "1ms".to_owned())],
    };
    let sweep = Sweep::resolve(&source, "test.toml", &instead, none).expect("a sweep");
    assert_eq!((sweep.seed, sweep.grid.points()), (9, 2));
    assert_eq!(sweep.grid.point(1).kp, Some(0.15));
    let instead = Instead {
        fixed: vec![(Axis::Kp, "loud".to_owned())],
        ..Instead::default()
    };
    assert!(refused(&source, &instead).contains("`loud` is not a number"));
}
