// State feedback with an observer: the law knows the plant and the round trip.
//
// The observer runs a model of the plant with the command, and a line of its outputs as long as
// the round trip. The newest y is held against the line's end, where the output is that y tells
// of, and corrects the state and the line. The plant may have two inputs or two outputs.

import { numbersOf } from "./message.js";
import { dot } from "./model.js";
import { clip } from "./pid.js";

/** A running law, at rest when new. */
export class StateFeedback {
  #model;
  #gains;
  #observer;
  #reference;
  #others;
  #limits;
  /** The model's states, then its outputs on their way here, the newest first. */
  #state;
  #output;

  /**
   * For a model with n states, m inputs and p outputs, its a, b, c and d as rows, `gains` is m by
   * n. `observer` has a row for each state, then p for each tick that an output is on its way, at
   * least one; p numbers a row. `reference` has a row for each input: the factor of r, and of each
   * of `others`, the references of the outputs after the first.
   */
  constructor({ model, gains, observer, reference, others, limits }) {
    this.#model = model;
    this.#gains = gains;
    this.#observer = observer;
    this.#reference = reference.map(([factor, ...factors]) => ({ factor, factors }));
    this.#others = others;
    this.#limits = limits;
    this.#state = observer.map(() => 0);
    this.#output = gains.length === 1 ? 0 : [0, 0];
  }

  /**
   * The command. What is not a number changes nothing and repeats the last one, and so do more or
   * fewer outputs than the model's.
   */
  update(r, y) {
    const { a, b, c, d } = this.#model;
    const outputs = numbersOf(y);
    if (outputs.length !== c.length || ![r, ...outputs].every(Number.isFinite)) {
      return this.#output;
    }
    const oldest = this.#state.length - c.length;
    const errors = outputs.map((output, k) => output - this.#state[oldest + k]);
    const state = this.#state.map((was, i) => dot(this.#observer[i], errors, was));
    const x = state.slice(0, a.length);
    const u = this.#reference.map(({ factor, factors }, j) => {
      const wanted = dot(factors, this.#others, factor * r) - dot(this.#gains[j], x);
      return clip(wanted, this.#limits);
    });
    const ahead = [
      ...a.map((row, i) => dot(b[i], u, dot(row, x))),
      ...c.map((row, k) => dot(d[k], u, dot(row, x))),
      ...state.slice(a.length),
    ];
    if (u.every(Number.isFinite) && ahead.every(Number.isFinite)) {
      // The oldest outputs have come to the line's end.
      this.#state = ahead.slice(0, -c.length);
      this.#output = u.length === 1 ? u[0] : u;
    }
    return this.#output;
  }
}
