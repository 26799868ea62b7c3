// Runs the page's end and laws against the vectors that Rust writes, and the refusals.
//
// Whoever serves this serves the files of ../page, those beside this one, and controller.json
// and laws.json of the endpoint's tests, all at the root, and takes a POST of `{passed, failed}`
// to /result.

import { ControllerEnd } from "./end.js";
import { readLaw } from "./law.js";
import { lawCases, laws } from "./laws.js";
import { commandText, readAnswer } from "./message.js";
import { Pid } from "./pid.js";
import { Ring } from "./ring.js";
import { rowLine } from "./row.js";
import { refusals } from "./refusals.js";

const EPOCH_NS = 0n;
const UNITS_NS = { ns: 1, us: 1e3, ms: 1e6, s: 1e9 };

/** A sample time as the vectors write it, `3ms`. */
function sampleTime(text) {
  const [, number, unit] = /^([\d.]+)([a-z]+)$/.exec(text);
  return Number(number) * UNITS_NS[unit];
}

/** The steps of a wake, in the vectors' form. */
function wake(end, now_ns) {
  const steps = [];
  for (;;) {
    const step = end.poll(now_ns);
    switch (step.step) {
      case "send":
        steps.push({ send: commandText(step.command, EPOCH_NS) });
        break;
      case "missed":
        steps.push({ missed: step.row.seq, t_due_ns: step.row.t_due_ns });
        break;
      case "sleep":
        return [...steps, { sleep_until_ns: step.until_ns }];
      default:
        return [...steps, step.step];
    }
  }
}

/** What the end does in one step of a case. */
function play(end, mode, step) {
  if (step.wake) {
    return { ...step, then: wake(end, step.at_ns) };
  }
  if (step.answer !== undefined) {
    return { ...step, row: end.answered(readAnswer(mode, step.answer, EPOCH_NS), step.at_ns) };
  }
  const loss = step.timeout === undefined ? "failed" : "timeout";
  return { ...step, row: end.lost(step.timeout ?? step.failure, loss, step.at_ns) };
}

/** Equal, whatever the order of the keys. */
function same(a, b) {
  const sorted = (_, value) =>
    value !== null && typeof value === "object" && !Array.isArray(value)
      ? Object.fromEntries(Object.entries(value).sort(([x], [y]) => (x < y ? -1 : 1)))
      : value;
  return JSON.stringify(a, sorted) === JSON.stringify(b, sorted);
}

function vectorCases({ law, cases }) {
  return cases.map(({ case: name, settings, reference, start_ns, stop_ns, steps, counts }) => ({
    name,
    run: () => {
      const mine = { ...settings, h_ns: sampleTime(settings.h) };
      const end = new ControllerEnd(mine, new Pid(law), 0, start_ns, stop_ns, reference);
      for (const step of steps) {
        const done = play(end, settings.mode, step);
        if (!same(done, step)) {
          throw new Error(`${JSON.stringify(done)} instead of ${JSON.stringify(step)}`);
        }
      }
      if (!same(end.counts, counts)) {
        throw new Error(`${JSON.stringify(end.counts)} instead of ${JSON.stringify(counts)}`);
      }
    },
  }));
}

/** Times of a machine that has been up for a year, beyond what a Number can tell apart. */
const longUp = {
  name: "times beyond 2^53 ns keep their last digit",
  run: () => {
    const epoch_ns = 31_536_000_000_000_001n;
    const text = commandText({ seq: 0, t_send_ns: 4, u: 0.5 }, epoch_ns);
    const answer = readAnswer("open", "seq=0&t_arrive_ns=31536000000000007", epoch_ns);
    const row = { seq: 0, t_due_ns: 0, t_send_ns: 4, t_receive_ns: 9, t_arrive_ns: answer.t_arrive_ns };
    const line = rowLine({ ...row, r: 1, y: null, e: null, u: 1e-7, tick: null, outcome: "answered", y_seq: 0 }, epoch_ns);
    const t = "3153600000000000";
    const expected = `0,${t}1,${t}5,31536000000000010,${t}7,1.0,,,1e-7,,answered,0\n`;
    if (text !== `seq=0&t_send_ns=${t}5&u=0.5` || line !== expected) {
      throw new Error(`${text} and ${line}`);
    }
  },
};

