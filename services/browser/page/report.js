// The page's report of a run, as the plant keeps it in page.json.
//
// It says what was asked, what came of it, and what the browser granted.

/** The report as JSON. `run` has what run.js knows when it is over. */
export function reportText(run) {
  const { settings, start_ns, measured, ended } = run;
  const h_ns = settings.h_ns ?? 0;
  const stop_ns = start_ns === null ? null : start_ns + BigInt(settings.duration_ns);
  const report = {
    outcome: ended.outcome,
    reason: ended.reason ?? "",
    start_ns,
    stop_ns,
    counts: ended.counts,
    first_failure: ended.first_failure,
    user_agent: navigator.userAgent,
    isolated: globalThis.crossOriginIsolated === true,
    secure: globalThis.isSecureContext === true,
    hidden: run.hidden,
    clock: {
      source: measured?.clock.source ?? null,
      step_us: measured?.clock.step_us ?? null,
      error_ms: ended.error_ms,
    },
    timer_clamp_ms: measured?.timer_clamp_ms ?? null,
    timer_floor_ms: settings.floor_ns / 1e6,
    rate_asked_hz: h_ns > 0 ? 1e9 / h_ns : null,
    rate_achieved_hz: ended.rate_achieved_hz,
    settings,
  };
  return JSON.stringify(report, (_, value) =>
    typeof value === "bigint" ? exact(value) : value,
  );
}

/** A BigInt as a number in JSON, with all its digits where the browser can write them. */
function exact(value) {
  /** @type {any} */
  const json = JSON;
  return typeof json.rawJSON === "function" ? json.rawJSON(String(value)) : Number(value);
}
