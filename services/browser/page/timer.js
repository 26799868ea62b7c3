// Waiting for a deadline: setTimeout, setInterval, a MessageChannel, or Atomics.wait.
//
// `timeout` and `channel` call back when the time has come; `interval` is a schedule of its
// own; `wait` blocks its thread. The floor is the least delay that setTimeout and setInterval
// are given. What is due when is decided in end.js.

/** A timer that fired early by less is waited out: setting another would cost the clamp. */
const SPIN_NS = 1_000_000;
/** Waits for more than this begin with a setTimeout; a channel's turns burn a processor. */
const CHANNEL_NS = 6_000_000;
/** How long before the deadline that setTimeout ends: the clamp of 4 ms, and some lateness. */
const CHANNEL_AHEAD_NS = 5_000_000;
/** The longest time that setTimeout takes: 2^31 - 1 ms. */
const LONGEST_MS = 2_147_483_647;

/** setTimeout until the deadline, in whole milliseconds rounded up as it takes no others. */
export class Timeout {
  #clock;
  #floor_ms;
  #ring;
  #id = 0;

  constructor(clock, floor_ns, ring) {
    this.#clock = clock;
    this.#floor_ms = floor_ns / 1e6;
    this.#ring = ring;
  }

  /**
   * Rings at `until_ns`, not before the floor after `from_ns`, and forgets what it was set to
   * before. Whoever sets it late, with an earlier `from_ns`, has an event loop that waits in
   * whole milliseconds from now on: as those on poll and epoll_wait did in 2011.
   */
  set(until_ns, from_ns = this.#clock.now_ns()) {
    clearTimeout(this.#id);
    const ring_ns = Math.max(until_ns, from_ns + this.#floor_ms * 1e6);
    const ahead_ms = Math.ceil((ring_ns - this.#clock.now_ns()) / 1e6);
    this.#id = setTimeout(() => {
      if (ring_ns - this.#clock.now_ns() > SPIN_NS) {
        this.set(ring_ns, from_ns);
        return;
      }
      while (this.#clock.now_ns() < ring_ns);
      this.#ring();
    }, Math.min(Math.max(ahead_ms, 0), LONGEST_MS));
  }

  clear() {
    clearTimeout(this.#id);
  }
}

/** setInterval: rings at `first_ns` and from then on every h, as the browser has it. */
export class Interval {
  #first;
  #id = 0;

  constructor(clock, h_ns, floor_ns, ring) {
    const delay_ms = Math.max(Math.ceil(h_ns / 1e6), floor_ns / 1e6);
    this.#first = new Timeout(clock, floor_ns, () => {
      this.#id = setInterval(ring, delay_ms);
      ring();
    });
  }

  start(first_ns) {
    this.#first.set(first_ns);
  }

  clear() {
    this.#first.clear();
    clearInterval(this.#id);
  }
}

/** Turns of a MessageChannel until the deadline: no clamp, but a busy thread. */
export class Channel {
  #clock;
  #floor_ms;
  #ring;
  #channel = new MessageChannel();
  #until_ns = null;
  #id = 0;
  /** Whether a message is on its way: never more than one is. */
  #turning = false;

  constructor(clock, floor_ns, ring) {
    this.#clock = clock;
    this.#floor_ms = floor_ns / 1e6;
    this.#ring = ring;
    this.#channel.port2.onmessage = () => {
      this.#turning = false;
      if (this.#until_ns === null) {
        return;
      }
      if (this.#clock.now_ns() < this.#until_ns) {
        this.#turn();
      } else {
        this.#until_ns = null;
        this.#ring();
      }
    };
  }

  /** Rings at `until_ns`, and forgets what it was set to before. */
  set(until_ns) {
    clearTimeout(this.#id);
    const ahead_ns = until_ns - this.#clock.now_ns();
    const delay_ms = Math.min((ahead_ns - CHANNEL_AHEAD_NS) / 1e6, LONGEST_MS);
    if (ahead_ns > CHANNEL_NS && delay_ms >= this.#floor_ms) {
      this.#until_ns = null;
      this.#id = setTimeout(() => this.set(until_ns), delay_ms);
    } else {
      this.#until_ns = until_ns;
      this.#turn();
    }
  }

  clear() {
    clearTimeout(this.#id);
    this.#until_ns = null;
    this.#channel.port1.close();
  }

  #turn() {
    if (!this.#turning) {
      this.#turning = true;
      this.#channel.port1.postMessage(0);
    }
  }
}

/** Atomics.wait: sleeps, and hears its alarm alone. Workers only. */
export class Wait {
  #clock;
  #alarm;

  constructor(clock, alarm) {
    this.#clock = clock;
    this.#alarm = alarm;
  }

  /** Blocks until `until_ns`, or `most_ms`, or until the alarm has rung more often than `wakes`. */
  block(until_ns, most_ms, wakes) {
    const ahead_ms = (until_ns - this.#clock.now_ns()) / 1e6;
    if (ahead_ms > 0) {
      this.#alarm.sleep(Math.min(ahead_ms, most_ms), wakes);
    }
  }
}
