// What a run tells as it goes: samples to be seen a few times a second, rows once a second.
//
// A worker that blocks can still tell. Sending rows to the plant is session.js's, drawing
// plot.js's.

import { rowLine } from "./row.js";

const PROGRESS_NS = 200_000_000;
const ROWS_NS = 1_000_000_000;

/** The rows and samples of a run, until they are told. */
export class Record {
  #epoch_ns;
  #counts;
  #tell;
  #lines = [];
  #sends = [];
  #ends = [];
  #progress_ns = 0;
  #rows_ns = 0;
  #firstSend_ns = null;
  #lastSend_ns = null;
  #sent = 0;
  #error_ns = 0;

  /** `counts` are the end's, which it goes on counting. */
  constructor(epoch_ns, counts, tell) {
    this.#epoch_ns = epoch_ns;
    this.#counts = counts;
    this.#tell = tell;
  }

  /** How far an arrival lay outside its sending and receiving, at worst. */
  get error_ms() {
    return this.#error_ns / 1e6;
  }

  /** Messages a second, from the first to the last. */
  get rate_hz() {
    const span_ns = this.#lastSend_ns - this.#firstSend_ns;
    return span_ns > 0 ? ((this.#sent - 1) / span_ns) * 1e9 : 0;
  }

  /** A message is sent: when, the first output it follows from (NaN if none), the first input. */
  sent(t_ns, y, u) {
    this.#sent += 1;
    this.#firstSend_ns ??= t_ns;
    this.#lastSend_ns = t_ns;
    this.#sends.push(t_ns / 1e9, y, u);
  }

  /** A deadline is over. */
  row(row) {
    this.#lines.push(rowLine(row, this.#epoch_ns));
    if (row.t_send_ns === null) {
      return;
    }
    let rtt_ms = NaN;
    if (row.t_receive_ns !== null) {
      rtt_ms = (row.t_receive_ns - row.t_send_ns) / 1e6;
      const early_ns = row.t_send_ns - row.t_arrive_ns;
      const late_ns = row.t_arrive_ns - row.t_receive_ns;
      this.#error_ns = Math.max(this.#error_ns, early_ns, late_ns);
    }
    this.#ends.push(row.t_send_ns / 1e9, rtt_ms);
  }

  /** Tells what is due to be told. */
  pulse(now_ns) {
    if (now_ns - this.#progress_ns >= PROGRESS_NS) {
      this.#tellProgress(now_ns);
    }
    if (now_ns - this.#rows_ns >= ROWS_NS) {
      this.#tellRows(now_ns);
    }
  }

  /** Tells the rest. */
  flush(now_ns) {
    this.#tellProgress(now_ns);
    this.#tellRows(now_ns);
  }

  #tellProgress(now_ns) {
    this.#progress_ns = now_ns;
    this.#tell({
      event: "progress",
      t_s: now_ns / 1e9,
      counts: { ...this.#counts },
      // Triples of send time in s, y and u; pairs of send time in s and RTT in ms, NaN if lost.
      sends: new Float64Array(this.#sends.splice(0)),
      ends: new Float64Array(this.#ends.splice(0)),
    });
  }

  #tellRows(now_ns) {
    this.#rows_ns = now_ns;
    if (this.#lines.length > 0) {
      const rows = this.#lines.length;
      this.#tell({ event: "rows", rows, text: this.#lines.splice(0).join("") });
    }
  }
}
