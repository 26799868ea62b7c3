// One run from the claim to the report.
//
// It joins the session with the plant, the loop's thread and a view that is told what happens:
// `state(word, text)`, `began(settings, plant, isUnseen)`, `progress(event)`. It draws nothing itself.

import { beginChores } from "./chore.js";
import { NOTHING } from "./course.js";
import { readLaw } from "./law.js";
import { reportText } from "./report.js";
import { COLUMNS } from "./row.js";
import { Refused, claim, pause } from "./session.js";
import { check } from "./setting.js";
import { begin } from "./thread.js";

/** How long a page that starts by itself tries to get the plant. */
const CLAIM_MS = 5000;
const CLAIM_AGAIN_MS = 250;
/** A start further ahead is told to whoever looks on. */
const AHEAD_MS = 1000;

/** A run by the settings of setting.js. */
export class Run {
  #request;
  #view;
  #session = null;
  #thread = null;
  #stopped = false;
  #waiting = false;
  #rows = [];
  #counts = NOTHING.counts;
  /** What the report is made of. */
  #known;

  /** `request` is what readSettings gave. */
  constructor(request, view) {
    this.#request = request;
    this.#view = view;
    this.#known = {
      settings: request.settings,
      start_ns: request.start_ns,
      measured: null,
      ended: null,
      hidden: document.hidden,
    };
  }

  /** Runs to the end, which is told to the view; does not throw. */
  async toEnd() {
    const hide = () => {
      this.#known.hidden ||= document.hidden;
    };
    const leave = () => this.#leave();
    document.addEventListener("visibilitychange", hide);
    addEventListener("pagehide", leave);
    try {
      this.#view.state("claiming", "Asking the plant for control.");
      this.#session = await this.#claim();
      await this.#drive();
    } catch (error) {
      this.#end({ ...NOTHING, outcome: "failed", reason: error.message });
    }
    const undelivered = await this.#deliver();
    removeEventListener("pagehide", leave);
    document.removeEventListener("visibilitychange", hide);
    const { outcome, reason = "" } = this.#known.ended;
    const text = [reason, undelivered].filter((part) => part !== "").join(" ");
    this.#view.state(undelivered === "" ? outcome : "failed", text);
  }

  /** Ends the run before its time. */
  stop() {
    this.#stopped = true;
    this.#thread?.stop();
    this.#view.state("stopping", "Stopping: waiting for a message under way.");
  }

  /** All rows so far, as messages.csv. */
  csv() {
    return new Blob([`${COLUMNS}\n`, ...this.#rows], { type: "text/csv" });
  }

  /** What came of the run, when it is over. */
  get ended() {
    return this.#known.ended;
  }

  async #claim() {
    const until_ms = performance.now() + CLAIM_MS;
    for (;;) {
      try {
        return await claim(`a page in ${browser()}`);
      } catch (error) {
        const again = this.#request.run && performance.now() < until_ms && !this.#stopped;
        if (!again) {
          throw error instanceof Refused
            ? new Error(`The plant is not free: ${error.message}`)
            : new Error(`The plant does not answer (${error.message}).`);
        }
        await pause(CLAIM_AGAIN_MS);
      }
    }
  }

  async #drive() {
    const { h_ns, late, law, reference } = this.#session.plant;
    const asked = this.#request.settings;
    const settings = { ...asked, h_ns: asked.h_ns ?? h_ns, late: asked.late ?? late };
    this.#known.settings = settings;
    if (this.#request.invalid !== undefined) {
      throw this.#request.invalid;
    }
    check(settings);
    // The loop's thread will read it again; an invalid law is refused before all else.
    readLaw(law);
    this.#view.began(settings, this.#session.plant, this.#request.run);
    this.#view.state("preparing", "Measuring this browser's clock and timers.");
    const { start_ns, clock_ns } = this.#request;
    const { token } = this.#session;
    const told = { settings, law, reference };
    const task = { ...told, start_ns, clock_ns, session: token, alarm: null };
    const endChores = beginChores(settings.chores_ns);
    await new Promise((resolve) => {
      this.#thread = begin(task, (event) => {
        this.#told(event);
        if (event.event === "ended") {
          resolve();
        }
      });
      if (this.#stopped) {
        this.#thread.stop();
      }
    });
    endChores();
  }

  #told(event) {
    switch (event.event) {
      case "ready":
        this.#known.start_ns = event.start_ns;
        this.#known.measured = event.measured;
        this.#waiting = event.wait_ms > AHEAD_MS;
        if (this.#waiting) {
          const wait_s = (event.wait_ms / 1000).toFixed(0);
          this.#view.state("waiting", `The first deadline is in ${wait_s} s.`);
        } else {
          this.#view.state("running", "");
        }
        break;
      case "progress":
        if (this.#waiting && !this.#stopped) {
          this.#waiting = false;
          this.#view.state("running", "");
        }
        this.#counts = event.counts;
        this.#view.progress(event);
        break;
      case "rows":
        this.#rows.push(event.text);
        this.#session.add(event.text);
        break;
      default:
        this.#end(event);
    }
  }

  #end(ended) {
    this.#known.ended = ended;
  }

  /** Gives the plant the rest and its freedom; what went wrong with that, in words. */
  async #deliver() {
    if (this.#session === null) {
      return "";
    }
    this.#view.state("delivering", "Sending the rows to the plant.");
    try {
      await this.#session.end(() => {
        const { broken } = this.#session;
        if (broken !== null) {
          const reason = `rows refused: ${broken.message}`;
          this.#end({ ...this.#known.ended, outcome: "failed", reason });
        }
        return reportText(this.#known);
      });
      return "";
    } catch (error) {
      const rows = this.#session.delivered;
      return (
        `The plant has ${rows} rows and no more: ${error.message}. ` +
        "All rows are here to download."
      );
    } finally {
      this.#session = null;
    }
  }

  #leave() {
    const reason = "the page was left, so its last rows are missing";
    const ended = { ...NOTHING, counts: this.#counts, outcome: "stopped", reason };
    this.#session?.leave(reportText({ ...this.#known, ended: this.#known.ended ?? ended }));
  }
}

/** This browser's name, for others who ask who is in control. */
function browser() {
  const [, name, version] =
    /(Firefox|Edg|Chrome|Safari)\/(\d+)/.exec(navigator.userAgent) ?? [];
  return name === undefined ? "a browser" : `${name} ${version}`;
}
