// The course of a run in the loop's own thread: measure, look at the plant, start, drive.
//
// Called on the main thread or by worker.js. Every event is reported; the one who
// listens (run.js) keeps the session with the plant and shows it.

import { Clock, measureOffset, monotonic_ns } from "./clock.js";
import { Drive } from "./drive.js";
import { readState } from "./message.js";
import { clockStep_us, timerClamp_ms } from "./probe.js";
import { Alarm } from "./ring.js";
import { makeSender } from "./way.js";

/** The start, if none is given, is this long after everything is ready. */
const START_AHEAD_NS = 200_000_000n;

/**
 * A run by `task`: settings, law, reference, session, `start_ns` and `clock_ns` (BigInt or null), and `alarm`,
 * the memory of what a sleeping run is woken by. Gives what stops it.
 */
export function beginCourse(task, tell) {
  let drive = null;
  let stopped = false;
  const alarm = task.alarm === null ? null : new Alarm(task.alarm);
  const course = async () => {
    const clock_ns = task.clock_ns ?? (await measureOffset());
    const measured = {
      clock: { source: task.clock_ns === null ? "measured" : "given", step_us: clockStep_us() },
      timer_clamp_ms: await timerClamp_ms(),
      isolated: globalThis.crossOriginIsolated === true,
      secure: globalThis.isSecureContext === true,
    };
    const y = await look();
    const start_ns = task.start_ns ?? monotonic_ns(clock_ns) + START_AHEAD_NS;
    const clock = new Clock(clock_ns, start_ns);
    const made = new Drive({
      settings: task.settings,
      law: task.law,
      reference: task.reference,
      clock,
      y,
      alarm,
      makeSender: (ended, readSeq) => makeSender({ ...task, alarm }, ended, readSeq),
      tell,
    });
    await made.open();
    const late_ns = clock.now_ns();
    tell({ event: "ready", start_ns, measured, wait_ms: -late_ns / 1e6 });
    if (late_ns > 0) {
      const late_ms = (late_ns / 1e6).toFixed(0);
      throw new LateStart(`the page was ready ${late_ms} ms after its start; give it more time`);
    }
    if (stopped) {
      tell({ event: "ended", ...NOTHING, outcome: "stopped" });
      return;
    }
    drive = made;
    tell({ event: "ended", ...(await drive.run()) });
  };
  course().catch((error) => {
    const outcome = error instanceof LateStart ? "late" : "failed";
    tell({ event: "ended", ...NOTHING, outcome, reason: error.message });
  });
  return {
    stop: () => {
      stopped = true;
      drive?.stop();
    },
  };
}

/** The counts of a run that did not begin. */
export const NOTHING = {
  counts: { due: 0, sent: 0, missed: 0, answered: 0, timeout: 0, failed: 0 },
  first_failure: null,
  error_ms: 0,
  rate_achieved_hz: 0,
};

class LateStart extends Error {}

/** The plant's output before the first command, or both; it also opens the first connection. */
async function look() {
  const response = await fetch("/state", { cache: "no-store" });
  const text = await response.text();
  if (!response.ok) {
    throw new Error(`the plant's state could not be read: ${response.status}: ${text}`);
  }
  return readState(text).y;
}
