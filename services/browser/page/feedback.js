// State feedback with an observer: the law knows the plant and the round trip.
//
// The observer runs a model of the plant with the command, and a line of its outputs as long as
// the round trip. The newest y is held against the line's end, where the output is that y tells
// of, and corrects the state and the line.

import { dot } from "./model.js";
import { clip } from "./pid.js";

/** A running law, at rest when new. */
export class StateFeedback {
  #model;
  #gains;
  #observer;
  #reference;
  #limits;
  #x;
  #corrected;
  #next;
  /** Outputs on their way here, the newest first, and a place for what falls off their end. */
  #line;
  #nextLine;
  #output = 0;

  /**
   * `gains` has n numbers for a model with n states, `observer` n for the state and then one for
   * each place of the line, at least one.
   */
  constructor({ model, gains, observer, reference, limits }) {
    this.#model = model;
    this.#gains = gains;
    this.#observer = observer;
    this.#reference = reference;
    this.#limits = limits;
    this.#x = model.atRest();
    this.#corrected = model.atRest();
    this.#next = model.atRest();
    this.#line = new Float64Array(observer.length - this.#x.length + 1);
    this.#nextLine = this.#line.slice();
  }

  /** The command; what is not a number changes nothing and repeats the last one. */
  update(r, y) {
    if (!Number.isFinite(r) || !Number.isFinite(y)) {
      return this.#output;
    }
    const n = this.#x.length;
    const length = this.#line.length - 1;
    const innovation = y - this.#line[length - 1];
    for (let at = 0; at < n; at += 1) {
      this.#corrected[at] = this.#x[at] + this.#observer[at] * innovation;
    }
    const wanted = this.#reference * r - dot(this.#gains, this.#corrected);
    const u = clip(wanted, this.#limits);
    this.#nextLine[0] = this.#model.step(this.#corrected, u, this.#next);
    for (let at = 0; at < length; at += 1) {
      this.#nextLine[at + 1] = this.#line[at] + this.#observer[n + at] * innovation;
    }
    const finite = this.#next.every(Number.isFinite) && this.#nextLine.every(Number.isFinite);
    if (Number.isFinite(u) && finite) {
      [this.#x, this.#next] = [this.#next, this.#x];
      [this.#line, this.#nextLine] = [this.#nextLine, this.#line];
      this.#output = u;
    }
    return this.#output;
  }
}
