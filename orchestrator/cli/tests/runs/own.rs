//! Controllers of one's own: the examples hold the loop, and each that breaks the contract fails by name,
//! leaves nothing behind, and does not harm the next.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use plan::Verdict;

use crate::process::{gone, namespaces_of, of_run};
use crate::webloop::{code, command, run_together, run_undisturbed, said};

/// The checkout, whose examples are run.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Nothing of a controller may be left after this.
const GONE_WITHIN: Duration = Duration::from_secs(5);

/// What all the bad controllers begin with: the paper's PI, until `break`.
const GOOD: &str = r#"
import http.client, os, signal, socket, sys, threading, time, urllib.parse
host = os.environ["WEBLOOP_PLANT"].split("//")[1]
h = float(os.environ["WEBLOOP_H_S"])
r = float(os.environ["WEBLOOP_R"])
start = int(os.environ["WEBLOOP_START_NS"]) / 1e9
count = round(float(os.environ["WEBLOOP_DURATION_S"]) / h)
plant = http.client.HTTPConnection(host, timeout=5)

def wait(k):
    time.sleep(max(0.0, start + k * h - time.monotonic()))

def closed(u):
    plant.request("GET", f"/closed?u={u}")
    return plant.getresponse().read().decode()

def loop(count):
    y = integral = 0.0
    for k in range(count):
        wait(k)
        integral += 0.378 * h * (r - y)
        y = float(urllib.parse.parse_qs(closed(0.1701 * (r - y) + integral))["y"][0])
"#;

/// Whether this machine has a program.
fn has(program: &str) -> bool {
    let asked = std::process::Command::new(program)
        .arg("--version")
        .output();
    asked.is_ok_and(|output| output.status.success())
}

/// Bad controllers: name, program after [`GOOD`], and what is said of them.
const BAD: [(&str, &str, &str); 10] = [
    ("dies", "loop(count // 4); sys.exit(3)", "exit code 3"),
    (
        "crashes",
        "loop(10); os.kill(os.getpid(), signal.SIGSEGV)",
        "signal 11",
    ),
    ("leaves", "loop(count // 4)", "before its time"),
    ("silent", "time.sleep(60)", "sent no message"),
    (
        "floods",
        "wait(0)\nwhile time.monotonic() < start + count * h: closed(0.1)",
        "flooded the plant",
    ),
    (
        "nonsense",
        "wait(0)\nfor k in range(count): closed('fast'); wait(k)",
        "refused",
    ),
    (
        "hurries",
        "closed(0.1); plant.close(); loop(count)",
        "early",
    ),
    (
        "deaf",
        "address, port = host.split(':')\ns = socket.create_connection((address, int(port)))\n\
         s.setblocking(False)\nwait(0)\n\
         while time.monotonic() < start + count * h - 0.02:\n \
         try: s.send((f'GET /closed?u=0.1 HTTP/1.1\\r\\nhost: {host}\\r\\n\\r\\n' * 2).encode())\n \
         except BlockingIOError: pass\n \
         time.sleep(h)",
        "unread",
    ),
    (
        "stays",
        "signal.signal(signal.SIGTERM, signal.SIG_IGN); loop(count); time.sleep(60)",
        "killed",
    ),
    (
        "forks",
        "for _ in range(40):\n if os.fork() == 0:\n  os.setsid(); signal.signal(signal.SIGTERM, signal.SIG_IGN); \
         time.sleep(300)\nloop(count // 4); sys.exit(4)",
        "exit code 4",
    ),
];

/// An experiment of own controllers, each a name with its command, in a folder of its own.
fn experiment(
    folder: &Path,
    topologies: &[&str],
    programs: &[(&str, Vec<String>)],
    duration: &str,
) -> PathBuf {
    let clients = programs
        .iter()
        .map(|(name, run)| format!("{{ name = \"{name}\", run = {run:?} }}"));
    let clients: Vec<String> = clients.collect();
    let text = format!(
        "name = \"own\"\n[[cells]]\ntopology = {topologies:?}\nclient = [{}]\nmode = \"closed\"\n\
         h = \"10ms\"\nduration = \"{duration}\"\n",
        clients.join(", ")
    );
    let file = folder.join("own.toml");
    fs::write(&file, text).unwrap();
    file
}

pub(crate) fn a_controller_that_breaks_the_contract_fails_by_name_and_leaves_nothing()
-> Result<(), String> {
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let program = |(name, text, _): &(&'static str, &str, &str)| {
        let file = folder.path().join(format!("{name}.py"));
        fs::write(&file, format!("{GOOD}\n{text}\n")).unwrap();
        (
            *name,
            vec!["python3".to_owned(), file.display().to_string()],
        )
    };
    let mut programs: Vec<(&str, Vec<String>)> = BAD.iter().map(program).collect();
    programs.push(("missing", vec!["./there-is-no-such-program".to_owned()]));
    let file = experiment(folder.path(), &["arima"], &programs, "2s");
    let out = folder.path().join("bad");
    // What they do wrong is told whether or not others take the processors.
    let manifests = run_together(&file, &out, "netns", 4)?;
    gone(&out, &namespaces_of(&of_run(&out)), GONE_WITHIN);
    assert_eq!(manifests.len(), programs.len());
    for manifest in &manifests {
        let name = manifest.cell.client.to_string();
        let reasons = manifest.reasons.join("; ");
        let words = BAD.iter().find(|(bad, ..)| *bad == name);
        let words = words.map_or("cannot be started", |(.., words)| words);
        println!("  {name}: {reasons}");
        if name != "missing" {
            assert_eq!(manifest.verdict, Verdict::Failed, "{name}: {reasons}");
        }
        assert!(reasons.contains(words), "{name}: {reasons}");
    }
    // Last, when all the others have had their chance to harm it.
    let good = program(&("good", "loop(count)", ""));
    let file = experiment(folder.path(), &["arima"], &[good], "2s");
    for manifest in run_undisturbed(&file, &folder.path().join("good"), "netns")? {
        let reasons = manifest.reasons.join("; ");
        assert_eq!(manifest.verdict, Verdict::Complete, "{reasons}");
    }
    Ok(())
}

