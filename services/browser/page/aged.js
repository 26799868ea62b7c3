// State feedback whose Kalman filter knows how old each output is.
//
// A port of services/control/src/law/aged.rs and filter.rs, which say what it does and why. An
// answer names the tick of its outputs and the inputs held from the next one on; an update steps
// the filter tick by tick to the newest output, and predicts ahead to the tick at which its
// command acts.

import { numbersOf } from "./message.js";
import { dot } from "./model.js";

/** Most ticks that are stepped at once; of more, the first are left out. */
const MOST_TICKS = 1000;
/** Most commands whose effect is not known yet. */
const MOST_SENT = 1000;

/** A running law, at rest when new. */
export class AgedFeedback {
  #model;
  #commands;
  #noise;
  #h_ns;
  /** The state before the tick after the newest answer's, and its covariance. */
  #state;
  #covariance;
  /** The newest answer that the filter has taken, or what stands for none. */
  #newest = null;
  /** What was sent that is not known to be held, the oldest first. */
  #sent = [];
  #output;

  /** For a model that is sampled every `h_ns`, whose noise fits it. */
  constructor({ model, commands, noise, h_ns }) {
    this.#model = model;
    this.#commands = commands;
    this.#noise = noise;
    this.#h_ns = h_ns;
    this.#state = model.a.map(() => 0);
    this.#covariance = noise.covariance;
    this.#output = commands.rest;
  }

  /**
   * The command, sent at `send_ns`; `told` came with the outputs y. What is not a number, and who
   * measures no time, changes nothing and repeats the last one.
   */
  update(r, y, _dt_s, times = null) {
    const outputs = numbersOf(y);
    const inputs = this.#model.b[0].length;
    const isValid = (values, count) => values.length === count && values.every(Number.isFinite);
    if (times === null || !Number.isFinite(r) || !isValid(outputs, this.#model.c.length)) {
      return this.#output;
    }
    const { send_ns, told } = times;
    if (told !== null && !isValid(numbersOf(told.u), inputs)) {
      return this.#output;
    }
    this.#newest ??= {
      tick: -1,
      u: new Array(inputs).fill(0),
      send_ns: send_ns - this.#h_ns,
      isNone: true,
    };
    if (told !== null && !this.#take(outputs, told)) {
      return this.#output;
    }
    const u = this.#commands.at(r, this.#predicted(send_ns));
    if (!u.every(Number.isFinite)) {
      return this.#output;
    }
    if (this.#sent.length === MOST_SENT) {
      this.#sent.shift();
    }
    this.#sent.push({ send_ns, u });
    this.#output = u.length === 1 ? u[0] : u;
    return this.#output;
  }

  /** Steps the filter to an answer. False, and nothing is changed, if a number overflows. */
  #take(outputs, told) {
    let newest = this.#newest;
    if (newest.isNone) {
      // The first command came to the plant so long before the one that is answered.
      newest = { ...newest, tick: told.tick - this.#ticks(told.send_ns - newest.send_ns) };
    }
    if (told.tick < newest.tick || told.send_ns < newest.send_ns) {
      return true;
    }
    let known = { x: this.#state, p: this.#covariance };
    const held = this.#held(newest, told.send_ns);
    const first = Math.max(told.tick - (MOST_TICKS - 1), newest.tick + 1);
    for (let k = first; k <= told.tick; k += 1) {
      known = this.#tick(known, held(k), k === told.tick ? outputs : null);
    }
    if (!known.x.every(Number.isFinite) || !known.p.every((row) => row.every(Number.isFinite))) {
      return false;
    }
    this.#state = known.x;
    this.#covariance = known.p;
    this.#sent = this.#sent.filter((command) => command.send_ns > told.send_ns);
    const { tick, send_ns } = told;
    this.#newest = { tick, u: numbersOf(told.u), send_ns, isNone: false };
    return true;
  }

  /** The state before the tick at which a command of now acts. */
  #predicted(send_ns) {
    const newest = this.#newest;
    const acts = this.#acts(newest, send_ns);
    const held = this.#held(newest, send_ns);
    let x = this.#state;
    for (let k = Math.max(newest.tick + 1, acts - MOST_TICKS); k < acts; k += 1) {
      x = this.#step(x, held(k));
    }
    return x;
  }

  /**
   * The inputs of a tick, which is no earlier than that of the last call, by what the plant holds
   * from the newest answer on; commands from `until_ns` on are not of interest.
   */
  #held(newest, until_ns) {
    let next = 0;
    let { u } = newest;
    return (tick) => {
      while (next < this.#sent.length) {
        const command = this.#sent[next];
        if (command.send_ns >= until_ns || this.#acts(newest, command.send_ns) > tick) {
          break;
        }
        u = command.u;
        next += 1;
      }
      return u;
    };
  }

  /** The first tick with a command that was sent then. */
  #acts(newest, send_ns) {
    return newest.tick + this.#ticks(send_ns - newest.send_ns) + 1;
  }

  /** The whole ticks nearest to a time. */
  #ticks(ns) {
    return Math.floor((Math.max(ns, 0) + Math.floor(this.#h_ns / 2)) / this.#h_ns);
  }

  /** The next state. */
  #step(x, u) {
    const { a, b } = this.#model;
    return a.map((row, i) => dot(b[i], u, dot(row, x)));
  }

  /** A tick with inputs u, whose outputs were seen or are `null`: next state and covariance. */
  #tick({ x, p }, u, seen) {
    const { a, c, d } = this.#model;
    const { drift, cross, output } = this.#noise;
    // The covariance is symmetric: its columns are its rows.
    const ahead = a.map((row) => p.map((column) => dot(row, column)));
    let after = this.#step(x, u);
    let gain = null;
    let reach = null;
    if (seen !== null) {
      reach = ahead.map((row, i) => c.map((ofC, k) => dot(ofC, row, cross[i][k])));
      const scale = c.map((ofC, k) => c.map((other, l) => added(output[k][l], ofC, other, p)));
      gain = gains(reach, scale);
      const error = seen.map((y, k) => y - dot(d[k], u, dot(c[k], x)));
      after = after.map((was, i) => dot(gain[i], error, was));
      if (gain.every((row) => row.every((one) => one === 0))) {
        gain = null;
      }
    }
    const spread = p.map((row) => [...row]);
    for (let i = 0; i < a.length; i += 1) {
      for (let j = i; j < a.length; j += 1) {
        let entry = dot(ahead[i], a[j], drift[i][j]);
        if (gain !== null) {
          entry -= dot(gain[i], reach[j]);
        }
        spread[i][j] = entry;
        spread[j][i] = entry;
      }
    }
    return { x: after, p: spread };
  }
}

/** left P right, added to `sum`. */
function added(sum, left, right, p) {
  return p.reduce((total, row, j) => total + dot(left, row) * right[j], sum);
}

/** reach times the inverse of scale, which is 1 by 1 or 2 by 2. */
function gains(reach, scale) {
  if (scale.length === 1) {
    return reach.map(([w]) => [w / scale[0][0]]);
  }
  const [[s00, s01], [s10, s11]] = scale;
  const det = s00 * s11 - s01 * s10;
  return reach.map(([w0, w1]) => [(w0 * s11 - w1 * s10) / det, (w1 * s00 - w0 * s01) / det]);
}
