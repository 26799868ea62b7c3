// What the page refuses: invalid answers, settings and laws.
//
// Each refusal has to name what is wrong.

import { MAX_TICKS, readLaw } from "./law.js";
import { LAWS, TWO } from "./laws.js";
import { readAnswer } from "./message.js";
import { PRESETS, check, readSettings } from "./setting.js";

const STATE = "seq=1&tick=2&t_arrive_ns=3&y=0.5&u=0.1";

/** An answer in closed loop, and what its refusal names. */
const ANSWERS = [
  ["seq=1&tick=2&t_arrive_ns=3&y=0.5", "`u` is missing"],
  [`${STATE}&u=0.1`, "`u` appears twice"],
  [`${STATE}&v=1`, "`v` is unknown"],
  [STATE.replace("seq=1", "seq=-1"), "`seq`"],
  [STATE.replace("seq=1", "seq=%2B1"), "`seq`"],
  [STATE.replace("t_arrive_ns=3", "t_arrive_ns=18446744073709551616"), "`t_arrive_ns`"],
  [STATE.replace("y=0.5", "y=NaN"), "`y`"],
  [STATE.replace("y=0.5", "y=inf"), "`y`"],
  [STATE.replace("y=0.5", "y=1e400"), "`y`"],
  [STATE.replace("y=0.5", "y=0x10"), "`y`"],
  [STATE.replace("y=0.5", "y="), "`y`"],
  [STATE.replace("y=0.5", "y=1,2,3"), "`y` has 3 numbers; a plant has one or two outputs"],
  [STATE.replace("y=0.5", "y=1,"), "`y`: ``"],
  [STATE.replace("u=0.1", "u=1,2,3"), "`u` has 3 numbers; a plant has one or two inputs"],
  [STATE.replace("u=0.1", "u=1,NaN"), "`u`: `NaN`"],
  [`${STATE}${" ".repeat(1024)}`, "at most 1024"],
];

/** A query, and what its refusal names. */
const QUERIES = [
  ["mode=opened", "mode `opened`"],
  ["speed=1", "`speed` is unknown"],
  ["h_ns=3000000&h_ns=3000000", "`h_ns` appears twice"],
  ["h_ns=9999", "h_ns `9999`"],
  ["h_ns=3ms", "h_ns `3ms`"],
  ["timeout_ns=0", "timeout_ns `0`"],
  ["r=", "reference"],
  ["r=Infinity", "reference"],
  ["outstanding=0", "outstanding is `0`"],
  ["connection=new", "connection `new`"],
  ["start_ns=-1", "start_ns `-1`"],
  ["run=yes", "run `yes`"],
  ["thread=main&timer=wait", "thread `worker`"],
  ["timer=interval", "`relative`"],
  ["timer=channel&outstanding=2", "`xhr`"],
];

const { pid, transfer, smith, feedback, aged } = LAWS;
const { limits, model } = transfer;
const pulled = { ...limits, anti_windup: "back-calculation", gain_per_s: 99 };
const modelled = (part) => ({ ...transfer, model: { ...model, ...part } });
const modelledTwo = (part) => ({ ...TWO, model: { ...TWO.model, ...part } });

