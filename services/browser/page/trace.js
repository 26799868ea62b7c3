// A quantity over a run in a fixed number of columns, each with its first, last, least and most.
//
// So a run of ten minutes costs as little to draw as one of ten seconds, and no peak is lost.

/** Columns over the whole duration: about one a pixel. */
const COLUMNS = 900;

/** The columns of one quantity. */
export class Trace {
  #duration_s;
  #columns = new Array(COLUMNS).fill(null);
  /** The least and the most of all values. */
  least = Infinity;
  most = -Infinity;

  constructor(duration_s) {
    this.#duration_s = duration_s;
  }

  /** A value at a time; what is not a finite number is left out. */
  add(t_s, value) {
    if (!Number.isFinite(value)) {
      return;
    }
    this.least = Math.min(this.least, value);
    this.most = Math.max(this.most, value);
    const share = Math.min(Math.max(t_s / this.#duration_s, 0), 1);
    const index = Math.min(Math.floor(share * COLUMNS), COLUMNS - 1);
    const column = this.#columns[index];
    if (column === null) {
      this.#columns[index] = { first: value, last: value, least: value, most: value };
    } else {
      column.last = value;
      column.least = Math.min(column.least, value);
      column.most = Math.max(column.most, value);
    }
  }

  /** Calls `draw` with each column's place from 0 to 1 and its values. */
  each(draw) {
    this.#columns.forEach((column, index) => {
      if (column !== null) {
        draw((index + 0.5) / COLUMNS, column);
      }
    });
  }
}
