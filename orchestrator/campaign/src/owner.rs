//! Becoming the owner of a folder: in a container, results are to belong to whoever called.
//!
//! A compose file cannot know its caller, but the folder that they mounted does. A process that
//! is started as root with no right but to change its user becomes that folder's owner here,
//! before it does anything else, and has no right left. Anyone else stays who they are.

use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::process::{Gid, Uid, getuid};
use rustix::thread::{
    CapabilitySet, CapabilitySets, set_capabilities, set_thread_gid, set_thread_groups,
    set_thread_uid,
};

use crate::error::Error;

/// Makes this process, which must have one thread as yet, the owner of `folder`.
///
/// # Errors
/// When there is no such folder, or this process may not.
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