/** A law, and what its refusal names. */
const NO_LAWS = [
  [7, "one of pid, transfer, smith, state-feedback"],
  ["pid", "`law`"],
  [[pid], "`law`"],
  [{}, "`law`"],
  [{ ...pid, law: "bang-bang" }, "`law`: `\"bang-bang\"`"],
  [{ ...pid, law: "toString" }, "`law`"],
  [{ ...pid, gain: 1 }, "`gain` is unknown"],
  [{ law: "pid", kp: 1, ki: 1, kd: 0, filter_rad_s: null }, "`limits` is missing"],
  [{ ...pid, kp: "1" }, "`kp`: `\"1\"`"],
  [{ ...pid, ki: NaN }, "`ki`"],
  [{ ...pid, kd: null }, "`kd`: `null`"],
  [{ ...pid, filter_rad_s: 0 }, "`filter_rad_s`: `0`"],
  [{ ...pid, limits: [] }, "`limits`: `[]`"],
  [{ ...pid, limits: {} }, "`limits.min` is missing"],
  [{ ...pid, limits: { ...limits, max: -1e9 } }, "is empty"],
  [{ ...pid, limits: { ...limits, anti_windup: "on" } }, "off or conditional or back-calculation"],
  [{ ...pid, limits: { ...limits, gain_per_s: 1 } }, "null where anti_windup is off"],
  [{ ...pid, limits: { ...pulled, gain_per_s: null } }, "`limits.gain_per_s`: `null`"],
  [{ ...pid, limits: { ...pulled, gain_per_s: -1 } }, "`limits.gain_per_s`: `-1`"],
  [{ ...transfer, limits: pulled }, "`limits.anti_windup`"],
  [{ ...transfer, model: null }, "`model`: `null`"],
  [modelled({ a: 1 }), "`model.a`: `1`"],
  [modelled({ a: [[1], [1, 2]] }), "`model.a[0]` has 1 numbers; give 2"],
  [modelled({ a: [[1, 2], [1, null]] }), "`model.a[1][1]`: `null`"],
  [modelled({ b: [1] }), "`model.b` has 1 numbers; give 2"],
  [modelled({ c: [] }), "`model.c` has 0 numbers; give 2"],
  [modelled({ d: [] }), "`model.d`: `[]`"],
  [modelled({ e: 0 }), "`model.e` is unknown"],
  [{ ...smith, pid }, "`pid.law` is unknown"],
  [{ ...smith, pid: { ...smith.pid, kp: null } }, "`pid.kp`: `null`"],
  [{ ...smith, ticks: -1 }, "`ticks`: `-1`"],
  [{ ...smith, ticks: 0.5 }, "`ticks`: `0.5`"],
  [{ ...smith, ticks: MAX_TICKS + 1 }, `from 0 to ${MAX_TICKS}`],
  [{ ...feedback, gains: [1, 2] }, "`gains[0]`: `1` is wrong; give a list"],
  [{ ...feedback, gains: [[1]] }, "`gains[0]` has 1 numbers; give 2, one for each row of `model.a`"],
  [{ ...feedback, observer: [[1], [1]] }, "`observer` has 2 rows; give 2 for the model's states"],
  [{ ...feedback, reference: {} }, "`reference`: `{}`"],
  [{ ...feedback, others: [1] }, "`others` has 1 numbers; give at most 0"],
  [{ ...aged, h_ns: 0 }, "`h_ns`: `0` is wrong; give a whole number above zero"],
  [{ ...aged, noise: {} }, "`noise.covariance` is missing"],
  [{ ...aged, noise: { ...aged.noise, drift: [[1, 0]] } }, "`noise.drift` has 1 rows; give 2"],
  [{ ...aged, noise: { ...aged.noise, output: [[null]] } }, "`noise.output[0][0]`: `null`"],
  [{ ...TWO, gains: [] }, "`gains` has 0 rows; give one or two, one for each input"],
  [modelledTwo({ c: [[0, 1], [0, 1], [0, 1]] }), "`model.c` has 3 rows; give one or two"],
  [modelledTwo({ b: [[1, 1]] }), "`model.b` has 1 rows; give 2, one for each row of `model.a`"],
  [modelledTwo({ b: [[1, 1], [1]] }), "`model.b[1]` has 1 numbers; give 2, one for each row of `gains`"],
  [modelledTwo({ c: [[0, null], [1, 0]] }), "`model.c[0][1]`: `null`"],
  [modelledTwo({ d: 0 }), "`model.d`: `0` is wrong; give a list"],
  [{ ...TWO, observer: Array(5).fill([0, 0]) }, "`observer` has 5 rows; give 2 for the model's"],
  [{ ...TWO, observer: Array(4).fill([0]) }, "`observer[0]` has 1 numbers; give 2"],
  [{ ...TWO, reference: [[1], [1]] }, "`reference[0]` has 1 numbers; give 2, one for each reference"],
  [{ ...TWO, others: [1, 2] }, "`others` has 2 numbers; give at most 1"],
];

const isolated = { isolated: true };

export const refusals = [
  ...ANSWERS.map(([text, names]) => ({
    name: `the answer ${text.slice(0, 60)}`,
    run: () => refused(() => readAnswer("closed", text, 0n), names),
  })),
  ...QUERIES.map(([query, names]) => ({
    name: `the query ${query}`,
    run: () => refused(() => check(readSettings(query).settings, isolated), names),
  })),
  ...NO_LAWS.map(([law, names]) => ({
    name: `the law ${JSON.stringify(law).slice(0, 60)}`,
    run: () => refused(() => readLaw(law), names),
  })),
  {
    name: "timer `wait` without isolation",
    run: () => refused(() => check(readSettings("").settings, { isolated: false }), "isolated"),
  },
  ...Object.entries(PRESETS).map(([name, preset]) => ({
    name: `the preset ${name} can be`,
    run: () => check({ ...readSettings("").settings, ...preset }, isolated),
  })),
];

function refused(act, names) {
  let text = null;
  try {
    act();
  } catch (error) {
    text = error.message;
  }
  if (text === null) {
    throw new Error("was taken");
  }
  if (!text.includes(names)) {
    throw new Error(`${text}: does not name ${names}`);
  }
}
