// The controller's end: a deadline every h, a command at each if it may.
//
// A port of services/endpoint/src/controller.rs, checked with its vectors. `poll` is asked for
// the next step until it says to wait; `answered` and `lost` tell how a message ended. Each
// deadline becomes exactly one row. Times are whole nanoseconds since the run's epoch. `fired`
// is the page's own: setInterval as the schedule. Sockets, timers and clocks are not here.

import { first } from "./message.js";

/** The technical limit on messages under way, and what `unlimited` stands for. */
export const OUTSTANDING_CAP = 8192;

/** The controller's end of the loop. */
export class ControllerEnd {
  #settings;
  #law;
  /** When r changes, after the first deadline, and to what; the place of the newest change. */
  #reference;
  #place = 0;
  #start_ns;
  #limit;
  #stop_ns;
  /** The newest output known, or both, and the answer that brought it. */
  #y;
  #newest = null;
  /** When the command before was sent, for `integrate=elapsed`. */
  #lastSend_ns = null;
  /** When setInterval fired last. */
  #lastFired_ns = null;
  #nextSeq = 0;
  /** `null` while a relative schedule waits for an answer. */
  #nextDue_ns;
  /** Rows by seq; a Map keeps them in the order of sending. */
  #underWay = new Map();

  /** What became of the deadlines so far. */
  counts = { due: 0, sent: 0, missed: 0, answered: 0, timeout: 0, failed: 0 };

  /**
   * An end whose first deadline is `start_ns` and whose last is before `stop_ns`. `y` is the
   * plant's output before the first answer, or both: laws get both, rows have the first. The
   * settings are those of setting.js. `reference` has the changes of r, pairs of ns after the
   * first deadline and r; without it r rests.
   */
  constructor(settings, law, y, start_ns, stop_ns, reference = null) {
    this.#settings = settings;
    this.#reference = reference ?? [[0, settings.r]];
    this.#start_ns = start_ns;
    this.#law = law;
    this.#limit =
      settings.outstanding === "unlimited" ? OUTSTANDING_CAP : settings.outstanding;
    this.#y = y;
    this.#nextDue_ns = start_ns;
    this.#stop_ns = stop_ns;
  }

  /** The next deadline, `null` while it waits for an answer. */
  get nextDue_ns() {
    return this.#nextDue_ns;
  }

  /** How many messages are under way. */
  get underWay() {
    return this.#underWay.size;
  }

  /** The row of the oldest message under way, if any. */
  get oldest() {
    return this.#underWay.values().next().value;
  }

  /** The newest output known, of two the first. */
  get y() {
    return first(this.#y);
  }

  /** The next step at `now_ns`. One call passes at most one deadline. */
  poll(now_ns) {
    const due_ns = this.#nextDue_ns;
    if (due_ns === null) {
      return { step: "await-answer" };
    }
    if (due_ns >= this.#stop_ns) {
      return { step: "finished" };
    }
    if (now_ns < due_ns) {
      return { step: "sleep", until_ns: due_ns };
    }
    const { h_ns, schedule } = this.#settings;
    const full = this.#underWay.size >= this.#limit;
    if (full && schedule === "since-send") {
      return { step: "await-answer" };
    }
    const seq = this.#nextSeq;
    this.#nextSeq += 1;
    this.counts.due += 1;

    let over = false;
    if (schedule === "absolute") {
      this.#nextDue_ns = due_ns + h_ns;
      over = now_ns >= this.#nextDue_ns;
    } else {
      const waits = this.#limit === 1 && schedule === "relative";
      this.#nextDue_ns = waits ? null : now_ns + h_ns;
    }
    if (over || full) {
      this.counts.missed += 1;
      return { step: "missed", row: this.#row(seq, due_ns) };
    }
    this.counts.sent += 1;
    return { step: "send", command: this.#send(seq, due_ns, now_ns) };
  }

  /**
   * The step at a firing of setInterval, each of which is a deadline: due h after the firing
   * before, or now if it came sooner. With a message under way that may not be joined it is
   * missed.
   */
  fired(now_ns) {
    const { h_ns } = this.#settings;
    const due_ns =
      this.#lastFired_ns === null ? this.#nextDue_ns : this.#lastFired_ns + h_ns;
    this.#nextDue_ns = Math.min(due_ns, now_ns);
    this.#lastFired_ns = now_ns;
    return this.poll(now_ns);
  }

  /** A message was answered. `null` if it is not under way (any more). */
  answered(answer, now_ns) {
    const row = this.#end(answer.seq, now_ns);
    if (row === null) {
      return null;
    }
    this.counts.answered += 1;
    row.t_receive_ns = now_ns;
    row.t_arrive_ns = answer.t_arrive_ns;
    row.outcome = "answered";
    if (answer.tick !== undefined) {
      row.tick = answer.tick;
      // The plant's tick, not seq, is the age of a measurement: a command that was overtaken
      // on its way up brings home the newer output.
      const overtaken = this.#newest !== null && answer.tick < this.#newest.told.tick;
      if (!(overtaken && this.#settings.late === "drop")) {
        this.#y = answer.y;
        const { tick, u } = answer;
        this.#newest = { seq: answer.seq, told: { tick, u, send_ns: row.t_send_ns } };
      }
    }
    return row;
  }

  /** A message ended without a valid answer, `timeout` or `failed`. */
  lost(seq, loss, now_ns) {
    const row = this.#end(seq, now_ns);
    if (row === null) {
      return null;
    }
    this.counts[loss] += 1;
    row.outcome = loss;
    return row;
  }

  /** The command for a deadline: from the newest output known right now. */
  #send(seq, due_ns, now_ns) {
    const { mode, h_ns, integrate } = this.#settings;
    const row = this.#row(seq, due_ns);
    const { r } = row;
    // In open loop the plant does not apply it; the reference is as good as any.
    let u = r;
    if (mode === "closed") {
      row.y = this.y;
      row.e = r - row.y;
      const elapsed = integrate === "elapsed" && this.#lastSend_ns !== null;
      const dt_ns = elapsed ? Math.max(now_ns - this.#lastSend_ns, 0) : h_ns;
      row.y_seq = this.#newest?.seq ?? null;
      const times = { send_ns: now_ns, told: this.#newest?.told ?? null };
      u = this.#law.update(r, this.#y, dt_ns / 1e9, times);
    }
    row.t_send_ns = now_ns;
    row.u = first(u);
    this.#lastSend_ns = now_ns;
    this.#underWay.set(seq, row);
    return { seq, t_send_ns: now_ns, u };
  }

  /** Takes a message off those under way. */
  #end(seq, now_ns) {
    const row = this.#underWay.get(seq);
    if (row === undefined) {
      return null;
    }
    this.#underWay.delete(seq);
    // Only a relative schedule with one outstanding waits for this.
    this.#nextDue_ns ??= now_ns + this.#settings.h_ns;
    return row;
  }

  /** The reference at a deadline, which is no earlier than those before. */
  #r(due_ns) {
    const changes = this.#reference;
    const passed_ns = due_ns - this.#start_ns;
    while (this.#place + 1 < changes.length && changes[this.#place + 1][0] <= passed_ns) {
      this.#place += 1;
    }
    return changes[this.#place][1];
  }

  /** The row of a deadline before anything is known of it. */
  #row(seq, t_due_ns) {
    return {
      seq,
      t_due_ns,
      t_send_ns: null,
      t_receive_ns: null,
      t_arrive_ns: null,
      r: this.#r(t_due_ns),
      y: null,
      e: null,
      u: null,
      tick: null,
      outcome: "missed",
      y_seq: null,
    };
  }
}
