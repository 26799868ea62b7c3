//! What a browser is started with: flags for measurement, and for a network that leads only to the plant.
//!
//! Chromium takes all of it as flags. Firefox takes its folder as a flag and the rest from a file in
//! that folder, see [`crate::preference`].

use std::{net::SocketAddr, path::Path};

use endpoint::report::Engine;

/// Flags for every start of Chromium.
const CHROMIUM: &[&str] = &[
    "--headless=new",
    // A testbed has no GPU; without this flag one is emulated.
    "--disable-gpu",
    "--mute-audio",
    // A fresh profile starts with questions.
    "--no-first-run",
    "--no-default-browser-check",
    "--password-store=basic",
    "--use-mock-keychain",
    // Cached answers are kept in memory only: they must not be stored, and looking for them on disk
    // takes half a millisecond of each request.
    "--incognito",
    // Chromium throttles hidden pages.
    "--disable-background-timer-throttling",
    "--disable-renderer-backgrounding",
    "--disable-backgrounding-occluded-windows",
    // A thread that blocks on purpose looks hung.
    "--disable-hang-monitor",
    // Nothing may be fetched, sent or asked for except from the plant.
    "--no-proxy-server",
    "--no-pings",
    "--disable-background-networking",
    "--disable-breakpad",
    "--disable-client-side-phishing-detection",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-domain-reliability",
    "--disable-extensions",
    "--disable-sync",
    "--metrics-recording-only",
    "--disable-features=MediaRouter,OptimizationHints,Translate,HttpsUpgrades,\
     HttpsFirstBalancedModeAutoEnable",
];

/// Properties of this machine that the arguments depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Circumstance {
    /// Whether Chromium should use its own sandbox.
    pub(crate) sandbox: bool,
    /// Whether `/dev/shm` has enough room for a browser.
    pub(crate) shared_memory: bool,
}

/// All arguments, the page's address last.
pub(crate) fn arguments(
    engine: Engine,
    profile: &Path,
    plant: SocketAddr,
    url: &str,
    circumstance: Circumstance,
) -> Vec<String> {
    let mut arguments = Vec::new();
    match engine {
        Engine::Chromium => {
            arguments.extend(CHROMIUM.iter().map(ToString::to_string));
            arguments.push(format!("--user-data-dir={}", profile.display()));
            // Only a secure context has shared memory and a clock better than 100 us, and only
            // loopback and HTTPS are secure by themselves.
            if !plant.ip().is_loopback() {
                arguments.push(format!(
                    "--unsafely-treat-insecure-origin-as-secure=http://{plant}"
                ));
            }
            if !circumstance.sandbox {
                arguments.push("--no-sandbox".to_owned());
            }
            if !circumstance.shared_memory {
                arguments.push("--disable-dev-shm-usage".to_owned());
            }
        }
        Engine::Firefox => {
            let words = ["--headless", "--no-remote", "--new-instance", "--profile"];
            arguments.extend(words.map(str::to_owned));
            arguments.push(profile.display().to_string());
        }
    }
    arguments.push(url.to_owned());
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Circumstance = Circumstance {
        sandbox: true,
        shared_memory: true,
    };

    fn of(engine: Engine, plant: &str, circumstance: Circumstance) -> Vec<String> {
        let plant = plant.parse().expect("an address");
        let url = format!("http://{plant}/?run=1");
        arguments(engine, Path::new("/p"), plant, &url, circumstance)
    }

    #[test]
    fn an_origin_is_declared_secure_only_where_it_is_not() {
        let far = of(Engine::Chromium, "10.77.0.2:8080", GOOD);
        let flag = "--unsafely-treat-insecure-origin-as-secure=http://10.77.0.2:8080";
        assert!(far.iter().any(|argument| argument == flag), "{far:?}");
        let near = of(Engine::Chromium, "127.0.0.1:8080", GOOD);
        assert!(!near.iter().any(|argument| argument.contains("unsafely")));
    }

    #[test]
    fn the_sandbox_and_shared_memory_are_only_given_up_where_they_have_to_be() {
        let bare = Circumstance {
            sandbox: false,
            shared_memory: false,
        };
        for flag in ["--no-sandbox", "--disable-dev-shm-usage"] {
            let has = |circumstance| {
                of(Engine::Chromium, "127.0.0.1:1", circumstance).contains(&flag.to_owned())
            };
            assert!(has(bare) && !has(GOOD), "{flag}");
        }
    }

    #[test]
    fn the_address_is_last_and_the_profile_is_our_own() {
        for engine in Engine::ALL {
            let arguments = of(*engine, "127.0.0.1:8080", GOOD);
            let last = arguments.last().map(String::as_str);
            assert_eq!(last, Some("http://127.0.0.1:8080/?run=1"));
            assert!(arguments.iter().any(|argument| argument.ends_with("/p")));
        }
    }
}
