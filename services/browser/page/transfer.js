// A transfer function as the control law: a sampled model with input e, output u.
//
// It is sampled once, beforehand: a step a message, however long the last is ago.

import { first } from "./message.js";
import { clip } from "./pid.js";

/** A running law, at rest when new. */
export class Transfer {
  #model;
  #limits;
  #x;
  #next;
  #output = 0;

  constructor(model, limits) {
    this.#model = model;
    this.#limits = limits;
    this.#x = model.atRest();
    this.#next = model.atRest();
  }

  /**
   * The command for the first of the outputs; what is not a number changes nothing and repeats
   * the last one.
   */
  update(r, outputs) {
    const y = first(outputs);
    if (!Number.isFinite(r) || !Number.isFinite(y)) {
      return this.#output;
    }
    const u = clip(this.#model.step(this.#x, r - y, this.#next), this.#limits);
    if (Number.isFinite(u) && this.#next.every(Number.isFinite)) {
      [this.#x, this.#next] = [this.#next, this.#x];
      this.#output = u;
    }
    return this.#output;
  }
}
