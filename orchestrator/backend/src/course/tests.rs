//! How a run ends when its parts end, fail or hang, at a made-up site: no process, no network, and a
//! clock that advances only when something waits.

use std::net::Ipv4Addr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use link::Epoch;
use link::certificate::Echo;
use plan::{Instead, Plan, ProfileText};
use process::Stop;
use shaper::ProbePlan;

use super::*;

const S: u64 = 1_000_000_000;
const LEAD_NS: u64 = S;
/// Link time 0 of the run, its first deadline, and the end of its deadlines.
const EPOCH: Epoch = Epoch::at_ns(2 * LEAD_NS - Spacing::Close.opens().ns());
const START_NS: u64 = EPOCH.t_ns(plan::START_AT);
const END_NS: u64 = START_NS + 2 * S;

/// When a part ends, and whether it fails.
#[derive(Debug, Clone, Copy)]
enum Ends {
    WhenStopped,
    At(u64),
    FailsAt(u64),
}

struct MadeUp {
    clock_ns: AtomicU64,
    stop: AtomicBool,
    /// When the run is interrupted.
    interrupted_ns: u64,
    /// How long the first series of echoes takes.
    empty_ns: u64,
    plant: Ends,
    controller: Ends,
    faults: Vec<EndFault>,
    /// Whether parts stand still when they are asked to.
    obeys: bool,
    log: Mutex<Vec<String>>,
}

impl MadeUp {
    /// A site where everything goes well.
    fn new() -> MadeUp {
        MadeUp {
            clock_ns: AtomicU64::new(LEAD_NS),
            stop: AtomicBool::new(false),
            interrupted_ns: u64::MAX,
            empty_ns: S / 10,
            plant: Ends::WhenStopped,
            controller: Ends::At(END_NS + S / 10),
            faults: Vec::new(),
            obeys: true,
            log: Mutex::default(),
        }
    }

    fn run(&self) -> Result<Seen, RunError> {
        let source = "name = \"made-up\"\n[[cells]]\ntopology = \"buccoo\"\nclient = \"native\"\n\
                      mode = \"closed\"\nh = \"10ms\"\nduration = \"2s\"\n";
        let library = |name: &str| {
            let source = Profile::builtin(name).ok_or("not built in")?.to_owned();
            Ok::<_, String>(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        let plan = Plan::resolve(source, "test", &Instead::default(), library).expect("a plan");
        let text = &plan.profiles["buccoo"];
        let profile = text.profile("buccoo").expect("a profile");
        let texts = Texts {
            profile: text,
            system: None,
            program: None,
            plant_program: None,
            end_faults: &self.faults,
        };
        run(self, &plan.cells[0], &profile, texts, 1, &self.stop)
    }

    fn note(&self, what: String) {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.push(what);
    }

    fn log(&self) -> Vec<String> {
        let log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.clone()
    }
}

impl Site for MadeUp {
    fn lead_ns(&self, _: Duration) -> u64 {
        LEAD_NS
    }

    fn now_ns(&self) -> u64 {
        self.clock_ns.load(Ordering::Relaxed)
    }

    fn sleep(&self, duration: Duration) {
        let ns = duration.as_nanos() as u64;
        let now = self.clock_ns.fetch_add(ns, Ordering::Relaxed) + ns;
        if now >= self.interrupted_ns {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn start<'a>(&'a self, settings: RoleSettings) -> Result<Box<dyn Running + 'a>, RunError> {
        let role = settings.role();
        let is_again = matches!(&settings, RoleSettings::Plant(role) if role.again);
        let again = if is_again { " again" } else { "" };
        self.note(format!("{role} starts{again}"));
        let ends = match settings {
            RoleSettings::Plant(_) => self.plant,
            RoleSettings::Controller(_) => self.controller,
            RoleSettings::Link(_) => Ends::WhenStopped,
        };
        Ok(Box::new(MadeUpPart {
            site: self,
            role,
            ends,
            stops: Vec::new(),
        }))
    }

    fn plant_address(&self) -> Ipv4Addr {
        Ipv4Addr::LOCALHOST
    }

    fn echoes(&self, plan: &ProbePlan, _: &AtomicBool) -> Result<Vec<Echo>, RunError> {
        if plan.id == Phase::Empty as u16 {
            self.clock_ns.fetch_add(self.empty_ns, Ordering::Relaxed);
        }
        Ok(Vec::new())
    }
}

struct MadeUpPart<'a> {
    site: &'a MadeUp,
    role: &'static str,
    ends: Ends,
    stops: Vec<Stop>,
}

impl Running for MadeUpPart<'_> {
    fn ended(&mut self) -> Result<bool, RunError> {
        let now = self.site.now_ns();
        match self.ends {
            Ends::At(t_ns) if now >= t_ns => Ok(true),
            Ends::FailsAt(t_ns) if now >= t_ns => Err(RunError::role(self.role, "was killed")),
            _ => Ok(false),
        }
    }

    fn seen(&self) -> Result<process::Seen, RunError> {
        Ok(process::Seen {
            frozen_ns: self.stops.clone(),
            ..process::Seen::default()
        })
    }

    fn freeze(&mut self, stops: Vec<Stop>) -> Result<(), RunError> {
        self.site.note(format!("{} is to stand still", self.role));
        if self.site.obeys {
            self.stops = stops;
        }
        Ok(())
    }

