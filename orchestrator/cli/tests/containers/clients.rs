//! Each client in a container of its own kind, through a shaped link, by `docker compose up`.

use std::process::Output;

use link::certificate::Verdict::Holds;
use plan::Verdict;
use record::Manifest;

use crate::docker::docker;
use crate::testbed::Testbed;
use crate::webloop::{code, manifest, said, too_busy, was_busy};

pub(crate) fn each_client_runs_in_a_container_through_a_shaped_link() -> Result<(), String> {
    let mut lacking = Vec::new();
    for (client, topologies) in [
        ("python", &["couva"][..]),
        ("chromium", &["couva", "diego-vpn"]),
        ("firefox", &["couva", "diego-vpn"]),
    ] {
        if let Err(lack) = docker(&["image", "inspect", &format!("webloop-{client}")]) {
            lacking.push(format!(
                "{client}: {lack}; build it: CLIENT={client} docker compose build"
            ));
            continue;
        }
        for topology in topologies {
            let manifest = up(client, topology)?;
            let certificate = manifest.certificate.as_ref().unwrap();
            assert_eq!(certificate.verdict, Holds, "{certificate:?}");
            assert_eq!(manifest.cell.client.to_string(), client);
            if manifest.cell.client.is_browser() {
                let page = manifest.page.as_ref().unwrap();
                assert_eq!(page.outcome, "complete", "{page:?}");
                assert!(page.isolated, "{page:?}");
            }
            println!(
                "  {client} over {topology}: certificate holds, {}",
                counts(&manifest)
            );
        }
    }
    if lacking.is_empty() {
        Ok(())
    } else {
        Err(lacking.join("\n"))
    }
}

/// Brings it up until its run is valid. Returns the manifest of its one cell.
fn up(client: &'static str, topology: &str) -> Result<Manifest, String> {
    for _ in serial::tries() {
        let mut testbed = Testbed::new(topology, "3s");
        testbed.set("CLIENT", client);
        let output: Output = testbed.up().output().unwrap();
        let exit = code(&output);
        assert!(matches!(exit, Some(0 | 1)), "{exit:?}: {}", said(&output));
        let cells = testbed.cells();
        assert_eq!(cells.len(), 1, "{client}: {}", said(&output));
        let manifest = manifest(&cells[0]);
        if manifest.verdict == Verdict::Complete {
            assert_eq!(exit, Some(0), "{}", said(&output));
            return Ok(manifest);
        }
        let reasons = manifest.reasons.join("; ");
        assert!(
            was_busy(&manifest) || reasons.contains("ended as late"),
            "{client} over {topology}: {}: {reasons}\n{}",
            manifest.verdict,
            said(&output)
        );
        println!("  too busy: {reasons}");
    }
    Err(too_busy(&format!("{client} over {topology}")))
}

fn counts(manifest: &Manifest) -> String {
    let page = manifest.page.as_ref().map(|page| &page.counts);
    let controller = || manifest.controller.as_ref()?.counts();
    let counts = page.or_else(controller);
    counts.map_or_else(String::new, |counts| format!("{counts:?}"))
}