/** setInterval as the schedule, which the vectors do not have. */
const interval = {
  name: "each firing of an interval is a deadline, missed while the last message is under way",
  run: () => {
    const settings = { mode: "open", h_ns: 10, r: 1, outstanding: 1, schedule: "relative", late: "apply", integrate: "h" };
    const end = new ControllerEnd(settings, readLaw(null), 0, 100, 140);
    const fired = (now_ns) => {
      const { step, row } = end.fired(now_ns);
      return [step, row?.t_due_ns ?? end.oldest?.t_due_ns];
    };
    const done = [fired(100), fired(111)];
    end.lost(0, "failed", 115);
    // Late by 4, then sooner than h after it.
    done.push(fired(125));
    end.lost(2, "failed", 126);
    done.push(fired(131));
    end.lost(3, "failed", 132);
    done.push(fired(142));
    const expected = [["send", 100], ["missed", 110], ["send", 121], ["send", 131], ["finished", undefined]];
    if (!same(done, expected)) {
      throw new Error(`${JSON.stringify(done)} instead of ${JSON.stringify(expected)}`);
    }
  },
};

/** What the vectors do not have. */
const two = {
  name: "a law gets and gives all signals, and a row has the first",
  run: () => {
    const settings = { mode: "closed", h_ns: 10, r: 1, outstanding: 1, schedule: "absolute", late: "apply", integrate: "h" };
    const given = [];
    const swapping = {
      update: (_, [first, second], dt_s, times) => {
        given.push(times);
        return [second, first];
      },
    };
    const end = new ControllerEnd(settings, swapping, [0.25, 0.5], 0, 20);
    const done = wake(end, 0).slice(0, 1);
    const answer = readAnswer("closed", "seq=0&tick=1&t_arrive_ns=2&y=3,4&u=0.5,0.25", EPOCH_NS);
    const { y, e, u } = end.answered(answer, 3);
    done.push(y, e, u, end.y, ...wake(end, 10).slice(0, 1));
    done.push(end.oldest.y_seq, ...given.map(({ send_ns, told }) => [send_ns, told?.tick, told?.send_ns, told?.u]));
    const sent = ["seq=0&t_send_ns=0&u=0.5,0.25", "seq=1&t_send_ns=10&u=4.0,3.0"].map((send) => ({ send }));
    const expected = [sent[0], 0.25, 0.75, 0.5, 3, sent[1], 0, [0, undefined, undefined, undefined], [10, 1, 0, [0.5, 0.25]]];
    if (!same(done, expected)) {
      throw new Error(`${JSON.stringify(done)} instead of ${JSON.stringify(expected)}`);
    }
  },
};

/** How a worker that sleeps is told of its messages. */
const ring = {
  name: "a ring gives back in order what was written, whole, and refuses what it has no room for",
  run: () => {
    const writer = new Ring();
    const reader = new Ring(writer.memory);
    const results = [{ text: "seq=0&u=0.5" }, { loss: "failed", why: "é – \u{1f600}" }, { loss: "timeout", why: "" }];
    const result = (seq) => results[seq % results.length];
    let [written, taken] = [0, 0];
    // Several times around, full each time.
    for (let turn = 0; turn < 3; turn += 1) {
      while (writer.write(written, result(written))) {
        written += 1;
      }
      for (let told = reader.read(); told !== null; told = reader.read()) {
        if (!same(told, { seq: taken, result: result(taken) })) {
          throw new Error(`${taken}: ${JSON.stringify(told)}`);
        }
        taken += 1;
      }
    }
    if (taken !== written || taken !== 3072) {
      throw new Error(`${taken} taken, ${written} written`);
    }
    writer.write(1, { text: "y".repeat(2000) });
    if (reader.read().result.text.length <= 1024) {
      throw new Error("a text that is too long is no longer known as such");
    }
  },
};

const read = async (path) => (await fetch(path)).json();
const cases = [
  ...vectorCases(await read("/controller.json")),
  ...lawCases(await read("/laws.json")),
];
const failed = [];
let passed = 0;
for (const { name, run } of [...cases, ...laws, longUp, interval, two, ring, ...refusals]) {
  try {
    run();
    passed += 1;
  } catch (error) {
    failed.push(`${name}: ${error.message}`);
  }
}
document.getElementById("result").textContent = [`${passed} passed`, ...failed].join("\n");
document.title = `${failed.length === 0 ? "passed" : "failed"} · webloop`;
await fetch("/result", {
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify({ passed, failed }),
});
