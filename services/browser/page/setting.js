// How a run is set up: the words, the query of the page's address, and what cannot be.
//
// The words are those of services/endpoint/src/setting.rs, and stand in choice.js with what they mean
// to a person. A query is read strictly: a word that is not known is refused by name, not passed over.

import { CHOICES } from "./choice.js";
import { excerpt } from "./message.js";
import { OUTSTANDING_CAP } from "./end.js";

/** Settings that no run can have. The text says which, why, and what to choose instead. */
export class InvalidSettings extends Error {}

/** The settings that are words, with their words. */
export const WORDS = Object.fromEntries(
  Object.entries(CHOICES).map(([name, [, hints]]) => [name, Object.keys(hints)]),
);

/** The usual word of each. */
const USUAL = Object.fromEntries(Object.entries(WORDS).map(([name, [first]]) => [name, first]));

/** The settings that are whole nanoseconds, from the least to the most. */
const TIMES = {
  h_ns: [10_000, 3_600_000_000_000],
  duration_ns: [1, Number.MAX_SAFE_INTEGER],
  timeout_ns: [1, Number.MAX_SAFE_INTEGER],
  floor_ns: [0, 3_600_000_000_000],
  chores_ns: [0, 100_000_000],
};

/** What a query need not say. `null` for h and late: as the plant has them. */
const DEFAULTS = {
  ...USUAL,
  h_ns: null,
  r: 1,
  duration_ns: 10_000_000_000,
  late: null,
  timeout_ns: 5_000_000_000,
  outstanding: 1,
  floor_ns: 0,
  chores_ns: 0,
};

// A preset says nothing of the loop, nor of what an overtaken answer is worth.
const { mode: _mode, late: _late, ...usual } = USUAL;
const blocking = { ...usual, outstanding: 1, floor_ns: 0, chores_ns: 0 };
const today = { ...blocking, schedule: "since-send", thread: "main", timer: "timeout" };
// A page that is not isolated has no shared memory to sleep on.
const timer = globalThis.crossOriginIsolated === true ? "wait" : "channel";
const unlimited = { ...blocking, outstanding: "unlimited", sender: "fetch", timer };

/** The clients with a name, as services/endpoint has them; `blocking` is `worker` in a page. */
export const PRESETS = {
  worker: blocking,
  "paper-2011": { ...today, floor_ns: 10_000_000 },
  today,
  "paper-python": unlimited,
  socket: { ...unlimited, transport: "websocket" },
};

/**
 * The settings that the query of an address asks for. `start_ns` and `clock_ns` are BigInts or
 * `null`, `run` is whether to start at once. What cannot be together is left to `check`.
 */
export function readSettings(query) {
  const given = {};
  for (const [name, word] of new URLSearchParams(query)) {
    if (!(name in READERS)) {
      throw new InvalidSettings(
        `setting \`${excerpt(name)}\` is unknown; there are ${Object.keys(READERS).join(", ")}`,
      );
    }
    if (name in given) {
      throw new InvalidSettings(`setting \`${name}\` appears twice: give it once`);
    }
    given[name] = READERS[name](word);
  }
  // A browser keeps its connections: that setting is only checked.
  const { run = false, start_ns = null, clock_ns = null, connection: _, ...chosen } = given;
  return { run, start_ns, clock_ns, settings: { ...DEFAULTS, ...chosen } };
}

/** Refuses settings that no page, or not this page, can run with. */
export function check(settings, page = { isolated: globalThis.crossOriginIsolated }) {
  const { transport, thread, sender, timer, schedule, outstanding } = settings;
  const http = transport === "http";
  if (timer === "wait" && thread === "main") {
    refuse("timer `wait` blocks its thread, which a page's main thread may not", "thread `worker`");
  }
  if (timer === "wait" && !page.isolated) {
    refuse(
      "timer `wait` needs a SharedArrayBuffer, which this page lacks: it is not cross-origin " +
        "isolated (over plain http a browser isolates only localhost, unless it is told to " +
        "trust the address)",
      "timer `channel`",
    );
  }
  if (timer === "interval" && schedule !== "relative") {
    refuse(
      `timer \`interval\` is a schedule of its own, so there is no ${schedule} one`,
      "schedule `relative`",
    );
  }
  if (http && sender === "xhr" && outstanding !== 1) {
    refuse(
      `sender \`xhr\` blocks until the answer, so ${outstanding} cannot be outstanding`,
      "outstanding 1, or sender `fetch`",
    );
  }
}

function refuse(why, instead) {
  throw new InvalidSettings(`${why}; choose ${instead}`);
}

/** How each setting's word is read. */
const READERS = {
  run: (word) => {
    if (word !== "1") {
      throw new InvalidSettings(
        `run \`${excerpt(word)}\` is unknown; write run=1 to start at once`,
      );
    }
    return true;
  },
  ...map(WORDS, (name, words) => (word) => {
    if (!words.includes(word)) {
      throw new InvalidSettings(
        `${name} \`${excerpt(word)}\` is unknown; choose ${words.join(" or ")}`,
      );
    }
    return word;
  }),
  ...map(TIMES, (name, [least, most]) => (word) => {
    const ns = /^\d+$/.test(word) ? Number(word) : NaN;
    if (!(ns >= least && ns <= most)) {
      throw new InvalidSettings(
        `${name} \`${excerpt(word)}\` is not a whole number of nanoseconds ` +
          `from ${least} to ${most}`,
      );
    }
    return ns;
  }),
  r: (word) => {
    const r = word.trim() === "" ? NaN : Number(word);
    if (!Number.isFinite(r)) {
      throw new InvalidSettings(
        `reference r = \`${excerpt(word)}\` is not a finite number; the paper's is 1`,
      );
    }
    return r;
  },
  outstanding: (word) => {
    if (word === "unlimited") {
      return word;
    }
    const n = /^\d+$/.test(word) ? Number(word) : NaN;
    if (!(n >= 1 && n <= OUTSTANDING_CAP)) {
      throw new InvalidSettings(
        `outstanding is \`${excerpt(word)}\`; ` +
          `give 1 to ${OUTSTANDING_CAP}, or \`unlimited\``,
      );
    }
    return n;
  },
  connection: (word) => {
    if (word !== "keep") {
      throw new InvalidSettings(
        `connection \`${excerpt(word)}\`: ` +
          "a browser keeps its connections; choose keep",
      );
    }
    return word;
  },
  start_ns: instant("start_ns"),
  clock_ns: instant("clock_ns"),
};

function instant(name) {
  return (word) => {
    if (!/^\d{1,20}$/.test(word)) {
      throw new InvalidSettings(
        `${name} \`${excerpt(word)}\` is not a whole number of nanoseconds`,
      );
    }
    return BigInt(word);
  };
}

function map(table, reader) {
  return Object.fromEntries(
    Object.entries(table).map(([name, values]) => [name, reader(name, values)]),
  );
}
