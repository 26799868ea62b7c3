//! What systems do once they are read, and what is said to those that cannot be.

use control::{
    Analysis, StepSettings, largest_stable_round_trip_s, loop_delay_ticks, preset, step_info,
    step_response,
};
use endpoint::{SampleTime, Shape};
use plan::system::{Design, System};

fn h(text: &str) -> SampleTime {
    text.parse().expect("a sample time")
}

fn built_in(name: &str) -> System {
    System::read(System::built_in(name).expect("built in")).expect(name)
}

#[test]
fn the_first_is_the_paper_s_to_the_last_bit() {
    let paper = System::paper();
    assert_eq!(paper.plant().linear(), Some(&preset::paper_plant()));
    assert!(paper.is_paper() && paper.r() == 1.0);
    for text in ["1ms", "3ms", "100ms"] {
        let own = paper.at(h(text)).expect("sampled");
        assert_eq!(own.law, preset::paper_pi().into());
        let Design::Pid(numbers) = own.design else {
            panic!("a PI is a PID");
        };
        assert_eq!(
            (numbers.kp, numbers.ki),
            (preset::PAPER_A0, preset::PAPER_A1)
        );
    }
}

#[test]
fn each_that_is_built_in_settles_at_100_hz_with_two_ticks_around_the_loop_and_with_three() {
    for name in System::built_in_names() {
        let system = built_in(name);
        assert_eq!(system.name(), name);
        assert!(!system.about().is_empty());
        let h = h("10ms");
        let own = system.at(h).expect(name);
        for rtt_ns in [0, 20_000_000] {
            let delay = loop_delay_ticks(rtt_ns, h.ns());
            let y = step_response(&own.plant, own.law.clone(), system.r(), delay, 2_000);
            let t: Vec<f64> = (0..y.len()).map(|k| k as f64 * h.seconds()).collect();
            let settings = StepSettings {
                final_value: Some(system.r()),
                ..StepSettings::default()
            };
            let info = step_info(&t, &y, &settings).expect("finite");
            assert!(
                info.settling_time < 10.0,
                "{name} with {rtt_ns} ns: {info:?}"
            );
            assert!(
                (y[1_999] / system.r() - 1.0).abs() < 1e-2,
                "{name}: {}",
                y[1_999]
            );
        }
    }
}

/// The margin by transfer functions, against the loop itself run with one tick more and one less.
#[test]
fn the_longest_round_trip_by_the_margin_is_where_each_loop_turns() {
    for name in System::built_in_names() {
        let system = built_in(name);
        let h = h("10ms");
        let own = system.at(h).expect(name);
        let open = own.open().expect("finite");
        let Some(longest_s) = largest_stable_round_trip_s(&open) else {
            panic!("{name} is not stable with the shortest round trip");
        };
        assert!(longest_s.is_finite(), "{name}");
        let longest_ns = (longest_s * 1e9).round() as u64;
        let grows = |rtt_ns: u64| {
            let delay = loop_delay_ticks(rtt_ns, h.ns());
            // So small that no limit is ever met.
            const R: f64 = 1e-100;
            let y = step_response(&own.plant, own.law.clone(), R, delay, 40_000);
            let part = |from: usize| {
                let part = y[from..from + 4_000].iter();
                part.fold(0.0, |most: f64, y| most.max((y - R).abs()))
            };
            part(36_000) > part(20_000).max(1e-12 * R)
        };
        assert!(!grows(longest_ns), "{name} at {longest_s} s");
        assert!(grows(longest_ns + h.ns()), "{name} beyond {longest_s} s");
    }
}

/// A diagnostic's place and problem.
fn told(fault: &plan::Diagnostic) -> String {
    format!("{}:{}: {}", fault.line, fault.column, fault.problem)
}