    fn kill(self: Box<Self>) -> Result<process::Seen, RunError> {
        self.site.note(format!("{} is killed", self.role));
        self.seen()
    }

    fn is_beneath(&self) -> bool {
        true
    }

    fn terminate(&mut self) {
        self.site.note(format!("{} is told to end", self.role));
    }

    fn stop(self: Box<Self>) -> Result<(), RunError> {
        self.site.note(format!("{} is stopped", self.role));
        Ok(())
    }
}

impl Drop for MadeUpPart<'_> {
    fn drop(&mut self) {
        self.site.note(format!("{} is gone", self.role));
    }
}

/// The error of a run that fails. Checks that none of its parts is left.
fn failure(site: &MadeUp) -> String {
    let error = site.run().expect_err("it cannot end well");
    let log = site.log();
    for role in ["link", "plant", "controller"] {
        let gone = format!("{role} is gone");
        assert!(log.contains(&gone), "{gone}? {log:?}");
    }
    error.to_string()
}

#[test]
fn a_run_that_goes_well_starts_its_parts_from_the_link_on_and_stops_them_to_it() {
    let site = MadeUp::new();
    let seen = site.run().expect("it goes well");
    assert_eq!((seen.epoch, seen.start_ns), (EPOCH, START_NS));
    let steps: Vec<String> = site.log();
    let steps: Vec<&str> = steps.iter().map(String::as_str).collect();
    assert_eq!(
        steps,
        [
            "link starts",
            "plant starts",
            "controller starts",
            "controller is stopped",
            "controller is gone",
            "plant is stopped",
            "plant is gone",
            "link is stopped",
            "link is gone",
        ]
    );
}

#[test]
fn a_controller_that_hangs_is_given_up_after_its_time_out_and_grace() {
    let site = MadeUp {
        controller: Ends::WhenStopped,
        ..MadeUp::new()
    };
    let said = failure(&site);
    assert_eq!(
        said,
        "the controller did not end after its duration and time-out"
    );
    let late_ns = site.now_ns() - END_NS;
    assert!((15 * S..16 * S).contains(&late_ns), "{late_ns}");
}

#[test]
fn a_part_that_is_killed_ends_the_run_at_once() {
    for (plant, controller, said) in [
        (
            Ends::FailsAt(START_NS + S),
            Ends::WhenStopped,
            "the plant was killed",
        ),
        (
            Ends::At(START_NS + S),
            Ends::WhenStopped,
            "the plant or the link ended before the controller",
        ),
        (
            Ends::WhenStopped,
            Ends::FailsAt(START_NS + S),
            "the controller was killed",
        ),
    ] {
        let site = MadeUp {
            plant,
            controller,
            ..MadeUp::new()
        };
        assert_eq!(failure(&site), said);
        assert!(site.now_ns() < START_NS + S + S / 10, "{said}");
    }
}

#[test]
fn a_machine_that_is_late_for_the_empty_link_has_no_run() {
    let site = MadeUp {
        empty_ns: 2 * S,
        ..MadeUp::new()
    };
    let said = failure(&site);
    assert!(said.contains("too busy to start the parts"), "{said}");
}

#[test]
fn a_run_that_is_interrupted_tells_its_controller_to_end() {
    let site = MadeUp {
        interrupted_ns: START_NS + S,
        ..MadeUp::new()
    };
    assert_eq!(failure(&site), "interrupted");
    let told = "controller is told to end".to_owned();
    assert!(site.log().contains(&told), "{:?}", site.log());
    assert!(site.now_ns() < START_NS + S + S / 10);
}

fn hits_plant(effect: EndEffect, from_ns: u64, to_ns: u64) -> EndFault {
    EndFault {
        end: End::Plant,
        effect,
        from_ns,
        to_ns,
    }
}

#[test]
fn a_fault_kills_an_end_and_starts_it_again_and_the_run_goes_on() {
    let site = MadeUp {
        faults: vec![
            hits_plant(EndEffect::Freeze, S / 4, S / 3),
            hits_plant(EndEffect::Kill, S / 2, S),
        ],
        ..MadeUp::new()
    };
    let seen = site.run().expect("it goes well");
    let log = site.log();
    let of_plant = log.iter().filter(|line| line.starts_with("plant"));
    let of_plant: Vec<&str> = of_plant.map(String::as_str).collect();
    assert_eq!(
        of_plant,
        [
            "plant starts",
            "plant is to stand still",
            "plant is killed",
            "plant is gone",
            "plant starts again",
            "plant is stopped",
            "plant is gone",
        ]
    );
    let done = seen.end_faults.iter();
    let done: Vec<[u64; 2]> = done
        .map(|one| [one.from_ns, one.to_ns].map(|t_ns| t_ns - START_NS))
        .collect();
    assert_eq!(done, [[S / 4, S / 3], [S / 2, S]]);
}

#[test]
fn a_fault_that_was_not_done_fails_the_run() {
    let site = MadeUp {
        faults: vec![hits_plant(EndEffect::Freeze, S / 4, S / 2)],
        obeys: false,
        ..MadeUp::new()
    };
    assert_eq!(
        failure(&site),
        "the plant was to be hit by a fault at 0.25 s, which was not done"
    );
}
