//! The identity of a sweep's folder: everything that determines its rows, stored in its manifest.

use std::path::Path;

use backend::Timings;
use serde_json::{Map, Value, json};
use sweep::{Instead, Sweep, checksum};

use crate::error::Error;
use crate::open_error::OpenError;

/// The file that says which sweep the folder belongs to.
pub(super) const MANIFEST: &str = "manifest.json";
/// Version of the manifest's format.
const VERSION: u32 = 1;

/// Checks that a folder belongs to the same sweep.
pub(super) fn check(
    text: &str,
    identity: &Map<String, Value>,
    folder: &Path,
) -> Result<(), OpenError> {
    let before: Map<String, Value> =
        serde_json::from_str(text).map_err(|problem| OpenError::Damaged {
            path: folder.join(MANIFEST),
            problem,
        })?;
    for (key, own) in identity {
        let other = before.get(key).unwrap_or(&Value::Null);
        if own != other {
            return Err(OpenError::OtherSweep {
                path: folder.to_owned(),
                key: key.clone(),
                other: other.to_string(),
                own: own.to_string(),
            });
        }
    }
    Ok(())
}

/// Everything that determines the rows.
pub(super) fn identity(
    sweep: &Sweep,
    text: &str,
    timings: &Timings,
    instead: &Instead,
) -> Result<Map<String, Value>, Error> {
    let mut profiles = Map::new();
    for profile in sweep.grid.profiles() {
        let text = serde_json::to_string(&**profile)?;
        profiles.insert(profile.name().to_owned(), json!(checksum(&text)));
    }
    let systems: Map<String, Value> = sweep
        .grid
        .systems()
        .map(|system| (system.name().to_owned(), json!(checksum(system.text()))))
        .collect();
    let fixed: Map<String, Value> = instead
        .fixed
        .iter()
        .map(|(axis, value)| (axis.to_string(), json!(value)))
        .collect();
    let of_timings = sweep
        .grid
        .takes_time()
        .then(|| checksum(&timings.to_toml()));
    let identity = [
        ("version", json!(VERSION)),
        ("webloop", json!(env!("CARGO_PKG_VERSION"))),
        ("sweep", json!(sweep.name)),
        ("seed", json!(sweep.seed)),
        ("fixed", Value::Object(fixed)),
        ("sweep_sha256", json!(checksum(text))),
        ("timings_sha256", json!(of_timings)),
        ("profiles_sha256", Value::Object(profiles)),
        ("systems_sha256", Value::Object(systems)),
    ];
    let named = identity.map(|(name, value)| (name.to_owned(), value));
    Ok(named.into_iter().collect())
}

/// The text of a manifest.
pub(super) fn manifest(facts: &Map<String, Value>) -> String {
    // Plain data of strings and finite numbers: serialising it cannot fail.
    serde_json::to_string_pretty(facts).unwrap_or_default() + "\n"
}
