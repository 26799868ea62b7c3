// What is happening, for a person: state, readouts, plot, histogram, and the window's title.
//
// Drawn from what the loop tells, at most ten times a second, and once where a launcher opened the
// page, since nobody looks at it; four times where the loop shares the page's thread.

import { Histogram } from "./histogram.js";
import { lawText } from "./law.js";
import { Plot } from "./plot.js";
import { sentence } from "./sentence.js";

const DRAW_MS = 100;
const DRAW_SHARED_MS = 250;
const DRAW_UNSEEN_MS = 1000;
/** The rate shown is that of the last second. */
const RATE_S = 1;

/** The states of a run: the word that is shown, and what it means if nothing else is said. */
const STATES = {
  ready: ["ready", "Choose a client and start."],
  claiming: ["starting", ""],
  preparing: ["starting", ""],
  waiting: ["ready", ""],
  running: ["running", "The loop is running."],
  stopping: ["stopping", ""],
  delivering: ["ending", ""],
  complete: ["complete", "All deadlines have passed, and the plant has all rows."],
  stopped: ["stopped", "Stopped before its time. The plant has all rows."],
  late: ["late", ""],
  failed: ["failed", ""],
};

/** The display of the page. */
export class Display {
  #plot;
  #histogram;
  #settings = null;
  #gap_ms = DRAW_MS;
  #drawn_ms = 0;
  #asked = false;
  #recent = [];
  #rate_hz = NaN;
  /** Whether the last message to end got no answer. */
  #silent = false;

  constructor() {
    this.#plot = new Plot(byId("plot"));
    this.#histogram = new Histogram(byId("histogram"));
    const again = () => this.#draw();
    new ResizeObserver(again).observe(byId("plot"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  }

  /** The run is in this state; `text` says more. */
  state(word, text) {
    const [shown, meaning] = STATES[word];
    byId("state").textContent = shown;
    byId("state").dataset.state = word;
    byId("message").textContent = text === "" ? meaning : sentence(text);
    document.title = `${shown} · webloop`;
    if (["complete", "stopped", "late", "failed"].includes(word)) {
      this.#draw();
    }
  }

  /**
   * A run begins, at a plant with this sample time and law; `isUnseen` if a launcher opened the page.
   */
  began(settings, plant, isUnseen) {
    this.#settings = settings;
    const ownThread_ms = isUnseen ? DRAW_UNSEEN_MS : DRAW_MS;
    this.#gap_ms = settings.thread === "main" ? DRAW_SHARED_MS : ownThread_ms;
    this.#recent = [];
    this.#rate_hz = NaN;
    this.#silent = false;
    this.#plot.begin(settings);
    this.#histogram.begin(settings);
    for (const name of ["sent", "missed", "lost", "rate", "rtt", "y", "u"]) {
      byId(name).textContent = "–";
    }
    byId("due").textContent = "of – due";
    byId("asked").textContent = `Hz of ${figure(1e9 / settings.h_ns)}`;
    byId("elapsed").value = 0;
    const open = settings.mode === "open";
    byId("plot-title").textContent = open ? "Round trip" : "Output and input";
    byId("law").textContent = open ? "" : lawText(plant.law);
    const [plant_ms, page_ms] = [plant.h_ns, settings.h_ns].map((ns) => figure(ns / 1e6));
    byId("note").textContent =
      settings.h_ns === plant.h_ns
        ? ""
        : `The plant ticks every ${plant_ms} ms, this page every ${page_ms} ms.`;
  }

  /** The loop told its progress. */
  progress(event) {
    const { t_s, counts, sends, ends } = event;
    this.#plot.add(event);
    this.#histogram.add(event);
    this.#recent.push([t_s, counts.sent]);
    while (this.#recent.length > 2 && this.#recent[1][0] <= t_s - RATE_S) {
      this.#recent.shift();
    }
    const [past_s, past] = this.#recent[0];
    this.#rate_hz = t_s > past_s ? (counts.sent - past) / (t_s - past_s) : NaN;

    byId("sent").textContent = grouped(counts.sent);
    byId("due").textContent = `of ${grouped(counts.due)} due`;
    byId("missed").textContent = grouped(counts.missed);
    const lost = counts.timeout + counts.failed;
    byId("lost").textContent = grouped(lost);
    byId("lost").classList.toggle("bad", lost > 0);
    byId("rate").textContent = figure(this.#rate_hz);
    if (ends.length > 0) {
      byId("rtt").textContent = figure(ends.at(-1));
      this.#silent = Number.isNaN(ends.at(-1));
    }
    if (sends.length > 0) {
      byId("y").textContent = figure(sends.at(-2));
      byId("u").textContent = figure(sends.at(-1));
    }
    byId("elapsed").value = Math.min(t_s / (this.#settings.duration_ns / 1e9), 1);
    if (byId("state").dataset.state === "running") {
      byId("message").textContent = this.#silent
        ? "The plant does not answer; the loop goes on until its end."
        : STATES.running[1];
    }
    if (document.hidden) {
      byId("note").textContent = "This page was in the background, where browsers slow its timers.";
    }
    this.#ask();
  }

  /** Draws soon, but not too often. */
  #ask() {
    if (this.#asked) {
      return;
    }
    if (performance.now() - this.#drawn_ms < this.#gap_ms) {
      return;
    }
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      this.#draw();
    });
  }

  #draw() {
    this.#drawn_ms = performance.now();
    this.#plot.draw();
    this.#histogram.draw();
    const mean = figure(this.#histogram.mean_ms);
    byId("mean").textContent = mean === "–" ? "" : `mean ${mean} ms`;
    const [y, u] = [byId("y").textContent, byId("u").textContent];
    byId("plot").ariaLabel = `Plot against time; y is now ${y}, u ${u}.`;
    byId("histogram").ariaLabel = `Histogram of the times between sends; mean ${mean} ms.`;
  }
}

/** A number in four figures or so, as it is read at a glance. */
function figure(value) {
  if (!Number.isFinite(value)) {
    return "–";
  }
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) {
    return value.toExponential(1).replaceAll("-", "−");
  }
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 3 : 4;
  return value.toFixed(digits).replace("-", "−");
}

/** A count with narrow spaces between thousands. */
function grouped(count) {
  return String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** @returns {any} an element, of the kind that the page has there */
function byId(id) {
  return document.getElementById(id);
}