#[test]
fn what_is_no_system_is_told_with_its_place() {
    const GOOD: &str = "name = \"mine\"\n[plant]\nnum = [1.0]\nden = [1.0, 1.0]\n[controller]\nlaw = \"pid\"\nkp = 1.0\n";
    assert!(System::read(GOOD).is_ok());
    let cases = [
        ("mine", "Mine!", "1:8: `Mine!` is not a valid name"),
        (
            "mine",
            "motor",
            "1:8: `motor` is the name of the paper's system",
        ),
        (
            "num = [1.0]\n",
            "",
            "2:1: the plant has only one of num and den",
        ),
        (
            "num = [1.0]",
            "num = [1.0]\ngain = 2.0",
            "2:1: the plant has two models",
        ),
        ("[1.0, 1.0]", "[0.0, 1.0]", "4:7: den[0] is 0"),
        (
            "num = [1.0]",
            "num = [1.0, 0.0, 0.0]",
            "3:7: num has degree 2 and den only 1",
        ),
        ("\"pid\"", "\"fuzzy\"", "6:7: law `fuzzy` is unknown"),
        ("kp = 1.0", "ki = 1.0", "5:1: the law has no kp"),
        ("kp = 1.0", "kp = nan", "7:6: kp is NaN"),
        (
            "kp = 1.0",
            "kp = 1.0\nround_trip = \"1ms\"",
            "6:7: `round_trip` is not a key of law `pid`",
        ),
        (
            "kp = 1.0",
            "kp = 1.0\nlimits = { min = 2.0, max = 1.0 }",
            "8:10: the limits from 2 to 1 are empty",
        ),
        (
            "\"pid\"",
            "\"state-feedback\"",
            "6:7: `kp` is not a key of law `state-feedback`",
        ),
        (
            "den = [1.0, 1.0]",
            "den = [1.0, 1.0]\ndead_time = \"2\"",
            "5:13: `2` has no unit",
        ),
        (
            "kp = 1.0",
            "kp = 1.0\nmood = 3",
            "8:1: there is no key `mood`",
        ),
    ];
    for (old, new, expected) in cases {
        let text = GOOD.replacen(old, new, 1);
        let fault = told(&System::read(&text).expect_err(expected));
        assert!(
            fault.starts_with(expected),
            "{expected}\nis told as\n{fault}"
        );
    }
}

#[test]
fn a_system_may_not_fit_every_sample_time() {
    let text = System::built_in("lag")
        .expect("built in")
        .replace("[plant]", "[plant]\nsampling = \"tustin\"");
    let system = System::read(&text).expect("a system");
    assert!(system.at(h("10ms")).is_ok());
    let unfit = system
        .at(h("3ms"))
        .expect_err("200 ms is no multiple of 3 ms");
    assert!(
        unfit
            .to_string()
            .starts_with("system lag cannot run at h = 3ms: a dead time of 200000000 ns"),
        "{unfit}"
    );
}

#[test]
fn a_law_has_as_many_states_as_it_says() {
    for name in System::built_in_names() {
        let h = h("10ms");
        let own = built_in(name).at(h).expect(name);
        let states = own.law.state_space(h.seconds()).expect("finite").order();
        assert_eq!(own.law.order(), states, "{name}");
    }
}

#[test]
fn a_loop_that_looks_back_over_thousands_of_ticks_has_margins_too() {
    let own = built_in("lag-smith").at(h("100us")).expect("sampled");
    let found = Analysis::of(&own.open().expect("finite")).expect("margins");
    assert!(found.longest_s.is_some_and(|s| s > 0.3), "{found:?}");
    let slow = System::built_in("lag")
        .expect("built in")
        .replace("\"200ms\"", "\"60s\"");
    let own = System::read(&slow).expect("a system").at(h("1ms"));
    let open = own.expect("sampled").open().expect("finite");
    // Its dead time is sixty times its lag: the loop is not stable, and that is found.
    assert_eq!(Analysis::of(&open).expect("margins").longest_s, None);
}

