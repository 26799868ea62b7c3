// The control law: which there are, and how one is read as the plant hands it over.
//
// The form is that of orchestrator/plan/src/system/design.rs. Reading is strict: every field has to be
// there and no other may be, shapes have to fit, numbers are finite. What a law does is in the
// module of its name.

import { AgedFeedback } from "./aged.js";
import { Commands, StateFeedback } from "./feedback.js";
import { excerpt } from "./message.js";
import { Model } from "./model.js";
import { Pid, UNLIMITED } from "./pid.js";
import { Smith } from "./smith.js";
import { Transfer } from "./transfer.js";

/** The gains of the paper's controller: proportional, and integral in 1/s. */
const PAPER = { kp: 0.1701, ki: 0.378 };
/** The longest round trip that a Smith predictor expects, in updates. */
export const MAX_TICKS = 1_000_000;

const PID = ["kp", "ki", "kd", "filter_rad_s", "limits"];
const FIELDS = {
  pid: PID,
  transfer: ["model", "limits"],
  smith: ["pid", "model", "ticks"],
  "state-feedback": ["model", "gains", "observer", "reference", "others", "limits"],
  "aged-feedback": ["model", "gains", "reference", "others", "limits", "h_ns", "noise"],
};
const WINDUPS = ["off", "conditional", "back-calculation"];

/** An invalid law. Its text names the field. */
export class InvalidLaw extends Error {
  constructor(why) {
    super(`the plant's law: ${why}`);
  }
}

/**
 * A law at rest, from its object; from `null` the paper's PI. Whichever it is, it has
 * `update(r, y, dt_s, times)`, which gives the command for the reference r and the newest output
 * y, `dt_s` after the last: always finite. Of a plant with two inputs or outputs u or y is an
 * array. `times` has `send_ns`, when the command is sent, and `told`, what the answer told that
 * brought y: its `tick`, the `u` held then and the `send_ns` of its message; or `null`.
 */
export function readLaw(value) {
  if (value === null) {
    return new Pid(PAPER);
  }
  const kind = value.law;
  if (typeof kind !== "string" || !Object.hasOwn(FIELDS, kind)) {
    refuse("law", kind, `one of ${Object.keys(FIELDS).join(", ")}`);
  }
  return MAKERS[kind](fields("", value, ["law", ...FIELDS[kind]]));
}

/** What a person reads of it. */
export function lawText(value) {
  return value === null ? "law: the paper's PI" : `law: ${value.law}, as the plant has it`;
}

const MAKERS = {
  pid: (law) => readPid("", law),
  transfer: (law) =>
    new Transfer(readModel(law.model), readLimits("limits", law.limits, ["off"])),
  smith: (law) => {
    const pid = readPid("pid.", fields("pid", law.pid, PID));
    return new Smith(pid, readModel(law.model), readTicks(law.ticks));
  },
  "state-feedback": readFeedback,
  "aged-feedback": readAged,
};

/** A PID from its fields, whose names begin with `at` in an error. */
function readPid(at, { kp, ki, kd, filter_rad_s, limits }) {
  return new Pid({
    kp: number(`${at}kp`, kp),
    ki: number(`${at}ki`, ki),
    kd: number(`${at}kd`, kd),
    filter_rad_s: filter_rad_s === null ? Infinity : positive(`${at}filter_rad_s`, filter_rad_s),
    limits: limits === null ? null : readLimits(`${at}limits`, limits, WINDUPS),
  });
}

function readLimits(at, value, windups) {
  if (value === null) {
    return UNLIMITED;
  }
  const names = ["min", "max", "anti_windup", "gain_per_s"];
  const { min: low, max: high, anti_windup, gain_per_s } = fields(at, value, names);
  const min = low === null ? -Infinity : number(`${at}.min`, low);
  const max = high === null ? Infinity : number(`${at}.max`, high);
  if (min >= max) {
    throw new InvalidLaw(`field \`${at}\`: from ${min} to ${max} is empty; give min below max`);
  }
  if (!windups.includes(anti_windup)) {
    refuse(`${at}.anti_windup`, anti_windup, windups.join(" or "));
  }
  if (anti_windup === "back-calculation") {
    positive(`${at}.gain_per_s`, gain_per_s);
  } else if (gain_per_s !== null) {
    refuse(`${at}.gain_per_s`, gain_per_s, `null where anti_windup is ${anti_windup}`);
  }
  return { min, max, anti_windup, gain_per_s };
}

/** A model with one input and one output. */
function readModel(value) {
  const { a, b, c, d } = fields("model", value, ["a", "b", "c", "d"]);
  const states = { count: list("model.a", a).length, each: "row of `model.a`" };
  return new Model({
    a: matrix("model.a", a, states, states),
    b: numbers("model.b", b, states),
    c: numbers("model.c", c, states),
    d: number("model.d", d),
  });
}

