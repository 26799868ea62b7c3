//! Becoming the owner of a folder: results from a container should belong to the caller.
//!
//! A compose file cannot know its caller, but the folder that the caller mounted has an owner. A
//! process that starts as root, with no right but to change its user, becomes that owner here
//! before it does anything else, and then has no rights left. Any other process keeps its user.

use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::process::{Gid, Uid, getuid};
use rustix::thread::{
    CapabilitySet, CapabilitySets, set_capabilities, set_thread_gid, set_thread_groups,
    set_thread_uid,
};

use crate::error::Error;

/// Changes the user of this process, which must still have only one thread, to the owner of `folder`.
///
/// # Errors
/// When the folder does not exist, or the change is not permitted.
pub fn become_owner_of(folder: &Path) -> Result<(), Error> {
    let facts = folder.metadata().map_err(|source| Error::NoOwner {
        folder: folder.to_owned(),
        source,
    })?;
    if !getuid().is_root() {
        return Ok(());
    }
    let (uid, gid) = (facts.uid(), facts.gid());
    let change = || -> rustix::io::Result<()> {
        if (uid, gid) != (0, 0) {
            let gid = Gid::from_raw(gid);
            set_thread_groups(&[gid])?;
            set_thread_gid(gid)?;
            set_thread_uid(Uid::from_raw(uid))?;
        }
        let none = CapabilitySet::empty();
        set_capabilities(
            None,
            CapabilitySets {
                effective: none,
                permitted: none,
                inheritable: none,
            },
        )
    };
    change().map_err(|problem| Error::NotOwner {
        folder: folder.to_owned(),
        owner: format!("{uid}:{gid}"),
        problem: problem.into(),
    })
}
