//! What the echoes of a run say of its link, for the manifest and for `probes.csv`.

use std::path::Path;

use plan::Phase;
use serde_json::Value;
use shaper::{Echo, Edge};

use crate::RunError;
use crate::course::Seen;
use crate::proof::Proof;

/// What a run has shown, for its manifest.
#[derive(Debug, Default)]
pub(crate) struct Evidence {
    pub(crate) epoch_ns: u64,
    pub(crate) start_ns: u64,
    pub(crate) certificate: Option<Value>,
    /// Why the run is not to be trusted; empty if it is.
    pub(crate) doubts: Vec<String>,
}

/// Judges the link by its echoes, and the run by the link.
pub(crate) fn judge(proof: &Proof, seen: &Seen, edge: Edge) -> Evidence {
    let phases = &seen.echoes;
    let mut evidence = Evidence {
        epoch_ns: seen.epoch_ns,
        start_ns: seen.start_ns,
        ..Evidence::default()
    };
    let Some(baseline) = proof.baseline(&phases[0].1) else {
        evidence
            .doubts
            .push("no echo came through the empty link".into());
        return evidence;
    };
    let echoes = in_order(&phases[1..]);
    if let Some(certificate) = proof.certificate(&echoes, baseline, edge) {
        if let shaper::Verdict::Broken(reasons) = &certificate.verdict {
            evidence.doubts.extend(reasons.iter().cloned());
        }
        evidence.certificate = serde_json::to_value(certificate).ok();
    } else if echoes.iter().all(|echo| echo.t_back_ns.is_none()) {
        evidence
            .doubts
            .push("no echo came back over loopback".into());
    }
    evidence
}

/// The echoes of several series as one, in order of sending.
fn in_order(phases: &[(Phase, Vec<Echo>)]) -> Vec<Echo> {
    let mut echoes: Vec<_> = phases
        .iter()
        .flat_map(|(_, echoes)| echoes.iter().copied())
        .collect();
    echoes.sort_by_key(|echo| echo.t_send_ns);
    echoes
}

/// Leaves every echo, beside what the link had for it, in the file `path`.
pub(crate) fn write_rows(
    proof: &Proof,
    phases: &[(Phase, Vec<Echo>)],
    path: &Path,
) -> Result<(), RunError> {
    let fail = |problem: csv::Error| RunError::write(path, std::io::Error::other(problem));
    let mut csv = csv::Writer::from_path(path).map_err(fail)?;
    for (phase, echoes) in phases {
        for row in proof.rows(*phase, echoes) {
            csv.serialize(row).map_err(fail)?;
        }
    }
    csv.flush()
        .map_err(|problem| RunError::write(path, problem))
}