function readFeedback(law) {
  const { model, commands } = readByStates(law);
  const { observer } = law;
  const states = model.a.length;
  const outputs = { count: model.c.length, each: "row of `model.c`" };
  const rows = list("observer", observer).length;
  const line = rows - states;
  if (line < outputs.count || line % outputs.count !== 0) {
    throw new InvalidLaw(
      `field \`observer\` has ${rows} rows; give ${states} for the model's states and ` +
        `${outputs.count} for each tick that its outputs are on their way, at least one`,
    );
  }
  return new StateFeedback({
    model,
    commands,
    observer: observer.map((row, at) => numbers(`observer[${at}]`, row, outputs)),
  });
}

function readAged(law) {
  const { model, commands } = readByStates(law);
  const { h_ns, noise } = law;
  if (!Number.isInteger(h_ns) || h_ns < 1) {
    refuse("h_ns", h_ns, "a whole number above zero");
  }
  const parts = fields("noise", noise, ["covariance", "drift", "cross", "output"]);
  const states = { count: model.a.length, each: "row of `model.a`" };
  const outputs = { count: model.c.length, each: "row of `model.c`" };
  return new AgedFeedback({
    model,
    commands,
    h_ns,
    noise: {
      covariance: matrix("noise.covariance", parts.covariance, states, states),
      drift: matrix("noise.drift", parts.drift, states, states),
      cross: matrix("noise.cross", parts.cross, states, outputs),
      output: matrix("noise.output", parts.output, outputs, outputs),
    },
  });
}

/** What both laws that know the plant's states have. */
function readByStates({ model, gains, reference, others, limits }) {
  const { a, b, c, d } = fields("model", model, ["a", "b", "c", "d"]);
  const states = { count: list("model.a", a).length, each: "row of `model.a`" };
  const inputs = { count: oneOrTwo("gains", gains, "input"), each: "row of `gains`" };
  const byState = matrix("gains", gains, inputs, states);
  const outputs = { count: oneOrTwo("model.c", c, "output"), each: "row of `model.c`" };
  const rest = numbers("others", others);
  if (rest.length >= outputs.count) {
    throw new InvalidLaw(
      `field \`others\` has ${rest.length} numbers; give at most ${outputs.count - 1}, one for ` +
        "each output after the first",
    );
  }
  const references = { count: 1 + rest.length, each: "reference, r and `others`" };
  return {
    model: {
      a: matrix("model.a", a, states, states),
      b: matrix("model.b", b, states, inputs),
      c: matrix("model.c", c, outputs, states),
      d: matrix("model.d", d, outputs, inputs),
    },
    commands: new Commands({
      gains: byState,
      reference: matrix("reference", reference, inputs, references),
      others: rest,
      limits: readLimits("limits", limits, ["off"]),
    }),
  };
}

function readTicks(value) {
  if (Number.isInteger(value) && value >= 0 && value <= MAX_TICKS) {
    return value;
  }
  return refuse("ticks", value, `a whole number from 0 to ${MAX_TICKS}`);
}

function positive(at, value) {
  return number(at, value) > 0 ? value : refuse(at, value, "a number above zero");
}

function number(at, value) {
  return Number.isFinite(value) ? value : refuse(at, value, "a finite number");
}

/** A list of numbers; `size` says how many there have to be, and for each of what. */
function numbers(at, value, size = null) {
  const values = list(at, value, size, "numbers");
  return values.map((one, index) => number(`${at}[${index}]`, one));
}

/** A list of rows of numbers. */
function matrix(at, value, rows, columns) {
  const values = list(at, value, rows, "rows");
  return values.map((row, index) => numbers(`${at}[${index}]`, row, columns));
}

/** How many rows there are, one for each input or output of the plant. */
function oneOrTwo(at, value, which) {
  const { length } = list(at, value);
  if (length !== 1 && length !== 2) {
    throw new InvalidLaw(
      `field \`${at}\` has ${length} rows; give one or two, one for each ${which}`,
    );
  }
  return length;
}

function list(at, value, size = null, what = "") {
  if (!Array.isArray(value)) {
    refuse(at, value, "a list");
  }
  if (size !== null && value.length !== size.count) {
    throw new InvalidLaw(
      `field \`${at}\` has ${value.length} ${what}; give ${size.count}, one for each ${size.each}`,
    );
  }
  return value;
}

/** The object, if it has the fields `names` and no other. */
function fields(at, value, names) {
  if (value === null || typeof value !== "object" || Array.isArray(value)) {
    refuse(at, value, `an object with the fields ${names.join(", ")}`);
  }
  const within = at === "" ? "" : `${at}.`;
  for (const name of Object.keys(value)) {
    if (!names.includes(name)) {
      throw new InvalidLaw(
        `field \`${within}${excerpt(name)}\` is unknown; there are ${names.join(", ")}`,
      );
    }
  }
  for (const name of names) {
    if (!Object.hasOwn(value, name)) {
      throw new InvalidLaw(`field \`${within}${name}\` is missing; there are ${names.join(", ")}`);
    }
  }
  return value;
}

function refuse(at, value, remedy) {
  const shown = excerpt(JSON.stringify(value) ?? "nothing");
  throw new InvalidLaw(`field \`${at}\`: \`${shown}\` is wrong; give ${remedy}`);
}
