// How messages ended, told to a worker that sleeps: a ring in shared memory, and the word it sleeps on.
//
// One worker writes, another reads, in order. What finds the ring full waits at the writer's. Nothing
// here knows what a message is.

/** How many endings the ring holds. */
const SLOTS = 1024;
/** The longest text; an answer has at most 1024 characters, and one more tells that it was too long. */
const CHARS = 1026;
/** A slot, in 32-bit words: seq, what it was, the text's length, the text with two characters a word. */
const SLOT_WORDS = 3 + CHARS / 2;
/** The ring's own words before the slots: how many were written, and how many read. */
const HEAD_WORDS = 2;
const WRITTEN = 0;
const READ = 1;

/** What a message came to, as a number. */
const RESULTS = ["answered", "timeout", "failed"];

/** The word that a run sleeps on: whether it is to stop, and how often it was woken. */
const STOP = 0;
const WAKES = 1;

/** What a loop sleeps on, and what wakes it. */
export class Alarm {
  /** Shared by those who have it; goes from worker to worker. */
  memory;
  #words;

  constructor(memory = new SharedArrayBuffer(8)) {
    this.memory = memory;
    this.#words = new Int32Array(memory);
  }

  /** Whether the run is to stop. */
  get isStopped() {
    return Atomics.load(this.#words, STOP) !== 0;
  }

  /** How often it rang, to be read before looking for what it rang for. */
  get wakes() {
    return Atomics.load(this.#words, WAKES);
  }

  /** Sleeps for `most_ms`, or until it rings; not at all if it rang since `wakes` was read. */
  sleep(most_ms, wakes) {
    Atomics.wait(this.#words, WAKES, wakes, most_ms);
  }

  /** Wakes who sleeps. */
  ring() {
    Atomics.add(this.#words, WAKES, 1);
    Atomics.notify(this.#words, WAKES);
  }

  /** Ends the run. */
  stop() {
    Atomics.store(this.#words, STOP, 1);
    this.ring();
  }
}

/** The ring, as either of its two workers has it. */
export class Ring {
  memory;
  #words;
  #chars;

  constructor(memory = new SharedArrayBuffer(4 * (HEAD_WORDS + SLOTS * SLOT_WORDS))) {
    this.memory = memory;
    this.#words = new Int32Array(memory);
    this.#chars = new Uint16Array(memory);
  }

  /** Writes how a message ended; `false` if there is no room. */
  write(seq, { loss = "answered", text, why = "" }) {
    const words = this.#words;
    const written = words[WRITTEN];
    if (((written - Atomics.load(words, READ)) | 0) >= SLOTS) {
      return false;
    }
    const slot = place(written);
    const told = (text ?? why).slice(0, CHARS);
    words[slot] = seq;
    words[slot + 1] = RESULTS.indexOf(loss);
    words[slot + 2] = told.length;
    for (let index = 0, at = 2 * (slot + 3); index < told.length; index += 1) {
      this.#chars[at + index] = told.charCodeAt(index);
    }
    Atomics.store(words, WRITTEN, (written + 1) | 0);
    return true;
  }

  /** The next ending, or `null`. */
  read() {
    const words = this.#words;
    const read = words[READ];
    if (Atomics.load(words, WRITTEN) === read) {
      return null;
    }
    const slot = place(read);
    const at = 2 * (slot + 3);
    const told = String.fromCharCode(...this.#chars.subarray(at, at + words[slot + 2]));
    const loss = RESULTS[words[slot + 1]];
    const seq = words[slot];
    Atomics.store(words, READ, (read + 1) | 0);
    return { seq, result: loss === "answered" ? { text: told } : { loss, why: told } };
  }
}

function place(count) {
  return HEAD_WORDS + (count >>> 0) % SLOTS * SLOT_WORDS;
}