#[test]
fn a_law_looks_past_so_many_ticks_and_no_more() {
    for (name, rtt, at, told) in [
        (
            "lag-smith",
            "60s",
            "10us",
            "must span 6020000 ticks of dead time and round trip; the limit is 1000000",
        ),
        (
            "pendulum",
            "1s",
            "1ms",
            "must span 1001 ticks of dead time and round trip; the limit is 300",
        ),
    ] {
        let text: String = System::built_in(name)
            .expect("built in")
            .lines()
            .filter(|line| !line.starts_with("round_trip"))
            .map(|line| match line {
                "[controller]" => format!("{line}\nround_trip = \"{rtt}\"\n"),
                line => format!("{line}\n"),
            })
            .collect();
        let system = System::read(&text).expect("a system");
        let unfit = system.at(h(at)).expect_err("too many").to_string();
        let remedy = "give a longer h, or a shorter round_trip";
        assert!(unfit.ends_with(&format!("{told}: {remedy}")), "{unfit}");
    }
}

#[test]
fn ages_are_measured_where_no_dead_time_is_and_assumed_where_nothing_is_said() {
    let kalman = System::built_in("motor-kalman").expect("built in");
    let measured = System::read(kalman).expect("a system");
    assert!(measured.measures_age() && measured.has_estimator());
    let at = measured.at(h("3ms")).expect("a loop");
    assert!(matches!(at.design, Design::AgedFeedback { h_ns, .. } if h_ns == 3_000_000));
    for text in [
        kalman.replace("age = \"measured\"\n", ""),
        kalman.replace("measured\"", "assumed\""),
    ] {
        let assumed = System::read(&text).expect("a system");
        assert!(!assumed.measures_age());
        let design = assumed.at(h("3ms")).expect("a loop").design;
        assert!(matches!(design, Design::StateFeedback { .. }));
    }
    for (from, to, told) in [
        ("\"measured\"", "\"told\"", "age `told` is unknown"),
        (
            "[plant]",
            "[plant]\ndead_time = \"9ms\"",
            "the plant has a dead time",
        ),
        (
            "\"backward-euler\"",
            "\"zero-order-hold\"\ndead_time = \"9ms\"",
            "the plant has a dead time",
        ),
    ] {
        let fault = System::read(&kalman.replace(from, to)).expect_err(to);
        assert!(fault.to_string().contains(told), "{fault}");
    }
    let pid = System::built_in("lag").expect("built in");
    let fault = System::read(&format!("{pid}\nage = \"measured\"\n")).expect_err("a PID");
    let told = "`age` is not a key of law `pid`";
    assert!(fault.to_string().contains(told), "{fault}");
}

#[test]
fn gains_can_be_replaced_where_there_are_some() {
    let louder = System::paper()
        .with_gains(Some(0.3), None)
        .expect("a PI has a kp");
    let Design::Pid(numbers) = louder.at(h("3ms")).expect("sampled").design else {
        panic!("a PI is a PID");
    };
    assert_eq!((numbers.kp, numbers.ki), (0.3, preset::PAPER_A1));
    assert!(built_in("pendulum").with_gains(Some(1.0), None).is_none());
    assert!(built_in("pendulum").with_gains(None, None).is_some());
}

#[test]
fn the_schema_beside_them_is_the_types_and_each_names_it() {
    let schema = include_str!("../../../../../services/systems/system.schema.json");
    assert_eq!(
        plan::system::schema(),
        schema,
        "write `webloop system schema` there"
    );
    for name in System::built_in_names() {
        let text = System::built_in(name).expect("built in");
        assert!(
            text.starts_with("#:schema ./system.schema.json\n"),
            "{name}"
        );
    }
}

/// The lag's law with a plant of these lines.
fn with_plant(plant: &str) -> String {
    format!("name = \"own\"\n[plant]\n{plant}\n[controller]\nlaw = \"pid\"\nkp = 1.0\n")
}

