//! A sweep among things of every kind and owner.

use std::process::Command;

use containers::compose::{Order, Owner, Reason, gc};

use crate::docker::{Decoy, tag};

const KINDS: [&str; 3] = ["container", "network", "volume"];

/// A container, a network and a volume of one project.
fn three(project: &str, owner: Option<&str>, running: bool) -> Vec<Decoy> {
    let mut labels = vec![format!("com.docker.compose.project={}", full(project))];
    labels.extend(owner.map(|owner| format!("webloop.owner={owner}")));
    KINDS
        .map(|kind| {
            let running = running && kind == "container";
            Decoy::new(kind, project, &labels, running)
        })
        .into()
}

fn full(project: &str) -> String {
    format!("{}-{project}", tag())
}

/// The names of what was removed, or would have been.
fn sweep(project: &str, dry_run: bool, force: bool) -> Vec<String> {
    let order = Order {
        dry_run,
        force,
        project: Some(full(project)),
    };
    let swept = gc(&order).unwrap();
    assert!(swept.is_clean(), "{:?}", swept.left);
    swept.removed.into_iter().map(|thing| thing.name).collect()
}

fn there(decoys: &[Decoy]) -> usize {
    decoys.iter().filter(|decoy| decoy.exists()).count()
}

/// A process of this machine that is not there any more.
fn gone() -> String {
    let mut child = Command::new("true").spawn().unwrap();
    let pid = child.id();
    child.wait().unwrap();
    format!("{}:{pid}:1", Owner::this().unwrap().host())
}

pub(crate) fn a_sweep_takes_what_nobody_uses_and_nothing_else() {
    let this = Owner::this().unwrap().to_string();
    let foreign = three("foreign", None, true);
    let unlabelled = Decoy::new("volume", "unlabelled", &[], false);
    let alive = three("alive", Some(&this), true);
    let killed = three("killed", Some(&gone()), true);
    let running = three("running", Some(""), true);
    let ended = three("ended", Some(""), true);
    ended[0].end();

    // All projects at once, without touching what this machine may hold besides.
    let look = gc(&Order {
        dry_run: true,
        ..Order::default()
    })
    .unwrap();
    let would_go = |decoys: &[Decoy]| {
        let goes = |decoy: &&Decoy| look.removed.iter().any(|thing| thing.name == decoy.name());
        decoys.iter().filter(goes).count()
    };
    assert_eq!((would_go(&killed), would_go(&ended)), (3, 3));
    assert_eq!((would_go(&foreign), would_go(&alive)), (0, 0));
    assert_eq!(would_go(&running), 0);
    let why = |decoy: &Decoy| {
        let left = look
            .left
            .iter()
            .find(|left| left.thing.name == decoy.name());
        left.map(|left| left.reason.clone())
    };
    assert!(matches!(why(&alive[0]), Some(Reason::Alive { pid }) if pid == std::process::id()));
    assert!(matches!(why(&running[0]), Some(Reason::Running { .. })));
    // What has no label of ours is not even mentioned.
    assert_eq!(why(&foreign[0]), None);
    assert_eq!((there(&killed), there(&ended)), (3, 3));

    for project in ["foreign", "alive", "running"] {
        assert_eq!(sweep(project, false, false).len(), 0, "{project}");
    }
    assert_eq!(sweep("killed", false, false).len(), 3);
    assert_eq!(sweep("ended", false, false).len(), 3);
    assert_eq!((there(&killed), there(&ended)), (0, 0));
    assert_eq!(sweep("killed", false, false).len(), 0);

    // By force what a person runs goes too, and still not what is another's.
    for project in ["foreign", "alive"] {
        assert_eq!(sweep(project, false, true).len(), 0, "{project}");
    }
    assert_eq!(sweep("running", true, true).len(), 3);
    assert_eq!(there(&running), 3);
    assert_eq!(sweep("running", false, true).len(), 3);
    assert_eq!((there(&foreign), there(&alive)), (3, 3));
    assert!(unlabelled.exists());
}
