// The page's control of the plant: claimed, kept, given its rows and its report, and ended.
//
// Rows go out in chunks, one at a time and in order, each again until it is taken. While a
// session is held no other client commands the plant.

/** How often rows are sent. */
const FLUSH_MS = 1000;
/** The plant takes 64 KiB at a time. */
const CHUNK_BYTES = 60_000;
/** The pause before a chunk is sent again. */
const AGAIN_MS = 500;
/** How long the rest is tried to be delivered, when the run is over. */
const PATIENCE_MS = 10_000;
/** Silence after which the plant is told that the page is there; it waits 15 s. */
const SILENCE_MS = 4000;

/** The plant said no. Its words are the text. */
export class Refused extends Error {
  constructor(status, text) {
    super(text.trimEnd() === "" ? `the plant refused (${status})` : text.trimEnd());
    this.status = status;
  }
}

/** Claims the plant for this page. */
export async function claim(client) {
  const response = await post("/session", "application/json", JSON.stringify({ client }));
  const { session, h_ns, late, law = null, reference = null } = await response.json();
  return new Session(session, { h_ns, late, law, reference });
}

/** A session that is held. */
export class Session {
  token;
  /** The plant's sample time, what it does with commands that were overtaken, its law and its reference. */
  plant;
  /** Rows that the plant has taken. */
  delivered = 0;
  /** Why rows cannot be delivered any more. */
  broken = null;
  #pending = "";
  #chunk = 0;
  #sending = null;
  #heard_ms = performance.now();
  #beat;

  constructor(token, plant) {
    this.token = token;
    this.plant = plant;
    this.#beat = setInterval(() => this.#flush(), FLUSH_MS);
  }

  /** Rows for the plant, whole lines. */
  add(text) {
    this.#pending += text;
  }

  /** Delivers the rest and the report, and gives the plant back. */
  async end(report) {
    clearInterval(this.#beat);
    const until_ms = performance.now() + PATIENCE_MS;
    await this.#sending;
    while (this.#pending !== "" && this.broken === null) {
      await this.#send();
      if (this.#pending !== "" && performance.now() > until_ms) {
        throw new Error("the plant does not answer, so it lacks some rows");
      }
    }
    for (;;) {
      try {
        // What the rows met belongs into the report, so it is made only now.
        await post("/session/end", "application/json", report(), this.token);
        break;
      } catch (error) {
        if (error instanceof Refused || performance.now() > until_ms) {
          throw error;
        }
        await pause(AGAIN_MS);
      }
    }
    if (this.broken !== null) {
      throw this.broken;
    }
  }

  /** Gives the plant back while the page is being left, without waiting for the answer. */
  leave(report) {
    clearInterval(this.#beat);
    post("/session/end", "application/json", report, this.token, true).catch(() => {});
  }

  #flush() {
    if (this.#sending !== null || this.broken !== null) {
      return;
    }
    if (this.#pending !== "") {
      this.#sending = this.#send().finally(() => {
        this.#sending = null;
      });
    } else if (performance.now() - this.#heard_ms > SILENCE_MS) {
      this.#heard_ms = performance.now();
      fetch("/state", { cache: "no-store", headers: this.#headers() }).catch(() => {});
    }
  }

  /** Sends what there is, until a chunk fails. */
  async #send() {
    while (this.#pending !== "" && this.broken === null) {
      const end =
        this.#pending.length <= CHUNK_BYTES
          ? this.#pending.length
          : this.#pending.lastIndexOf("\n", CHUNK_BYTES) + 1;
      const rows = this.#pending.slice(0, end);
      try {
        await post(`/session/rows?chunk=${this.#chunk}`, "text/csv", rows, this.token);
      } catch (error) {
        if (error instanceof Refused && error.status < 500) {
          this.broken = error;
        } else {
          await pause(AGAIN_MS);
        }
        return;
      }
      this.#chunk += 1;
      this.#pending = this.#pending.slice(end);
      this.delivered += rows.split("\n").length - 1;
      this.#heard_ms = performance.now();
    }
  }

  #headers() {
    return { "Webloop-Session": this.token };
  }
}

async function post(path, type, body, token, keepalive = false) {
  const headers = { "Content-Type": type };
  if (token !== undefined) {
    headers["Webloop-Session"] = token;
  }
  const response = await fetch(path, { method: "POST", headers, body, keepalive });
  if (response.status === 408) {
    // Over a link that stood still the body came too slowly: as if there had been no answer.
    throw new Error(await response.text());
  }
  if (!response.ok) {
    throw new Refused(response.status, await response.text());
  }
  return response;
}

/** Waits. */
export function pause(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}
