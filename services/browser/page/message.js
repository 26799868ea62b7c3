// What the two ends say to each other: `seq=7&t_send_ns=1200000&u=0.35`.
//
// Inputs and outputs are signals: a Number or, of a plant that has two, an array of both, which
// on the wire is `u=0.35,0.1`.
//
// A port of services/endpoint/src/message.rs and query.rs. Reading is strict: every field
// exactly once and no other, numbers decimal and finite. Inside the page a time is a Number of
// nanoseconds since the run's epoch; on the wire it is one of CLOCK_MONOTONIC. The epoch is a
// BigInt, so that times are exact however long the machine has been up: 2^53 ns are 104 days.

/** The longest answer that is read; the longest valid one has about 190 bytes. */
const MAX_CHARS = 1024;
/** How much of a refused text an error repeats. */
const EXCERPT_CHARS = 40;
const MAX_COUNT = 2n ** 64n - 1n;
const DECIMAL = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;

const FIELDS = {
  closed: ["seq", "tick", "t_arrive_ns", "y", "u"],
  open: ["seq", "t_arrive_ns"],
  state: ["t_ns", "tick", "y", "u"],
};
/** What a plant tells of its watchdog beside its state; the page does not use it. */
const WATCHDOG = ["u_applied", "safe", "trips"];

/** An invalid message. Its text names the field. */
export class InvalidMessage extends Error {}

/** The first input or output; of most plants it is the only one. */
export function first(signal) {
  return Array.isArray(signal) ? signal[0] : signal;
}

/** Each number of a signal, the first one first. */
export function numbersOf(signal) {
  return Array.isArray(signal) ? signal : [signal];
}

/** A command as a query, its time counted from `epoch_ns`. */
export function commandText(command, epoch_ns) {
  const t_send_ns = epoch_ns + BigInt(command.t_send_ns);
  const u = numbersOf(command.u).map(decimal).join(",");
  return `seq=${command.seq}&t_send_ns=${t_send_ns}&u=${u}`;
}

/** Reads the plant's answer to a command: in closed loop a state, in open loop its arrival. */
export function readAnswer(mode, text, epoch_ns) {
  const values = fields(text, FIELDS[mode]);
  const answer = {
    seq: Number(count("seq", values.seq)),
    t_arrive_ns: Number(count("t_arrive_ns", values.t_arrive_ns) - epoch_ns),
  };
  if (mode === "closed") {
    answer.tick = Number(count("tick", values.tick));
    answer.y = signal("y", values.y, "outputs");
    answer.u = signal("u", values.u, "inputs");
  }
  return answer;
}

/** Reads the plant as it is seen without commanding it; its time stays a BigInt. */
export function readState(text) {
  const values = fields(text, FIELDS.state, WATCHDOG);
  return {
    t_ns: count("t_ns", values.t_ns),
    tick: Number(count("tick", values.tick)),
    y: signal("y", values.y, "outputs"),
    u: signal("u", values.u, "inputs"),
  };
}

/**
 * The fewest digits that read back to the same number, in the same bytes as the other clients
 * write. An exponent has no plus, which would be a space in a query.
 */
export function decimal(value) {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e16)) {
    return value.toExponential().replace("+", "");
  }
  const text = Object.is(value, -0) ? "-0" : String(value);
  return text.includes(".") ? text : `${text}.0`;
}

/** The values of the fields `names`, each there exactly once; `others` may be there too. */
function fields(text, names, others = []) {
  if (text.length > MAX_CHARS) {
    throw new InvalidMessage(`answer of ${text.length} bytes: a message has at most ${MAX_CHARS}`);
  }
  const values = {};
  for (const [name, value] of new URLSearchParams(text)) {
    if (!names.includes(name) && !others.includes(name)) {
      throw new InvalidMessage(
        `field \`${excerpt(name)}\` is unknown: this message has the fields ${names.join(", ")}`,
      );
    }
    if (name in values) {
      throw new InvalidMessage(`field \`${name}\` appears twice: give it once`);
    }
    values[name] = value;
  }
  for (const name of names) {
    if (!(name in values)) {
      throw new InvalidMessage(
        `field \`${name}\` is missing: this message has the fields ${names.join(", ")}`,
      );
    }
  }
  return values;
}

/** A count or a time: digits only, as a BigInt. */
function count(field, text) {
  if (/^\d+$/.test(text)) {
    const number = BigInt(text);
    if (number <= MAX_COUNT) {
      return number;
    }
  }
  throw new InvalidMessage(
    `field \`${field}\`: \`${excerpt(text)}\` is not a whole number from 0 to ${MAX_COUNT}`,
  );
}

/** One finite number, or two with a comma between them. */
function signal(field, text, which) {
  const parts = text.split(",");
  if (parts.length > 2) {
    throw new InvalidMessage(
      `field \`${field}\` has ${parts.length} numbers; a plant has one or two ${which}`,
    );
  }
  const numbers = parts.map((part) => finite(field, part));
  return numbers.length === 1 ? numbers[0] : numbers;
}

/** A finite number. */
function finite(field, text) {
  const number = Number(text);
  if (DECIMAL.test(text) && Number.isFinite(number)) {
    return number;
  }
  throw new InvalidMessage(
    `field \`${field}\`: \`${excerpt(text)}\` is not a finite decimal number; ` +
      "write it like 0.35 or -1e-3",
  );
}

/** The beginning of a text that came from outside. */
export function excerpt(text, chars = EXCERPT_CHARS) {
  return text.length > chars ? `${text.slice(0, chars)}...` : text;
}
