// What the page refuses: answers that are none, and settings that cannot be.
//
// Each refusal has to name what is wrong.

import { readAnswer } from "./message.js";
import { PRESETS, check, readSettings } from "./setting.js";

const STATE = "seq=1&tick=2&t_arrive_ns=3&y=0.5&u=0.1";

/** An answer in closed loop, and what its refusal names. */
const ANSWERS = [
  ["seq=1&tick=2&t_arrive_ns=3&y=0.5", "`u` is missing"],
  [`${STATE}&u=0.1`, "`u` is there twice"],
  [`${STATE}&v=1`, "`v` is unknown"],
  [STATE.replace("seq=1", "seq=-1"), "`seq`"],
  [STATE.replace("seq=1", "seq=%2B1"), "`seq`"],
  [STATE.replace("t_arrive_ns=3", "t_arrive_ns=18446744073709551616"), "`t_arrive_ns`"],
  [STATE.replace("y=0.5", "y=NaN"), "`y`"],
  [STATE.replace("y=0.5", "y=inf"), "`y`"],
  [STATE.replace("y=0.5", "y=1e400"), "`y`"],
  [STATE.replace("y=0.5", "y=0x10"), "`y`"],
  [STATE.replace("y=0.5", "y="), "`y`"],
  [`${STATE}${" ".repeat(1024)}`, "at most 1024"],
];

/** A query, and what its refusal names. */
const QUERIES = [
  ["mode=opened", "mode `opened`"],
  ["speed=1", "`speed` is unknown"],
  ["h_ns=3000000&h_ns=3000000", "`h_ns` is there twice"],
  ["h_ns=9999", "h_ns `9999`"],
  ["h_ns=3ms", "h_ns `3ms`"],
  ["timeout_ns=0", "timeout_ns `0`"],
  ["r=", "reference"],
  ["r=Infinity", "reference"],
  ["outstanding=0", "outstanding `0`"],
  ["connection=new", "connection `new`"],
  ["start_ns=-1", "start_ns `-1`"],
  ["run=yes", "run `yes`"],
  ["thread=main&timer=wait", "thread `worker`"],
  ["timer=wait&sender=fetch", "`fetch`"],
  ["timer=wait&transport=websocket", "WebSocket"],
  ["timer=interval", "`relative`"],
  ["timer=channel&outstanding=2", "`xhr`"],
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
