// The control laws against the vectors that the crate `system` writes, each command to its
// last bit, and what holds for all of them.

import { readLaw } from "./law.js";

/** What JSON has no number for is a word in the vectors. */
const WORDS = { NaN, inf: Infinity, "-inf": -Infinity };

/** The cases of laws.json. */
export function lawCases({ cases }) {
  const number = (value) => WORDS[value] ?? value;
  return cases.map(({ case: name, law, steps }) => ({
    name,
    run: () => {
      const running = readLaw(law);
      for (const [at, { r, y, dt_s, u }] of steps.entries()) {
        expect(running.update(number(r), number(y), number(dt_s)), u, `step ${at}`);
      }
    },
  }));
}

const PID = { kp: 0.1701, ki: 0.378, kd: 0, filter_rad_s: null, limits: null };
const MODEL = { a: [[0.5, 0], [1, 0.25]], b: [1, 0], c: [0, 1], d: 0 };
const LIMITS = { min: -1e9, max: null, anti_windup: "off", gain_per_s: null };

/** A law of each kind. */
export const LAWS = {
  pid: { law: "pid", ...PID },
  transfer: { law: "transfer", model: MODEL, limits: LIMITS },
  smith: { law: "smith", pid: PID, model: MODEL, ticks: 2 },
  feedback: {
    law: "state-feedback",
    model: MODEL,
    gains: [0.5, 0.25],
    observer: [0.25, 0.125, 0.5],
    reference: 1.5,
    limits: null,
  },
};

export const laws = [
  {
    name: "the paper's PI is one of the laws",
    run: () => {
      // The last takes the rest of an update, without limits that are ever met.
      const [paper, ...others] = [null, LAWS.pid, { ...LAWS.pid, limits: LIMITS }].map(readLaw);
      for (let step = 0; step < 1000; step += 1) {
        const u = paper.update(1, step / 700, 0.003);
        for (const other of others) {
          expect(other.update(1, step / 700, 0.003), u, `step ${step}`);
        }
      }
    },
  },
  ...Object.entries(LAWS).map(([name, law]) => ({
    name: `the law ${name} holds its command where r or y is not a number`,
    run: () => {
      const [held, untouched] = [readLaw(law), readLaw(law)];
      expect(held.update(1, NaN, 0.003), 0, "at rest");
      for (let step = 0; step < 5; step += 1) {
        const y = 0.125 * step;
        const u = untouched.update(1, y, 0.003);
        expect(held.update(1, y, 0.003), u, `step ${step}`);
        for (const broken of Object.values(WORDS)) {
          expect(held.update(1, broken, 0.003), u, `y ${broken}`);
          expect(held.update(broken, y, 0.003), u, `r ${broken}`);
        }
      }
    },
  })),
];

function expect(done, expected, where) {
  if (!Object.is(done, expected)) {
    throw new Error(`${done} instead of ${expected}, ${where}`);
  }
}
