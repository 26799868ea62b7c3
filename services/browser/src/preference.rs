//! Firefox's preferences: the `user.js` of a fresh profile.
//!
//! They request the same as the flags of [`crate::argument`] for Chromium: no questions, no
//! throttling, and nothing fetched, sent or asked for except from the plant. The resolution of timers
//! and of the clock keeps its default.

use std::{fmt::Write, net::SocketAddr};

/// Preferences and their values, as JavaScript.
const PREFERENCES: &[(&str, &str)] = &[
    // A fresh profile starts with questions and welcome pages.
    ("app.normandy.first_run", "false"),
    ("browser.aboutConfig.showWarning", "false"),
    ("browser.aboutwelcome.enabled", "false"),
    ("browser.newtabpage.enabled", "false"),
    ("browser.newtab.preload", "false"),
    ("browser.shell.checkDefaultBrowser", "false"),
    ("browser.startup.homepage", "\"about:blank\""),
    ("browser.startup.homepage_override.mstone", "\"ignore\""),
    ("browser.startup.page", "0"),
    (
        "datareporting.policy.dataSubmissionPolicyBypassNotification",
        "true",
    ),
    ("startup.homepage_welcome_url", "\"\""),
    ("termsofuse.bypassNotification", "true"),
    ("trailhead.firstrun.didSeeAboutWelcome", "true"),
    // Do not restore an earlier session.
    ("browser.sessionstore.resume_from_crash", "false"),
    ("toolkit.startup.max_resumed_crashes", "-1"),
    // Browsers throttle hidden pages and expensive pages.
    ("dom.timeout.enable_budget_timer_throttling", "false"),
    ("browser.tabs.unloadOnLowMemory", "false"),
    // What a page's loading leaves is collected 4 and 10 s after it: in the midst of a loop that a page
    // begins 6 s after. So it is collected at once, and the loop meets a browser that has settled.
    ("javascript.options.gc_delay", "1000"),
    ("javascript.options.gc_delay.first", "1000"),
    // A thread that blocks on purpose looks hung.
    ("dom.ipc.processHangMonitor", "false"),
    ("dom.ipc.reportProcessHangs", "false"),
    ("dom.max_script_run_time", "0"),
    // The plant speaks HTTP, and there is no other server.
    ("dom.security.https_first", "false"),
    ("dom.security.https_first_schemeless", "false"),
    ("dom.security.https_only_mode", "false"),
    ("network.proxy.type", "0"),
    ("network.trr.mode", "5"),
    ("network.captive-portal-service.enabled", "false"),
    ("network.connectivity-service.enabled", "false"),
    ("network.dns.disablePrefetch", "true"),
    ("network.http.speculative-parallel-limit", "0"),
    ("network.manage-offline-status", "false"),
    ("network.predictor.enabled", "false"),
    ("network.prefetch-next", "false"),
    ("browser.urlbar.speculativeConnect.enabled", "false"),
    // Updates of any kind.
    ("app.normandy.enabled", "false"),
    ("app.update.auto", "false"),
    ("app.update.disabledForTesting", "true"),
    ("browser.region.network.url", "\"\""),
    ("browser.region.update.enabled", "false"),
    ("browser.search.update", "false"),
    ("browser.cache.disk.enable", "false"),
    ("extensions.getAddons.cache.enabled", "false"),
    ("extensions.systemAddon.update.enabled", "false"),
    ("extensions.update.enabled", "false"),
    ("media.gmp-manager.updateEnabled", "false"),
    (
        "services.settings.server",
        "\"data:,#remote-settings-dummy/v1\"",
    ),
    ("security.OCSP.enabled", "0"),
    // Reports to Mozilla, and lists from it.
    ("browser.contentblocking.database.enabled", "false"),
    ("browser.ping-centre.telemetry", "false"),
    ("browser.safebrowsing.blockedURIs.enabled", "false"),
    ("browser.safebrowsing.downloads.enabled", "false"),
    ("browser.safebrowsing.malware.enabled", "false"),
    ("browser.safebrowsing.phishing.enabled", "false"),
    ("browser.safebrowsing.update.enabled", "false"),
    ("browser.topsites.contile.enabled", "false"),
    ("datareporting.healthreport.uploadEnabled", "false"),
    ("datareporting.policy.dataSubmissionEnabled", "false"),
    ("datareporting.usage.uploadEnabled", "false"),
    ("dom.push.connection.enabled", "false"),
    ("extensions.pocket.enabled", "false"),
    ("privacy.trackingprotection.enabled", "false"),
    ("toolkit.telemetry.enabled", "false"),
    ("toolkit.telemetry.server", "\"\""),
    ("toolkit.telemetry.unified", "false"),
];

/// The text of `user.js` for a visit to `plant`.
pub(crate) fn user_js(plant: SocketAddr) -> String {
    let mut text = String::new();
    let mut set = |name: &str, value: &str| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "user_pref(\"{name}\", {value});");
    };
    for (name, value) in PREFERENCES {
        set(name, value);
    }
    // Only a secure context has shared memory and a clock better than 1 ms, and only loopback and
    // HTTPS are secure by themselves.
    if !plant.ip().is_loopback() {
        set(
            "dom.securecontext.allowlist",
            &format!("\"{}\"", plant.ip()),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn each_preference_is_one_line_and_is_set_once() {
        let plant = "10.77.0.2:8080".parse().expect("an address");
        let text = user_js(plant);
        let names: HashSet<&str> = text
            .lines()
            .map(|line| {
                assert!(
                    line.starts_with("user_pref(\"") && line.ends_with(");"),
                    "{line}"
                );
                line.split('"').nth(1).expect("a name")
            })
            .collect();
        assert_eq!(names.len(), PREFERENCES.len() + 1);
    }

    #[test]
    fn the_plant_is_declared_secure_by_its_address_alone_and_only_where_it_is_not() {
        let text = |plant: &str| user_js(plant.parse().expect("an address"));
        let line = "user_pref(\"dom.securecontext.allowlist\", \"10.77.0.2\");";
        assert!(text("10.77.0.2:8080").contains(line));
        assert!(!text("127.0.0.1:8080").contains("securecontext"));
    }
}
