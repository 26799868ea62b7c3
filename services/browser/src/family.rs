//! The processes that a program started, and those that these started in turn.
//!
//! A browser's helpers may leave its process group and its session, and outlive their parent. As long
//! as a [`Family`] exists, such an orphan becomes a child of this process, where it can be found.
//! Therefore there may be only one at a time, and this process must start nothing else meanwhile.

use std::{
    collections::{HashMap, HashSet},
    fs, io,
};

use rustix::process::{
    Pid, Signal, WaitOptions, getpid, kill_process, set_child_subreaper, waitpid,
};

/// All processes that this process has started since.
pub(crate) struct Family {
    /// Children from before.
    others: HashSet<i32>,
}

impl Family {
    /// Adopts orphans from now on.
    pub(crate) fn begin() -> io::Result<Self> {
        set_child_subreaper(Some(getpid()))?;
        let this = getpid().as_raw_pid();
        let others = children().remove(&this).unwrap_or_default();
        Ok(Self {
            others: others.into_iter().collect(),
        })
    }

    /// The living processes. Reaps dead orphans, but not `head`, since the process that started it
    /// waits for it.
    pub(crate) fn members(&self, head: i32) -> Vec<Pid> {
        let mut children = children();
        let this = getpid().as_raw_pid();
        let mut found = Vec::new();
        let mut next = children.remove(&this).unwrap_or_default();
        next.retain(|pid| !self.others.contains(pid));
        next.retain(|pid| *pid == head || !is_cleared(*pid));
        while let Some(pid) = next.pop() {
            next.extend(children.remove(&pid).unwrap_or_default());
            found.extend(Pid::from_raw(pid).filter(|_| !is_zombie(pid)));
        }
        found
    }

    /// Kills the living processes.
    pub(crate) fn kill(&self, head: i32) {
        for pid in self.members(head) {
            let _ = kill_process(pid, Signal::KILL);
        }
    }
}

impl Drop for Family {
    fn drop(&mut self) {
        let _ = set_child_subreaper(None);
    }
}

/// Reaps a child of this process if it is a zombie; returns whether it did.
fn is_cleared(pid: i32) -> bool {
    is_zombie(pid)
        && Pid::from_raw(pid)
            .is_some_and(|pid| matches!(waitpid(Some(pid), WaitOptions::NOHANG), Ok(Some(_))))
}

fn is_zombie(pid: i32) -> bool {
    stat(pid).is_none_or(|(state, _)| matches!(state, 'Z' | 'X'))
}

/// The children of every process.
fn children() -> HashMap<i32, Vec<i32>> {
    let mut children: HashMap<i32, Vec<i32>> = HashMap::new();
    for entry in fs::read_dir("/proc").into_iter().flatten().flatten() {
        let pid = entry
            .file_name()
            .to_str()
            .and_then(|name| name.parse().ok());
        if let Some((pid, (_, parent))) = pid.and_then(|pid| Some((pid, stat(pid)?))) {
            children.entry(parent).or_default().push(pid);
        }
    }
    children
}

/// A process's state and parent.
fn stat(pid: i32) -> Option<(char, i32)> {
    state_and_parent(&fs::read_to_string(format!("/proc/{pid}/stat")).ok()?)
}

/// The two fields after the name, which may contain any characters.
fn state_and_parent(stat: &str) -> Option<(char, i32)> {
    let (_, rest) = stat.rsplit_once(')')?;
    let mut fields = rest.split_whitespace();
    Some((fields.next()?.chars().next()?, fields.next()?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_any_characters_hides_no_field() {
        assert_eq!(state_and_parent("7 (a) b (c) S 3 7"), Some(('S', 3)));
        assert_eq!(state_and_parent("7 (a) S"), None);
        assert_eq!(state_and_parent(""), None);
    }
}
