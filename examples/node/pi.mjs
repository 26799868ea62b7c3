// The paper's PI controller for the motor, for Node 18 or newer, without packages.
//
// A request at a time, on one kept connection, at the deadlines start + k h. Deadlines that pass while
// an answer is late are skipped, and the integral advances by them too.
import http from "node:http";
import { setTimeout as sleep } from "node:timers/promises";

const told = process.env;
if (told.WEBLOOP_MODE !== "closed") {
  console.error(`WEBLOOP_MODE is ${told.WEBLOOP_MODE}; this controller supports closed alone`);
  process.exit(127);
}
const [h, r, duration] = [told.WEBLOOP_H_S, told.WEBLOOP_R, told.WEBLOOP_DURATION_S].map(Number);
const start_ns = BigInt(told.WEBLOOP_START_NS);
const agent = new http.Agent({ keepAlive: true, maxSockets: 1 });
const cell = new Int32Array(new SharedArrayBuffer(4));

// The time since the start, s: on Linux hrtime is CLOCK_MONOTONIC.
const now = () => Number(process.hrtime.bigint() - start_ns) / 1e9;

// Node's timers have a resolution of 1 ms and may be late, so the last 2 ms are waited for without one.
const until = async (due) => {
  const left_ms = (due - now()) * 1000;
  if (left_ms > 2) await sleep(left_ms - 2);
  Atomics.wait(cell, 0, 0, Math.max(0, (due - now()) * 1000));
};

// The output that the plant answers; undefined if no answer comes in time, or one without y.
const get = (path) =>
  new Promise((resolve) => {
    const request = http.get(told.WEBLOOP_PLANT + path, { agent, timeout: 5000 }, (response) => {
      let text = "";
      const done = () => {
        const found = /&y=([^&]*)&/.exec(text);
        resolve(found ? Number(found[1]) : undefined);
      };
      response.setEncoding("latin1").on("data", (part) => (text += part));
      response.on("end", done).on("close", done);
    });
    request.on("timeout", () => request.destroy());
    request.on("error", () => resolve(undefined));
  });

let y;
while (y === undefined && now() < -0.05) {
  y = await get("/state");
  if (y === undefined) await sleep(20);
}
y ??= 0; // at rest
let [integral, k, passed] = [0, 0, 1];
for (;;) {
  await until(k * h);
  if (k * h >= duration) break;
  const e = r - y;
  integral += 0.378 * (passed * h) * e;
  const u = 0.1701 * e + integral;
  y = (await get(`/closed?u=${encodeURIComponent(u)}`)) ?? y;
  passed = Math.max(1, Math.floor(now() / h) - k);
  k += passed;
}
process.exit(0);
