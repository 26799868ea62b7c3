// Sending from a second worker, so that the loop's own may sleep until its deadlines.
//
// A thread that sleeps in Atomics.wait hears no events, so fetch and WebSocket cannot live there. The
// second worker, sender.js, has them; it is given texts by postMessage, which needs no event loop of
// the one who posts, and tells through a ring how they ended.

import { Ring } from "./ring.js";

/** A sender of another worker. What ended is told in `collect`, which the loop calls when it wakes. */
export class RemoteSender {
  blocks = false;
  #task;
  #ended;
  #ring = new Ring();
  #worker = null;

  /** `task` is what sender.js needs: settings and session. `alarm` wakes the loop. */
  constructor({ settings, session, alarm }, ended) {
    this.#task = { settings, session, alarm: alarm.memory, ring: this.#ring.memory };
    this.#ended = ended;
  }

  /** Starts the worker and opens its way to the plant. */
  open() {
    return new Promise((resolve, reject) => {
      const worker = new Worker("/sender.js", { type: "module", name: "sender" });
      this.#worker = worker;
      worker.addEventListener("message", ({ data }) => {
        if (data.problem === undefined) {
          resolve();
        } else {
          reject(new Error(data.problem));
        }
      });
      worker.addEventListener("error", (error) => {
        const why = error.message ?? "its script could not be loaded";
        reject(new Error(`the sender's worker failed: ${why}`));
      });
      worker.postMessage({ task: this.#task });
    });
  }

  send(seq, text) {
    this.#worker.postMessage({ seq, text });
  }

  abort(seq) {
    this.#worker.postMessage({ abort: seq });
  }

  close() {
    this.#worker?.postMessage({ close: true });
  }

  /** Tells what has ended since the last time. */
  collect() {
    for (let told = this.#ring.read(); told !== null; told = this.#ring.read()) {
      this.#ended(told.seq, told.result);
    }
  }
}