#[test]
fn a_plant_that_is_a_program_has_a_law_and_no_model() {
    let system = System::read(&with_plant("run = [\"python3\", \"./tank.py\"]")).expect("a system");
    let run = ["python3".to_owned(), "./tank.py".to_owned()];
    assert_eq!(
        system.plant_program(),
        Some(&plan::system::Program::new(run.to_vec()))
    );
    assert!(system.plant().linear().is_none() && !system.is_unstable());
    assert!(system.law_at(h("3ms")).is_ok());
    let unfit = system.at(h("3ms")).expect_err("no model").to_string();
    assert!(unfit.contains("its plant is a program"), "{unfit}");
    // A law with a model in it needs one.
    let smith = with_plant("run = [\"tank\"]").replace("\"pid\"", "\"smith\"");
    let unfit = System::read(&smith).expect("a system").law_at(h("3ms"));
    let unfit = unfit.expect_err("no model").to_string();
    assert!(unfit.contains("law `smith` needs"), "{unfit}");
    for (plant, problem) in [
        ("run = []", "nothing to `run`"),
        ("run = [\"\"]", "nothing to `run`"),
        ("run = [\"tank\"]\nnum = [1.0]", "has `num` too"),
        (
            "run = [\"tank\"]\ndead_time = \"5ms\"",
            "has `dead_time` too",
        ),
    ] {
        let fault = System::read(&with_plant(plant)).expect_err(plant);
        assert!(fault.problem.contains(problem), "{plant}: {fault}");
    }
}

#[test]
fn what_surrounds_a_plant_is_read_with_its_place() {
    const LAG: &str = "num = [1.0]\nden = [0.2, 1.0]\n";
    let bare = System::read(&with_plant(LAG)).expect("a system");
    assert_eq!(bare.surroundings(), None);
    let around = "[plant.actuator]\nmax = 2.0\nrate = 5.0\n[plant.disturbance]\nsize = -0.5\nfrom = \"2s\"\n\
                  [plant.sensor]\nnoise = 0.1\n";
    let system = System::read(&with_plant(&format!("{LAG}{around}"))).expect("a system");
    let told = system.surroundings().expect("they are there");
    assert_eq!(
        (told.limits, told.rate_per_s),
        ((f64::NEG_INFINITY, 2.0), 5.0)
    );
    let disturbance = told.disturbance.expect("it is there");
    assert_eq!(
        (disturbance.size, disturbance.from_ns),
        (-0.5, 2_000_000_000)
    );
    assert_eq!((told.noise, told.resolution), (0.1, 0.0));
    for (around, problem) in [
        ("[plant.actuator]\nmin = 1.0\nmax = 1.0", "are empty"),
        ("[plant.actuator]\nrate = 0.0", "rate is 0"),
        ("[plant.sensor]\nnoise = -1.0", "noise is -1"),
        ("[plant.sensor]\nresolution = 0.0", "resolution is 0"),
        ("[plant.disturbance]\nsize = inf", "size is inf"),
        (
            "[plant.disturbance]\nsize = 1.0\nfrom = \"soon\"",
            "`soon` is not a number with a unit",
        ),
    ] {
        let fault = System::read(&with_plant(&format!("{LAG}{around}"))).expect_err(around);
        assert!(fault.problem.contains(problem), "{around}: {fault}");
        assert!(fault.line > 4, "{around}: {fault}");
    }
}

