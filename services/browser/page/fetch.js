// Sending by fetch: each message a request of its own, as many at a time as the end allows.
//
// A browser opens at most six connections to a host over HTTP/1.1; messages beyond wait inside
// it, after they count as sent.

import { excerpt } from "./message.js";

const EXCERPT_CHARS = 200;

/** Requests under way by seq. */
export class FetchSender {
  blocks = false;
  #way;
  #ended;
  #underWay = new Map();

  /** `way` is how to the plant: path and session. */
  constructor(way, ended) {
    this.#way = way;
    this.#ended = ended;
  }

  open() {}

  send(seq, text) {
    const control = new AbortController();
    this.#underWay.set(seq, control);
    this.#exchange(text, control.signal).then((result) => {
      if (this.#underWay.delete(seq)) {
        this.#ended(seq, result);
      }
    });
  }

  /** Gives a message up; nothing is heard of it any more. */
  abort(seq) {
    const control = this.#underWay.get(seq);
    this.#underWay.delete(seq);
    control?.abort();
  }

  close() {}

  async #exchange(text, signal) {
    const { path, session } = this.#way;
    try {
      const response = await fetch(`${path}?${text}`, {
        headers: { "Webloop-Session": session },
        cache: "no-store",
        redirect: "error",
        signal,
      });
      const body = await response.text();
      if (response.status !== 200) {
        const said = excerpt(body.trimEnd(), EXCERPT_CHARS);
        return { loss: "failed", why: `${response.status}: ${said}` };
      }
      return { text: body };
    } catch (error) {
      return { loss: "failed", why: `the plant does not answer (${error.message})` };
    }
  }
}
