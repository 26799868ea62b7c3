//! Finds the processes of a run and what they keep, in `/proc`, where nothing can hide.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Network namespaces by the kernel's own names, such as `net:[4026531840]`.
pub(crate) type Namespaces = BTreeSet<String>;

/// Numbers of the processes with `folder` in their command line: all roles of a run into it.
///
/// A process that has ended but has not been waited for has no command line any more.
pub(crate) fn of_run(folder: &Path) -> Vec<u32> {
    let folder = folder.display().to_string();
    numbers()
        .filter(|number| *number != std::process::id())
        .filter(|number| {
            fs::read(format!("/proc/{number}/cmdline"))
                .is_ok_and(|line| String::from_utf8_lossy(&line).contains(&folder))
        })
        .collect()
}

/// The network namespaces that these processes are in, or keep by a descriptor, except our own.
pub(crate) fn namespaces_of(processes: &[u32]) -> Namespaces {
    let own = kept_by(std::process::id());
    processes
        .iter()
        .flat_map(|number| kept_by(*number))
        .filter(|namespace| !own.contains(namespace))
        .collect()
}

/// Those of `namespaces` that any process of this machine is still in, or keeps.
pub(crate) fn still_there(namespaces: &Namespaces) -> Namespaces {
    numbers()
        .flat_map(kept_by)
        .filter(|namespace| namespaces.contains(namespace))
        .collect()
}

/// Waits until nothing of the run into `folder` is left. Returns how long that took.
pub(crate) fn gone(folder: &Path, namespaces: &Namespaces, within: Duration) -> Duration {
    let started = Instant::now();
    loop {
        let (processes, kept) = (of_run(folder), still_there(namespaces));
        if processes.is_empty() && kept.is_empty() {
            return started.elapsed();
        }
        assert!(
            started.elapsed() < within,
            "after {within:?} there still are the processes {processes:?} and the namespaces {kept:?}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn numbers() -> impl Iterator<Item = u32> {
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// The namespaces of its threads and descriptors, as far as they can be read.
fn kept_by(process: u32) -> Namespaces {
    let links = |folder: String, under: &'static str| {
        fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(move |entry| fs::read_link(entry.path().join(under)).ok())
            .filter_map(|target| target.to_str().map(str::to_owned))
            .filter(|target| target.starts_with("net:["))
    };
    let descriptors = fs::read_dir(format!("/proc/{process}/fd"))
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| fs::read_link(entry.path()).ok())
        .filter_map(|target| target.to_str().map(str::to_owned))
        .filter(|target| target.starts_with("net:["));
    links(format!("/proc/{process}/task"), "ns/net")
        .chain(descriptors)
        .collect()
}
