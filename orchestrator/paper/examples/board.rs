//! The claims board of a results folder as text: `cargo run -p webloop-paper --example board -- DIR`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("which results folder?")?;
    let campaign = analysis::Campaign::read(Path::new(&folder))?;
    for finding in paper::claim::all(&campaign)? {
        // A verdict as the files write it.
        let verdict = serde_json::to_value(finding.verdict)?;
        let verdict = verdict.as_str().unwrap_or_default();
        println!("{verdict:<15}{:<12}{}", finding.place, finding.id);
        println!("               {}", finding.claim);
        println!("               {}", finding.reason);
        for part in &finding.parts {
            let verdict = serde_json::to_value(part.verdict)?;
            let of = part.of.as_str();
            let ours = part.ours.map_or_else(String::new, |ours| {
                format!(
                    "{:.5} [{:.5}, {:.5}] n {}",
                    ours.value, ours.low, ours.high, ours.n
                )
            });
            println!(
                "                 {:<15}{of}: {ours} {} (paper {:?}, accepted {:?})",
                verdict.as_str().unwrap_or_default(),
                part.unit,
                part.paper,
                part.accepted
            );
        }
    }
    Ok(())
}