#[test]
fn a_reference_that_moves_is_read_with_its_place() {
    let with_reference = |text: &str| {
        let plant = with_plant("num = [1.0]\nden = [0.2, 1.0]\n");
        System::read(&format!("{plant}[reference]\n{text}"))
    };
    let square = with_reference("shape = \"square\"\nhigh = 1.0\nperiod = \"4s\"");
    assert_eq!(
        square.expect("a system").reference(),
        Some(&Shape::Square {
            low: 0.0,
            high: 1.0,
            period_ns: 4_000_000_000
        })
    );
    let points = with_reference("shape = \"points\"\nt_s = [0, 0.25, 2]\nr = [1, -1, 0.5]");
    let points = points.expect("a system");
    let over = points.reference().expect("it moves").over(h("10ms"), 9);
    assert_eq!(
        over.expect("few changes").changes(),
        [(0, 1.0), (250_000_000, -1.0), (2_000_000_000, 0.5)]
    );
    for (text, problem) in [
        ("shape = \"saw\"", "shape is `saw`"),
        ("shape = \"step\"\nto = 1.0", "needs `at`"),
        ("shape = \"step\"\nat = \"1s\"", "needs `to`"),
        ("shape = \"step\"\nto = inf\nat = \"1s\"", "to is inf"),
        (
            "shape = \"sine\"\nhigh = 1.0\nperiod = \"0s\"",
            "period is 0",
        ),
        ("shape = \"sine\"\nhigh = 1.0\nt_s = [0]", "has no `t_s`"),
        (
            "shape = \"points\"\nt_s = [0, 1]\nr = [1]",
            "2 times in `t_s` and 1 values",
        ),
        ("shape = \"points\"\nt_s = [1]\nr = [1]", "not at 0"),
        (
            "shape = \"points\"\nt_s = [0, -1]\nr = [1, 1]",
            "t_s has -1",
        ),
        (
            "shape = \"points\"\nt_s = [0, 2, 2]\nr = [1, 1, 1]",
            "not after the one before it",
        ),
        (
            "shape = \"points\"\nt_s = [0]\nr = [nan]",
            "r at 0 ns is NaN",
        ),
    ] {
        let fault = with_reference(text).expect_err(text);
        assert!(fault.problem.contains(problem), "{text}: {fault}");
        assert!(fault.line > 4, "{text}: {fault}");
    }
    let both = with_plant("num = [1.0]\nden = [0.2, 1.0]\n").replacen("name", "r = 1.0\nname", 1);
    let both = format!("{both}[reference]\nshape = \"step\"\nto = 1.0\nat = \"1s\"");
    assert!(
        System::read(&both)
            .expect_err("both")
            .problem
            .contains("both `r` and")
    );
}

#[test]
fn a_plant_by_matrices_may_start_anywhere() {
    const FALLING: &str = "a = [[0.0, 1.0], [9.81, 0.0]]\nb = [0.0, 1.0]\nc = [2.0, 0.5]\n";
    let read = |plant: &str, x0: &str| System::read(&with_plant(&format!("{plant}{x0}\n")));
    let system = read(FALLING, "x0 = [0.1, -0.2]").expect("a system");
    assert_eq!((system.x0(), system.y0()), (&[0.1, -0.2][..], 0.1));
    assert!(system.surroundings().expect("it stands still").stands_still);
    // Without a command it falls as the equation says: the eigenvalues are plus and minus sqrt(9.81).
    let sampled = system.at(h("10ms")).expect("sampled").plant;
    let mut stepper = sampled.stepper_from(system.x0());
    assert_eq!(stepper.output(), system.y0());
    let y = (0..=100).map(|_| stepper.step(0.0)).last().expect("steps");
    let rate = 9.81f64.sqrt();
    let angle = 0.1 * rate.cosh() - 0.2 / rate * rate.sinh();
    let speed = 0.1 * rate * rate.sinh() - 0.2 * rate.cosh();
    assert!((y - (2.0 * angle + 0.5 * speed)).abs() < 1e-9, "{y}");
    for (plant, x0, problem) in [
        (FALLING, "x0 = [0.1]", "has 2 states"),
        (FALLING, "x0 = [0.1, nan]", "has 2 states"),
        (FALLING, "dead_time = \"1ms\"\nx0 = [0.1, 0.0]", "not known"),
        (
            FALLING,
            "sampling = \"tustin\"\nx0 = [0.1, 0.0]",
            "not known",
        ),
        ("num = [1.0]\nden = [0.2, 1.0]\n", "x0 = [0.1]", "not known"),
        ("run = [\"mine\"]\n", "x0 = [0.1]", "has `x0` too"),
    ] {
        let fault = read(plant, x0).expect_err(x0);
        assert!(fault.problem.contains(problem), "{x0}: {fault}");
    }
}

