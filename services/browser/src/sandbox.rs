//! How a browser isolates its pages from the machine, as seen from outside.
//!
//! A browser may not have the isolation that was requested; the kernel reports the actual one for
//! each process.

use std::{fs, path::PathBuf};

use endpoint::report::{Confinement, Engine};
use rustix::process::Pid;

use crate::engine::runs_a_page;

/// The weakest confinement among those processes that run a page. Confinement that this process has
/// too, such as a container's, does not count.
pub(crate) fn confinement(engine: Engine, members: &[Pid]) -> Confinement {
    let ours = Hold::of("self");
    members
        .iter()
        .filter_map(|pid| {
            // Its arguments, separated by zeros or, in a name that it gave itself, by spaces.
            let line = fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
            let arguments: Vec<&str> = line
                .split(['\0', ' '])
                .filter(|word| !word.is_empty())
                .collect();
            runs_a_page(engine, &arguments).then(|| Hold::of(&pid.to_string()).beyond(&ours))
        })
        .min()
        .unwrap_or(Confinement::Unknown)
}

/// The confinement of a process as reported by the kernel.
struct Hold {
    /// Number of system call filters.
    filters: u32,
    /// Its user namespace, if this process may read it.
    namespace: Option<PathBuf>,
    /// The outside ids of that namespace's users: another way to distinguish two namespaces.
    users: Option<String>,
}

impl Hold {
    fn of(process: &str) -> Self {
        let file = |name| fs::read_to_string(format!("/proc/{process}/{name}")).ok();
        Self {
            filters: file("status").map_or(0, |status| filters(&status)),
            namespace: fs::read_link(format!("/proc/{process}/ns/user")).ok(),
            users: file("uid_map"),
        }
    }

    /// The confinement that it has beyond that of `other`.
    fn beyond(&self, other: &Self) -> Confinement {
        let apart = match (&self.namespace, &other.namespace) {
            (Some(one), Some(other)) => one != other,
            _ => self.users.is_some() && self.users != other.users,
        };
        match (self.filters > other.filters, apart) {
            (true, true) => Confinement::Namespace,
            (true, false) => Confinement::Filter,
            (false, _) => Confinement::None,
        }
    }
}

/// Number of system call filters; 0 on kernels before 5.9, which do not report it.
fn filters(status: &str) -> u32 {
    let number = |line: &str| {
        let number = line.strip_prefix("Seccomp_filters:")?;
        number.trim().parse().ok()
    };
    status.lines().find_map(number).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_counted_by_the_kernel() {
        assert_eq!(filters("Name:\ta\nSeccomp:\t2\nSeccomp_filters:\t3\n"), 3);
        assert_eq!(filters("Seccomp:\t0\nSeccomp_filters:\t0\n"), 0);
        assert_eq!(filters("Seccomp:\t2\n"), 0);
    }

    #[test]
    fn what_holds_both_is_no_sandbox() {
        let hold = |filters, namespace: Option<&str>, users: &str| Hold {
            filters,
            namespace: namespace.map(PathBuf::from),
            users: Some(users.to_owned()),
        };
        // In a container, whose own filter applies to all its processes.
        let ours = hold(1, Some("user:[1]"), "0 0 1");
        for (page, expected) in [
            (hold(1, Some("user:[1]"), "0 0 1"), Confinement::None),
            (hold(2, Some("user:[1]"), "0 0 1"), Confinement::Filter),
            (hold(2, Some("user:[2]"), "0 0 1"), Confinement::Namespace),
            (hold(2, None, "0 0 1"), Confinement::Filter),
            (hold(2, None, "65534 65534 1"), Confinement::Namespace),
        ] {
            assert_eq!(page.beyond(&ours), expected);
        }
    }

    #[test]
    fn a_process_that_runs_no_page_says_nothing_of_the_sandbox() {
        for engine in Engine::ALL {
            let this = rustix::process::getpid();
            assert_eq!(confinement(*engine, &[this]), Confinement::Unknown);
        }
    }
}
