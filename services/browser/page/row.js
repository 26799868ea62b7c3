// A row of messages.csv as a line, as services/endpoint/src/row.rs has its columns.
//
// An empty field means that there was nothing to record. Who keeps the lines is not here.

import { decimal } from "./message.js";

/** The columns of messages.csv, in order. */
export const COLUMNS =
  "seq,t_due_ns,t_send_ns,t_receive_ns,t_arrive_ns,r,y,e,u,tick,outcome,y_seq";

/** The line of a row, with its end; times in the row count from `epoch_ns`. */
export function rowLine(row, epoch_ns) {
  const time = (t_ns) => (t_ns === null ? "" : epoch_ns + BigInt(t_ns));
  const number = (value) => (value === null ? "" : decimal(value));
  return (
    `${row.seq},${time(row.t_due_ns)},${time(row.t_send_ns)},${time(row.t_receive_ns)},` +
    `${time(row.t_arrive_ns)},${number(row.r)},${number(row.y)},${number(row.e)},` +
    `${number(row.u)},${row.tick ?? ""},${row.outcome},${row.y_seq ?? ""}\n`
  );
}
