// Sending by a synchronous XMLHttpRequest: the thread stands still until the answer is here.
//
// The standard allows no timeout for one on the main thread: there an answer that comes too
// late is known as such only when it has come.

import { excerpt } from "./message.js";

const EXCERPT_CHARS = 200;
const IN_WORKER = "WorkerGlobalScope" in globalThis;

/** One request at a time, ended before `send` returns. */
export class XhrSender {
  /** Whether `send` returns only when the message has ended. */
  blocks = true;
  #way;
  #ended;

  /** `way` is how to the plant: path, session, timeout_ms. */
  constructor(way, ended) {
    this.#way = way;
    this.#ended = ended;
  }

  open() {}

  send(seq, text) {
    this.#ended(seq, this.#exchange(text));
  }

  abort() {}

  collect() {}

  close() {}

  #exchange(text) {
    const { path, session, timeout_ms } = this.#way;
    const request = new XMLHttpRequest();
    try {
      request.open("GET", `${path}?${text}`, false);
      if (IN_WORKER) {
        request.timeout = timeout_ms;
      }
      request.setRequestHeader("Webloop-Session", session);
      request.send();
    } catch (error) {
      if (error.name === "TimeoutError") {
        return { loss: "timeout" };
      }
      return { loss: "failed", why: "the plant does not answer (XMLHttpRequest failed)" };
    }
    if (request.status !== 200) {
      const said = excerpt(request.responseText.trimEnd(), EXCERPT_CHARS);
      return { loss: "failed", why: `${request.status}: ${said}` };
    }
    return { text: request.responseText };
  }
}
