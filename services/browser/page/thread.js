// Where the loop runs: a worker of its own, or the page's main thread.
//
// Both report the same. A worker that does not end when asked is ended from outside.

import { NOTHING, beginCourse } from "./course.js";
import { Alarm } from "./ring.js";

/** How long a worker may take to stop beyond the timeout of a message that it waits for. */
const GRACE_MS = 1000;

/** Begins a run on the thread that its settings name; gives what stops it. */
export function begin(task, tell) {
  return task.settings.thread === "worker" ? inWorker(task, tell) : beginCourse(task, tell);
}

function inWorker(task, tell) {
  const alarm = task.settings.timer === "wait" ? new Alarm() : null;
  const worker = new Worker("/worker.js", { type: "module", name: "loop" });
  let counts = NOTHING.counts;
  let over = false;
  let grace = 0;
  const end = (event) => {
    if (!over) {
      over = true;
      clearTimeout(grace);
      worker.terminate();
      tell(event);
    }
  };
  worker.addEventListener("message", ({ data }) => {
    if (data.event === "ended") {
      end(data);
      return;
    }
    counts = data.counts ?? counts;
    tell(data);
  });
  worker.addEventListener("error", (error) => {
    const why = error.message ?? "its script could not be loaded";
    const reason = `the worker failed: ${why}`;
    end({ ...NOTHING, event: "ended", counts, outcome: "failed", reason });
  });
  worker.postMessage({ task: { ...task, alarm: alarm?.memory ?? null } });
  return {
    stop: () => {
      alarm?.stop();
      worker.postMessage({ stop: true });
      const reason = "the loop did not stop by itself, so its last rows are missing";
      grace = setTimeout(
        () => end({ ...NOTHING, event: "ended", counts, outcome: "stopped", reason }),
        task.settings.timeout_ns / 1e6 + GRACE_MS,
      );
    },
  };
}
