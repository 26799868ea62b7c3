// A Smith predictor: a PID that sees what its command will do before the link shows it.
//
// A model of the plant runs with the command. Its output now, less its output of so many updates
// ago, which the measured y already tells of, is taken off the error.

import { first } from "./message.js";

/** A running law, at rest when new. */
export class Smith {
  #pid;
  #model;
  #x;
  #next;
  /** The model's last output, and those before it, the oldest at `#oldest`. */
  #fresh = 0;
  #line;
  #oldest = 0;
  #output = 0;

  /** `ticks` is the round trip that is expected, in updates. */
  constructor(pid, model, ticks) {
    this.#pid = pid;
    this.#model = model;
    this.#x = model.atRest();
    this.#next = model.atRest();
    this.#line = new Float64Array(ticks);
  }

  /**
   * The command for the first of the outputs, `dt_s` after the one before. What is not a number
   * repeats the last one; a model that would not stay finite stands still.
   */
  update(r, outputs, dt_s) {
    const y = first(outputs);
    if (!Number.isFinite(r) || !Number.isFinite(y)) {
      return this.#output;
    }
    const fresh = this.#fresh;
    const old = this.#line.length === 0 ? fresh : this.#line[this.#oldest];
    // An error is a reference against an output of 0, to the bit.
    this.#output = this.#pid.update(r - y - (fresh - old), 0, dt_s);
    const next = this.#model.step(this.#x, this.#output, this.#next);
    if (Number.isFinite(next) && this.#next.every(Number.isFinite)) {
      [this.#x, this.#next] = [this.#next, this.#x];
      this.#fresh = next;
      this.#push(fresh);
    }
    return this.#output;
  }

  /** The newest takes the place that the oldest leaves. */
  #push(value) {
    if (this.#line.length > 0) {
      this.#line[this.#oldest] = value;
      this.#oldest = (this.#oldest + 1) % this.#line.length;
    }
  }
}
