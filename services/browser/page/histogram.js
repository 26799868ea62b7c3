// The histogram of control intervals, the times between two sends, with h marked.
//
// It counts in fine bins up to 64 h and draws as many together as show 99.5 % of all.

import { MARGIN, line, sheet, tickText, ticks } from "./canvas.js";

const BINS_PER_H = 32;
const RANGE_H = 64;
/** Bars of a drawing: its range is 2, 4, ... 64 h. */
const BARS = 64;
const SHOWN_SHARE = 0.995;

/** The histogram on a canvas. */
export class Histogram {
  #canvas;
  #h_s = 0.003;
  #known = false;
  #bins = new Uint32Array(BINS_PER_H * RANGE_H + 1);
  #count = 0;
  #sum_s = 0;
  #lastSend_s = null;

  constructor(canvas) {
    this.#canvas = canvas;
    this.draw();
  }

  /** The mean interval in milliseconds. */
  get mean_ms() {
    return this.#count === 0 ? NaN : (this.#sum_s / this.#count) * 1e3;
  }

  /** Empties it for a run. */
  begin({ h_ns }) {
    this.#h_s = h_ns / 1e9;
    this.#known = true;
    this.#bins.fill(0);
    this.#count = 0;
    this.#sum_s = 0;
    this.#lastSend_s = null;
    this.draw();
  }

  /** Takes in what record.js tells. */
  add({ sends }) {
    for (let at = 0; at < sends.length; at += 3) {
      if (this.#lastSend_s !== null) {
        const interval_s = sends[at] - this.#lastSend_s;
        // An interval of h lies in the middle of its bin.
        const bin = Math.floor((interval_s / this.#h_s) * BINS_PER_H + 0.5);
        this.#bins[Math.min(bin, this.#bins.length - 1)] += 1;
        this.#count += 1;
        this.#sum_s += interval_s;
      }
      this.#lastSend_s = sends[at];
    }
  }

  draw() {
    const { context, width, height, colour } = sheet(this.#canvas);
    const [left, right] = [MARGIN.left, width - MARGIN.right];
    const [top, bottom] = [MARGIN.top + 12, height - MARGIN.bottom];
    const range_h = this.#range();
    const bars = this.#bars(range_h);
    const most = Math.max(...bars, 1);
    const range_ms = range_h * this.#h_s * 1e3;
    const place = (ms) => left + (ms / range_ms) * (right - left);

    const h_x = Math.round(place(this.#h_s * 1e3)) + 0.5;
    context.lineWidth = 1;
    context.strokeStyle = colour("faint");
    context.setLineDash([5, 4]);
    line(context, h_x, top - 4, h_x, bottom);
    context.setLineDash([]);
    context.fillStyle = colour("faint");
    context.textAlign = "center";
    context.fillText("h", h_x, top - 12);

    context.fillStyle = colour("u");
    const wide = (right - left) / BARS;
    bars.forEach((count, index) => {
      const high = (count / most) * (bottom - top);
      if (count > 0) {
        // Seen, however few.
        const shown = Math.max(high, 1.5);
        const x = left + (index - 0.5) * wide;
        context.fillRect(Math.max(x, left) + 0.5, bottom - shown, wide - 1, shown);
      }
    });

    context.fillStyle = colour("faint");
    context.strokeStyle = colour("faint");
    line(context, left, bottom + 0.5, right, bottom + 0.5);
    const axis = ticks(0, range_ms, (right - left) / 80);
    for (const value of this.#known ? axis.values : []) {
      line(context, place(value), bottom, place(value), bottom + 4);
      tickText(context, axis, value, " ms", place(value), bottom + 13);
    }
    context.textAlign = "right";
    if (this.#count > 0) {
      context.fillText(String(most), left - 8, top);
    }
  }

  /** How many h are shown. */
  #range() {
    for (let range_h = 2; range_h < RANGE_H; range_h *= 2) {
      let seen = 0;
      for (let bin = 0; bin < range_h * BINS_PER_H; bin += 1) {
        seen += this.#bins[bin];
      }
      if (seen >= this.#count * SHOWN_SHARE) {
        return range_h;
      }
    }
    return RANGE_H;
  }

  /** The bins of a range, put together to bars of which one is centred on h. */
  #bars(range_h) {
    const together = (range_h * BINS_PER_H) / BARS;
    const bars = new Array(BARS).fill(0);
    const end = Math.min(range_h * BINS_PER_H, this.#bins.length);
    for (let bin = 0; bin < end; bin += 1) {
      const bar = Math.floor(bin / together + 0.5);
      bars[Math.min(bar, BARS - 1)] += this.#bins[bin];
    }
    return bars;
  }
}
