// The control law: PI by backward Euler, (a0 s + a1)/s with the paper's gains.
//
// A port of services/control/src/pid.rs as `paper_pi()` sets it up: no derivative, no
// saturation. Sums are in the same order, so both give the same bits.

/** The proportional gain of the paper's controller. */
export const PAPER_A0 = 0.1701;
/** The integral gain of the paper's controller, 1/s. */
export const PAPER_A1 = 0.378;

/** A running PI controller, at rest when new. */
export class Pi {
  #kp;
  #ki;
  #integral = 0;
  #output = 0;

  constructor(kp = PAPER_A0, ki = PAPER_A1) {
    this.#kp = kp;
    this.#ki = ki;
  }

  /**
   * The command for the error `e`, `dt_s` after the one before. What is not a number leaves
   * the integrator alone and repeats the last command.
   */
  update(e, dt_s) {
    if (!Number.isFinite(e) || !(dt_s > 0) || !Number.isFinite(dt_s)) {
      return this.#output;
    }
    const integral = this.#integral + this.#ki * dt_s * e;
    const output = this.#kp * e + integral;
    if (!Number.isFinite(integral) || !Number.isFinite(output)) {
      return this.#output;
    }
    this.#integral = integral;
    this.#output = output;
    return output;
  }
}