#[test]
fn matrices_may_have_two_inputs_and_outputs_under_state_feedback_alone() {
    const TANKS: &str = "name = \"tanks\"\nr = [1.0, -0.25]\n[plant]\na = [[-0.8, 0.3], [0.3, -0.5]]\n\
        b = [[1.0, 0.0], [0.0, 2.0]]\nc = [[1.0, 0.0], [0.0, 1.0]]\nd = [[0.0, 0.0], [0.0, 0.0]]\n[controller]\n\
        law = \"state-feedback\"\nweights = { output = [10.0, 5.0], input = [0.1, 0.2] }\n\
        noise = { disturbance = [0.5, 0.4], measurement = [0.01, 0.02] }\n";
    let tanks = System::read(TANKS).expect("a system");
    assert_eq!((tanks.inputs(), tanks.is_single()), (2, false));
    assert_eq!((tanks.r(), tanks.other_r()), (1.0, &[-0.25][..]));
    assert_eq!(tanks.at(h("20ms")).expect("designed").law.signals(), (2, 2));
    let by_gains = "gains = [[1.0, 0.0], [0.0, 1.0]]";
    let by_gains = TANKS.replace(
        "weights = { output = [10.0, 5.0], input = [0.1, 0.2] }",
        by_gains,
    );
    assert!(
        System::read(&by_gains)
            .expect("a system")
            .at(h("20ms"))
            .is_ok()
    );
    let cases = [
        (
            "[1.0, -0.25]",
            "[1.0, 2.0, 3.0]",
            "2:5: r has 3 numbers, and the plant two outputs",
        ),
        ("[1.0, -0.25]", "nan", "2:5: r is NaN"),
        (
            "b = [[1.0, 0.0], ",
            "b = [[1.0], ",
            "5:5: a row of b has 2 numbers; it needs 1",
        ),
        (
            "b = [[1.0, 0.0], ",
            "b = [",
            "5:5: b has 1 rows; it needs 2",
        ),
        (
            "c = [[1.0, 0.0], ",
            "c = [[1.0, 0.0], [0.0, 1.0], ",
            "7:5: d has 2 rows; it needs 3",
        ),
        (
            "d = [[0.0, 0.0], [0.0, 0.0]]",
            "d = [[0.0, 0.0]]",
            "7:5: d has 1 rows; it needs 2",
        ),
        (
            "d = [[0.0, 0.0], [0.0, 0.0]]",
            "inputs = 2",
            "7:10: `inputs` is only for a plant that is a program",
        ),
        (
            "law = \"state-feedback\"",
            "law = \"pid\"",
            "9:7: `weights` is not a key of law `pid`",
        ),
        ("[10.0, 5.0]", "[10.0, 0.0]", "10:22: weights.output is 0"),
    ];
    for (old, new, expected) in cases {
        let fault = told(&System::read(&TANKS.replacen(old, new, 1)).expect_err(expected));
        assert!(
            fault.starts_with(expected),
            "{expected}\nis told as\n{fault}"
        );
    }
    // What only the law finds out.
    for (old, new, expected) in [
        (
            "[10.0, 5.0]",
            "10.0",
            "weights.output has 1 numbers; it needs 2, one for each output",
        ),
        (
            "[0.1, 0.2]",
            "0.1",
            "weights.input has 1 numbers; it needs 2, one for each input",
        ),
    ] {
        let unfit = System::read(&TANKS.replacen(old, new, 1))
            .expect("a system")
            .at(h("20ms"));
        let unfit = unfit.expect_err(expected).to_string();
        assert!(unfit.contains(expected), "{unfit}");
    }
    let pid = System::built_in("cart")
        .expect("built in")
        .split("[controller]")
        .next();
    let pid = format!(
        "{}[controller]\nlaw = \"pid\"\nkp = 1.0\n",
        pid.expect("the plant")
    );
    let fault = System::read(&pid).expect_err("one output").to_string();
    assert!(
        fault.contains(
            "law `pid` has one input and one output, and the plant has one input and 2 outputs"
        ),
        "{fault}"
    );
    // A program says how many inputs it has; its law gives one command.
    let program = System::read(&with_plant("run = [\"tank\"]\ninputs = 2")).expect("a system");
    assert_eq!((program.inputs(), program.gives_each_input()), (2, false));
    let three = System::read(&with_plant("run = [\"tank\"]\ninputs = 3")).expect_err("three");
    assert!(three.problem.contains("has 3 inputs"), "{three}");
}