/// `webloop conform` of a program.
fn conform(run: &[String]) -> Output {
    command()
        .args(["conform", "--"])
        .args(run)
        .output()
        .unwrap()
}

pub(crate) fn the_examples_hold_the_loop_and_keep_the_contract() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let mut programs = Vec::new();
    let mut missing = Vec::new();
    for (name, interpreter, file) in [
        ("mine", &["python3"][..], "examples/python/pi.py"),
        ("plain", &["python3"], "examples/plain/pi.py"),
        ("node", &["node"], "examples/node/pi.mjs"),
        (
            "octave",
            &["octave-cli", "--quiet", "--no-init-file"],
            "examples/octave/pi.m",
        ),
    ] {
        if has(interpreter[0]) {
            let words = interpreter.iter().map(|word| (*word).to_owned());
            programs.push((name, words.chain([format!("{ROOT}/{file}")]).collect()));
        } else {
            missing.push(interpreter[0]);
        }
    }
    if has("python3") {
        let [adapter, node] =
            ["adapter", "node"].map(|file| format!("{ROOT}/examples/ros/{file}.py"));
        let python = || "python3".to_owned();
        programs.push(("ros", vec![python(), adapter, python(), node]));
    }
    for (name, compiler, arguments, source) in [
        (
            "cpp",
            "c++",
            vec!["-O2", "-std=c++17"],
            "examples/cpp/pi.cpp",
        ),
        (
            "rust",
            "rustc",
            vec!["-O", "--edition=2021"],
            "examples/rust/src/main.rs",
        ),
    ] {
        if !has(compiler) {
            missing.push(compiler);
            continue;
        }
        let program = folder.path().join(name);
        let mut compile = std::process::Command::new(compiler);
        compile.args(arguments).arg("-o").arg(&program);
        let output = compile.arg(format!("{ROOT}/{source}")).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        programs.push((name, vec![program.display().to_string()]));
    }
    if !missing.is_empty() {
        println!(
            "  not tried, since they are not here: {}",
            missing.join(", ")
        );
    }
    // Over the VPN, with one request at a time, the loop settles in 2 s.
    let file = experiment(folder.path(), &["couva", "diego-vpn"], &programs, "4s");
    let out = folder.path().join("out");
    for manifest in run_together(&file, &out, "netns", 2)? {
        let cell = &manifest.cell;
        let at = format!(
            "{} over {}: {:?}",
            cell.client, cell.topology, manifest.reasons
        );
        assert_eq!(manifest.verdict, Verdict::Complete, "{at}");
    }
    let table = command().arg("show").arg(&out).output().unwrap();
    assert_eq!(
        said(&table).matches("holds").count(),
        2 * programs.len(),
        "{}",
        said(&table)
    );
    for (name, run) in &programs {
        let output = conform(run);
        println!(
            "  {name}: {}",
            said(&output).lines().last().unwrap_or_default()
        );
        assert_eq!(code(&output), Some(0), "{name}: {}", said(&output));
    }
    Ok(())
}

/// What breaks the contract in the plain PI: one of its lines, what it becomes, and what is said of it.
const PLANTED: [(&str, &str, &str); 10] = [
    (
        "start = int(",
        "h = 0.02\nstart = int(",
        "messages came and",
    ),
    (
        "/closed?u=",
        "/closed?t_send_ns=\" + str(time.time_ns()) + \"&u=",
        "before its t_send_ns",
    ),
    (
        "plant.request(\"GET\", path)",
        "plant.request(\"GET\", path, \"u\")",
        "has a body",
    ),
    (
        "    return float(rest",
        "    plant.close()\n    return float(rest",
        "keep a connection",
    ),
    (
        "/closed?u=\" + repr(",
        "/closed?u=\" + (\"nan\" if k == 50 else \"\") + repr(",
        "refused by any plant",
    ),
    (
        "/closed?u=",
        "/closed?seq=5&u=",
        "the first message has seq 5",
    ),
    (
        "    k += passed",
        "    y = get(\"/closed?u=0\", y)\n    k += passed",
        "none again for what is past",
    ),
    (
        "k * h >= duration",
        "k * h >= duration / 2",
        "before its time",
    ),
    ("        break", "        time.sleep(60)", "still ran"),
    ("plant.close()  #", "raise  #", "exit code 1"),
];

pub(crate) fn conformance_names_each_planted_fault() -> Result<(), String> {
    if !has("python3") {
        return Err("python3 is not here".into());
    }
    let folder = tempfile::tempdir().unwrap();
    let good = fs::read_to_string(Path::new(ROOT).join("examples/plain/pi.py")).unwrap();
    let named = &|n: usize| {
        let (line, becomes, words) = PLANTED[n];
        assert_eq!(good.matches(line).count(), 1, "{line}");
        let program = folder.path().join(format!("{n}.py"));
        fs::write(&program, good.replace(line, becomes)).unwrap();
        let output = conform(&["python3".to_owned(), program.display().to_string()]);
        assert_eq!(code(&output), Some(1), "{line}: {}", said(&output));
        assert!(said(&output).contains(words), "{line}: {}", said(&output));
    };
    // Their trials mostly wait.
    for first in (0..PLANTED.len()).step_by(2) {
        std::thread::scope(|scope| {
            for n in first..PLANTED.len().min(first + 2) {
                scope.spawn(move || named(n));
            }
        });
    }
    Ok(())
}
