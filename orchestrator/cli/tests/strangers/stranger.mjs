// A controller as other people write it in Node: PI, one command each h.
//
//     stranger.mjs http|fetch [each] [seq] [stamp]
//
// `each`: a connection for each message; else one is kept.
import http from "node:http";

const [library, ...habits] = process.argv.slice(2);
const plant = process.env.WEBLOOP_PLANT;
const h = Number(process.env.WEBLOOP_H_S);
const r = Number(process.env.WEBLOOP_R);
const startNs = BigInt(process.env.WEBLOOP_START_NS);
const count = Math.round(Number(process.env.WEBLOOP_DURATION_S) / h);
const agent = new http.Agent({ keepAlive: !habits.includes("each"), maxSockets: 1 });

function byHttp(url) {
  return new Promise((resolve, reject) => {
    http.get(url, { agent }, (answer) => {
      let text = "";
      answer.on("data", (part) => (text += part));
      answer.on("end", () => resolve(text));
    }).on("error", reject);
  });
}

const byFetch = async (url) =>
  (await fetch(url, habits.includes("each") ? { headers: { connection: "close" } } : {})).text();

const get = { http: byHttp, fetch: byFetch }[library];
let [y, integral] = [0, 0];
for (let k = 0; k < count; k++) {
  const leftMs = Number(startNs + BigInt(Math.round(k * h * 1e9)) - process.hrtime.bigint()) / 1e6;
  if (leftMs <= -h * 1e3) continue;
  if (leftMs > 0) await new Promise((done) => setTimeout(done, leftMs));
  const e = r - y;
  integral += 0.378 * h * e;
  const query = new URLSearchParams({ u: String(0.1701 * e + integral) });
  if (habits.includes("seq")) query.set("seq", k);
  if (habits.includes("stamp")) query.set("t_send_ns", process.hrtime.bigint());
  y = Number(new URLSearchParams(await get(`${plant}/closed?${query}`)).get("y"));
}
agent.destroy();
