// PI and PID control by backward Euler: kp + ki/s + kd N s/(s + N), and limits.
//
// A port of services/control/src/pid.rs, sum by sum in the same order, so that both give the
// same bits. What a law may be is checked in law.js.

import { first } from "./message.js";

/** A command without limits: both bounds are infinite. */
export const UNLIMITED = { min: -Infinity, max: Infinity, anti_windup: "off", gain_per_s: null };

/** The nearest value within limits; what is not a number stays that. */
export function clip(value, { min, max }) {
  return value < min ? min : value > max ? max : value;
}

/** A running controller, at rest when new. */
export class Pid {
  #kp;
  #ki;
  #kd;
  /** 1/N. */
  #lag_s;
  #limits;
  /** Whether it is a PI without limits, which pays for nothing that it does not have. */
  #plain;
  #integral = 0;
  #derivative = 0;
  #error = 0;
  #output = 0;

  /** An infinite filter is the plain difference; limits may be `null`. */
  constructor({ kp, ki, kd = 0, filter_rad_s = Infinity, limits = null }) {
    this.#kp = kp;
    this.#ki = ki;
    this.#kd = kd;
    this.#lag_s = 1 / filter_rad_s;
    this.#limits = limits ?? UNLIMITED;
    this.#plain = kd === 0 && limits === null;
  }

  /**
   * The command for the error e = r - y, `dt_s` after the one before; of two outputs y is the
   * first. What is not a number changes nothing and repeats the last command, 0 before the first.
   */
  update(r, y, dt_s) {
    const e = r - first(y);
    if (!Number.isFinite(e) || !(dt_s > 0) || !Number.isFinite(dt_s)) {
      return this.#output;
    }
    const integral = this.#integral + this.#ki * dt_s * e;
    const output = this.#kp * e + integral;
    if (!this.#plain) {
      return this.#whole(e, dt_s, integral, output);
    }
    if (Number.isFinite(integral) && Number.isFinite(output)) {
      this.#integral = integral;
      this.#output = output;
    }
    return this.#output;
  }

  /** The rest of an update, with a derivative, limits, or both. */
  #whole(e, dt_s, integral, pi) {
    const { anti_windup, gain_per_s } = this.#limits;
    const derivative = this.#kd === 0 ? 0 : this.#differentiated(e, dt_s);
    const wanted = pi + derivative;
    const output = clip(wanted, this.#limits);
    let kept = integral;
    if (anti_windup === "conditional") {
      if ((wanted - output) * this.#ki * e > 0) {
        kept = this.#integral;
      }
    } else if (anti_windup === "back-calculation") {
      const pull = gain_per_s * dt_s;
      kept += (pull / (1 + pull)) * (output - wanted);
    }
    if (Number.isFinite(kept) && Number.isFinite(derivative) && Number.isFinite(output)) {
      this.#integral = kept;
      this.#derivative = derivative;
      this.#error = e;
      this.#output = output;
    }
    return this.#output;
  }

  /** kd N s/(s + N), divided by N, so that an infinite N leaves the difference quotient. */
  #differentiated(e, dt_s) {
    const change = this.#kd * (e - this.#error);
    return (this.#lag_s * this.#derivative + change) / (this.#lag_s + dt_s);
  }
}
