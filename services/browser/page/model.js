// A sampled model as matrices: x' = A x + B u, y = C x + D u.
//
// A port of services/control/src/stepper.rs: sums run from left to right and from 0, as its do.
// The state is kept by whoever steps, who may then look at a step before it is taken.

/** A, B, C and D of a system with n states, one input and one output: n by n, n, n and a number. */
export class Model {
  #rows;
  #b;
  #c;
  #d;

  constructor({ a, b, c, d }) {
    this.#rows = a.map((row) => Float64Array.from(row));
    this.#b = Float64Array.from(b);
    this.#c = Float64Array.from(c);
    this.#d = d;
  }

  /** The state of a model that nothing has happened to. */
  atRest() {
    return new Float64Array(this.#b.length);
  }

  /** One tick from the state `x` with input `u`: gives the output, and leaves `next` the state. */
  step(x, u, next) {
    const y = dot(this.#c, x) + this.#d * u;
    for (let row = 0; row < next.length; row += 1) {
      next[row] = dot(this.#rows[row], x) + this.#b[row] * u;
    }
    return y;
  }
}

/** The sum of the products, added to `sum` one after the other. */
export function dot(left, right, sum = 0) {
  for (let at = 0; at < left.length; at += 1) {
    sum += left[at] * right[at];
  }
  return sum;
}
