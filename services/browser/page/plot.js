// The live plot: y with r and u below it in closed loop, the round trip in open loop.
//
// Time runs over the whole duration from the start. Values are decimated in trace.js.

import { MARGIN, line, sheet, tickText, ticks } from "./canvas.js";
import { Trace } from "./trace.js";

/** Between two panels. */
const GAP = 16;
/** A tick of an axis has about this much room. */
const TICK_X = 80;
const TICK_Y = 36;

/** The plot on a canvas. */
export class Plot {
  #canvas;
  #duration_s = 10;
  #panels = [];
  #lost = new Trace(10);

  constructor(canvas) {
    this.#canvas = canvas;
    this.begin({ mode: "closed", duration_ns: 1e10, r: 1 });
  }

  /** Empties the plot for a run. */
  begin({ mode, duration_ns, r }) {
    const duration_s = duration_ns / 1e9;
    this.#duration_s = duration_s;
    const panel = (name, colour, share, extra = {}) => ({
      name,
      colour,
      share,
      trace: new Trace(duration_s),
      ...extra,
    });
    this.#panels =
      mode === "closed"
        ? [panel("y", "y", 0.64, { reference: r }), panel("u", "u", 0.36)]
        : [panel("RTT ms", "y", 1)];
    this.#lost = new Trace(duration_s);
    this.draw();
  }

  /** Takes in what record.js tells. */
  add({ sends, ends }) {
    const [first, second] = this.#panels;
    for (let at = 0; second !== undefined && at < sends.length; at += 3) {
      first.trace.add(sends[at], sends[at + 1]);
      second.trace.add(sends[at], sends[at + 2]);
    }
    for (let at = 0; at < ends.length; at += 2) {
      if (Number.isNaN(ends[at + 1])) {
        this.#lost.add(ends[at], 0);
      } else if (second === undefined) {
        first.trace.add(ends[at], ends[at + 1]);
      }
    }
  }

  draw() {
    const { context, width, height, colour } = sheet(this.#canvas);
    const left = MARGIN.left;
    const right = width - MARGIN.right;
    const room = height - MARGIN.top - MARGIN.bottom - GAP * (this.#panels.length - 1);
    let top = MARGIN.top;
    for (const panel of this.#panels) {
      const bottom = top + room * panel.share;
      this.#drawPanel(context, colour, panel, { left, right, top, bottom });
      top = bottom + GAP;
    }
    this.#drawTime(context, colour, left, right, height - MARGIN.bottom);
  }

  #drawPanel(context, colour, panel, { left, right, top, bottom }) {
    const { trace, reference } = panel;
    let [least, most] = [Math.min(0, trace.least), Math.max(0, trace.most)];
    if (reference !== undefined) {
      least = Math.min(least, reference);
      most = Math.max(most, reference);
    }
    if (least === most) {
      most = least + 1;
    }
    const air = (most - least) * 0.08;
    [least, most] = [least < 0 ? least - air : least, most + air];
    const place = (value) => bottom - ((value - least) / (most - least)) * (bottom - top);

    context.lineWidth = 1;
    context.textAlign = "right";
    const axis = ticks(least, most, (bottom - top) / TICK_Y);
    for (const value of axis.values) {
      const y = Math.round(place(value)) + 0.5;
      context.strokeStyle = colour("grid");
      line(context, left, y, right, y);
      context.fillStyle = colour("faint");
      context.fillText(axis.text(value), left - 8, y);
    }
    if (reference !== undefined) {
      const y = Math.round(place(reference)) + 0.5;
      context.strokeStyle = colour("faint");
      context.setLineDash([5, 4]);
      line(context, left, y, right, y);
      context.setLineDash([]);
      context.fillStyle = colour("faint");
      context.fillText("r", right - 2, y - 9);
    }
    context.strokeStyle = colour(panel.colour);
    context.lineWidth = 1.75;
    context.lineJoin = "round";
    context.beginPath();
    trace.each((share, { first, last, least: low, most: high }) => {
      const x = left + share * (right - left);
      for (const value of [first, low, high, last]) {
        context.lineTo(x, place(value));
      }
    });
    context.stroke();
    context.textAlign = "left";
    context.fillStyle = colour(panel.colour);
    context.save();
    context.font = `600 13px ${context.font.slice(context.font.indexOf("px") + 3)}`;
    context.fillText(panel.name, 8, top + 8);
    context.restore();
  }

  #drawTime(context, colour, left, right, bottom) {
    const axis = ticks(0, this.#duration_s, (right - left) / TICK_X);
    context.textAlign = "center";
    context.fillStyle = colour("faint");
    context.strokeStyle = colour("faint");
    context.lineWidth = 1;
    line(context, left, bottom + 0.5, right, bottom + 0.5);
    for (const value of axis.values) {
      const x = left + (value / this.#duration_s) * (right - left);
      line(context, x, bottom, x, bottom + 4);
      tickText(context, axis, value, " s", x, bottom + 13);
    }
    context.strokeStyle = colour("bad");
    this.#lost.each((share) => {
      const x = left + share * (right - left);
      line(context, x, bottom - 6, x, bottom);
    });
  }
}
