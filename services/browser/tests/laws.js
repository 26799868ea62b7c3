// The control laws against the vectors that the crate `system` writes, each command to its
// last bit, and what holds for all of them.

import { readLaw } from "./law.js";

/** What JSON has no number for is a word in the vectors. */
const WORDS = { NaN, inf: Infinity, "-inf": -Infinity };

/** The cases of laws.json. */
export function lawCases({ cases }) {
  const number = (value) => WORDS[value] ?? value;
  const signal = (value) => (Array.isArray(value) ? value.map(number) : number(value));
  return cases.map(({ case: name, law, steps }) => ({
    name,
    run: () => {
      const running = readLaw(law);
      for (const [at, { r, y, dt_s, u, times }] of steps.entries()) {
        const told = times?.told && { ...times.told, u: signal(times.told.u) };
        const when = times && { send_ns: times.send_ns, told };
        expect(running.update(number(r), signal(y), number(dt_s), when), u, `step ${at}`);
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
    model: { ...MODEL, b: [[1], [0]], c: [[0, 1]], d: [[0]] },
    gains: [[0.5, 0.25]],
    observer: [[0.25], [0.125], [0.5]],
    reference: [[1.5]],
    others: [],
    limits: null,
  },
  aged: {
    law: "aged-feedback",
    model: { ...MODEL, b: [[1], [0]], c: [[0, 1]], d: [[0]] },
    gains: [[0.5, 0.25]],
    reference: [[1.5]],
    others: [],
    limits: null,
    h_ns: 3e6,
    noise: {
      covariance: [[1, 0.5], [0.5, 1]],
      drift: [[1, 0], [0, 0]],
      cross: [[0], [0]],
      output: [[0.25]],
    },
  },
};

/** A law of a plant with two inputs and two outputs, whose outputs are a tick old. */
export const TWO = {
  law: "state-feedback",
  model: { a: MODEL.a, b: [[1, 0.5], [0, 0.25]], c: [[0, 1], [1, 0]], d: [[0, 0], [0, 0]] },
  gains: [[0.5, 0.25], [0.125, 0]],
  observer: [[0.25, 0], [0.125, 0.5], [0.5, 0], [0, 0.5]],
  reference: [[1.5, 0.5], [0.25, 1]],
  others: [2],
  limits: { ...LIMITS, min: -1 },
};

export const laws = [
  {
    name: "state feedback of two inputs and outputs",
    run: () => {
      const law = readLaw(TWO);
      expect(law.update(1, [0, NaN], 0.01), [0, 0], "before the first command");
      // Both references at rest: 1.5 + 0.5 * 2 and 0.25 + 2.
      expect(law.update(1, [0, 0], 0.01), [2.5, 2.25], "at rest");
      // The model is at [3.625, 0.5625] now; its outputs a tick ago were 0.
      const [x0, x1] = [3.625 + 0.25 * 0.5, 0.5625 + 0.125 * 0.5 - 0.5 * 0.5];
      const u = [2.5 - 0.5 * x0 - 0.25 * x1, 2.25 - 0.125 * x0];
      expect(law.update(1, [0.5, -0.5], 0.01), u, "corrected");
      for (const y of [[NaN, 0], [0, Infinity], 0.5]) {
        expect(law.update(1, y, 0.01), u, `y ${y}`);
      }
      expect(law.update(1, [1e3, 0], 0.01)[0], -1, "limited");
    },
  },
  ...["pid", "transfer", "smith"].map((name) => ({
    name: `the law ${name} acts on the first of two outputs`,
    run: () => {
      const [one, two] = [readLaw(LAWS[name]), readLaw(LAWS[name])];
      for (const y of [0, 0.25, 0.5]) {
        expect(two.update(1, [y, 7], 0.01), one.update(1, y, 0.01), `y ${y}`);
      }
    },
  })),
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
  const [mine, wanted] = [[done].flat(), [expected].flat()];
  if (mine.length !== wanted.length || mine.some((one, at) => !Object.is(one, wanted[at]))) {
    throw new Error(`${done} instead of ${expected}, ${where}`);
  }
}
