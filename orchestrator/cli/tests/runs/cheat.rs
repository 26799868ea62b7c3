//! Programs of one's own that cheat: a controller and a plant that look for the rows of their run, for other processes
//! and for an engine's socket, before and after the loop, and write over whatever they reach. They reach nothing, and
//! the rows are whole. One that says that it does not support what it is told makes the run `unsupported`.

use std::fs;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::Output;

use plan::Verdict;

use crate::webloop::{cells_of, code, command, manifest, said};

/// Prints what is reached; arguments: the results folder and an engine's socket.
const SPY: &str = r#"
import ctypes, glob, os, socket, sys
out, engine = sys.argv[1:3]
libc = ctypes.CDLL(None, use_errno=True)

def rows(ways):
    return [path for way in ways for path in glob.glob(way + out + "/cells/*/*.csv")]

def spy():
    reached = rows(["", "/proc/[0-9]*/root", "/proc/[0-9]*/cwd", "/proc/self/cwd/../.."])
    for path in reached:
        open(path, "w").write("k,t_due_ns,t_tick_ns,u,y,seq\n")
    for pid in filter(str.isdigit, os.listdir("/proc")):
        said = open(f"/proc/{pid}/cmdline").read().split("\0")
        if any(word in said for word in ["run-cell", "plant", "controller", "link"]):
            reached.append("process " + " ".join(said))
    for fd in os.listdir("/proc/self/fd"):
        path = f"/proc/self/fd/{fd}"
        if os.path.exists(path) and (os.path.isdir(path) and os.readlink(path) != "/proc" or ".csv" in os.readlink(path)):
            if not os.readlink(path).startswith("/proc/"):
                reached.append("descriptor of " + os.readlink(path))
    try:
        door = socket.socket(socket.AF_UNIX)
        door.connect(engine)
        reached.append("the engine")
    except OSError:
        pass
    if libc.umount2((out + "/cells").encode(), 2) == 0:
        reached.append("what was covered")
    if os.fork() == 0:
        # In a user namespace of its own it has all rights, over its own mounts.
        if libc.unshare(0x10000000 | 0x00020000) == 0 and libc.umount2((out + "/cells").encode(), 2) == 0:
            sys.stderr.write(f"REACHED by a namespace {rows([''])}\n")
        os._exit(0)
    os.wait()
    for what in reached:
        sys.stderr.write(f"REACHED {what}\n")
    sys.stderr.write("SPIED\n")
    sys.stderr.flush()

spy()
"#;

/// The paper's PI, and then another look.
const CONTROLLER: &str = r#"
import http.client, time, urllib.parse
plant = http.client.HTTPConnection(os.environ["WEBLOOP_PLANT"].split("//")[1], timeout=5)
h, r = float(os.environ["WEBLOOP_H_S"]), float(os.environ["WEBLOOP_R"])
start = int(os.environ["WEBLOOP_START_NS"]) / 1e9
y = integral = 0.0
for k in range(round(float(os.environ["WEBLOOP_DURATION_S"]) / h)):
    time.sleep(max(0.0, start + k * h - time.monotonic()))
    integral += 0.378 * h * (r - y)
    plant.request("GET", f"/closed?u={0.1701 * (r - y) + integral}")
    y = float(urllib.parse.parse_qs(plant.getresponse().read().decode())["y"][0])
spy()
"#;

/// A lag, and then another look.
const PLANT: &str = r#"
h, y = float(os.environ["WEBLOOP_H_S"]), 0.0
print(y, flush=True)
for line in sys.stdin:
    y += 5 * h * (float(line) - y)
    print(y, flush=True)
spy()
"#;

pub(crate) fn a_program_of_one_s_own_reaches_no_rows_no_process_and_no_engine() -> Result<(), String>
{
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (out, engine) = (path("out"), path("engine.sock"));
    let _engine = UnixListener::bind(&engine).unwrap();
    fs::write(path("cheat.py"), format!("{SPY}{CONTROLLER}")).unwrap();
    fs::write(path("plant.py"), format!("{SPY}{PLANT}")).unwrap();
    let run = |program: &str| {
        format!(
            "run = [\"python3\", \"./{program}\", {:?}, {:?}]",
            out.display().to_string(),
            engine.display().to_string()
        )
    };
    let system = format!(
        "name = \"spy\"\n[plant]\n{}\n[controller]\nlaw = \"pid\"\nkp = 1.0\nki = 2.0\n",
        run("plant.py")
    );
    fs::write(path("spy.toml"), system).unwrap();
    let experiment = format!(
        "name = \"cheats\"\n[[cells]]\ntopology = [\"arima\"]\nclient = {{ name = \"cheat\", {} }}\n\
         system = [\"./spy.toml\"]\nmode = \"closed\"\nh = \"10ms\"\nduration = \"2s\"\n",
        run("cheat.py")
    );
    fs::write(path("cheats.toml"), experiment).unwrap();
    // Whether others take the processors meanwhile does not matter here.
    let ran = once(&path("cheats.toml"), &out);
    assert!(matches!(code(&ran), Some(0 | 1)), "{}", said(&ran));
    let cells = cells_of(&out);
    assert_eq!(cells.len(), 1, "{}", said(&ran));
    for cell in cells {
        for log in ["controller.log", "plant.log"] {
            let log = fs::read_to_string(cell.join(log)).unwrap();
            assert_eq!(log.matches("SPIED").count(), 2, "{log}");
            assert!(!log.contains("REACHED"), "{log}");
        }
        let manifest = manifest(&cell);
        assert_ne!(manifest.verdict, Verdict::Failed, "{:?}", manifest.reasons);
        assert!(
            manifest.files["ticks.csv"].bytes > 5_000,
            "{:?}",
            manifest.files
        );
    }
    let shown = command().arg("show").arg(&out).output().unwrap();
    assert!(!said(&shown).contains("not whole"), "{}", said(&shown));
    Ok(())
}

/// Runs an experiment's file, each cell once.
fn once(file: &Path, out: &Path) -> Output {
    let mut run = command();
    run.arg("run").arg(file).args(["--tries", "1", "--out"]);
    run.arg(out).output().unwrap()
}

pub(crate) fn a_program_that_ends_with_127_makes_the_run_unsupported() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("none.toml");
    let text = "name = \"none\"\n[[cells]]\ntopology = [\"arima\"]\nmode = \"open\"\nh = \"10ms\"\n\
                client = { name = \"none\", run = [\"sh\", \"-c\", \"exit 127\"] }\nduration = \"6s\"\n";
    fs::write(&file, text).unwrap();
    let out = folder.path().join("out");
    let ran = once(&file, &out);
    assert_eq!(code(&ran), Some(3), "{}", said(&ran));
    for cell in cells_of(&out) {
        let manifest = manifest(&cell);
        let reasons = manifest.reasons.join("; ");
        assert_eq!(manifest.verdict, Verdict::Unsupported, "{reasons}");
        assert!(reasons.contains("exit code 127"), "{reasons}");
    }
    Ok(())
}
