// The run's clock, CLOCK_MONOTONIC of the plant's machine, from what a page may read.
//
// A page has performance.timeOrigin + performance.now(): the wall clock at loading, and a
// monotonic one since. `clock_ns`, the wall clock less CLOCK_MONOTONIC, is given by a launcher
// on the same machine, or else measured from the plant's answers. Each thread has a timeOrigin
// of its own, so each makes a clock of its own.

import { readState } from "./message.js";

/** How often the plant is looked at to measure the offset. */
const LOOKS = 20;

/** A clock that counts nanoseconds from an epoch, which is a BigInt of CLOCK_MONOTONIC. */
export class Clock {
  /** The epoch on CLOCK_MONOTONIC. */
  epoch_ns;
  /** From the epoch to this thread's performance.timeOrigin. */
  #origin_ns;

  constructor(clock_ns, epoch_ns) {
    this.epoch_ns = epoch_ns;
    this.#origin_ns = Number(origin_ns() - clock_ns - epoch_ns);
  }

  /** Whole nanoseconds since the epoch. */
  now_ns() {
    return Math.round(this.#origin_ns + performance.now() * 1e6);
  }

  /** When something is, in this thread's performance.now(). */
  page_ms(t_ns) {
    return (t_ns - this.#origin_ns) / 1e6;
  }
}

/** CLOCK_MONOTONIC now, as a BigInt. */
export function monotonic_ns(clock_ns) {
  return wall_ns() - clock_ns;
}

/**
 * The offset `clock_ns` from the plant's own time, by the look with the least round trip, whose
 * half is the most that it can be wrong by.
 */
export async function measureOffset() {
  let best = null;
  for (let look = 0; look < LOOKS; look += 1) {
    const before_ns = wall_ns();
    const response = await fetch("/state", { cache: "no-store" });
    const text = await response.text();
    const after_ns = wall_ns();
    if (!response.ok) {
      throw new Error(`the plant's time could not be read: ${response.status}: ${text}`);
    }
    const rtt_ns = after_ns - before_ns;
    if (best === null || rtt_ns < best.rtt_ns) {
      best = { rtt_ns, clock_ns: before_ns + rtt_ns / 2n - readState(text).t_ns };
    }
  }
  return best.clock_ns;
}

/** The wall clock at loading. A Number of ns would be wrong by up to 128 ns, of us it is exact. */
function origin_ns() {
  return BigInt(Math.round(performance.timeOrigin * 1000)) * 1000n;
}

function wall_ns() {
  return origin_ns() + BigInt(Math.round(performance.now() * 1e6));
}
