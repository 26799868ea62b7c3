// State feedback with an observer: the law knows the plant and the round trip.
//
// The observer runs a model of the plant with the command, and a line of its outputs as long as
// the round trip. The newest y is held against the line's end, where the output is that y tells
// of, and corrects the state and the line. The plant may have two inputs or two outputs.

import { numbersOf } from "./message.js";
import { dot } from "./model.js";
import { clip } from "./pid.js";

/** What turns states into commands: u = reference r - gains x. */
export class Commands {
  #gains;
  #reference;
  #others;
  #limits;
  /** The command of a law at rest. */
  rest;

  /**
   * For a model with n states and m inputs `gains` is m by n. `reference` has a row for each
   * input: the factor of r, and of each of `others`, the references of the outputs after the
   * first.
   */
  constructor({ gains, reference, others, limits }) {
    this.#gains = gains;
    this.#reference = reference.map(([factor, ...factors]) => ({ factor, factors }));
    this.#others = others;
    this.#limits = limits;
    this.rest = gains.length === 1 ? 0 : [0, 0];
  }

  /** The command for each input at the state x. */
  at(r, x) {
    return this.#reference.map(({ factor, factors }, j) => {
      const wanted = dot(factors, this.#others, factor * r) - dot(this.#gains[j], x);
      return clip(wanted, this.#limits);
    });
  }
}

/** A running law, at rest when new. */
export class StateFeedback {
  #model;
  #commands;
  #observer;
  /** The model's states, then its outputs on their way here, the newest first. */
  #state;
  #output;

  /**
   * For a model with n states and p outputs, its a, b, c and d as rows, `observer` has a row for
   * each state, then p for each tick that an output is on its way, at least one; p numbers a row.
   */
  constructor({ model, commands, observer }) {
    this.#model = model;
    this.#commands = commands;
    this.#observer = observer;
    this.#state = observer.map(() => 0);
    this.#output = commands.rest;
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
    const u = this.#commands.at(r, x);
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
