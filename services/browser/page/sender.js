// A worker that sends for a loop whose own worker sleeps: fetch or a WebSocket, and the ring back.
//
// It is told a task once, then texts to send; see remote.js.

import { readAnswer } from "./message.js";
import { Alarm, Ring } from "./ring.js";
import { makeSender } from "./way.js";

/** How long what found the ring full waits until it is tried again. */
const AGAIN_MS = 1;

let sender = null;
let ring = null;
let alarm = null;
/** What found the ring full. */
const waiting = [];

addEventListener("message", ({ data }) => {
  if (data.task !== undefined) {
    begin(data.task);
  } else if (data.text !== undefined) {
    sender.send(data.seq, data.text);
  } else if (data.abort !== undefined) {
    sender.abort(data.abort);
  } else {
    sender.close();
    close();
  }
});

async function begin({ settings, session, ...memory }) {
  ring = new Ring(memory.ring);
  alarm = new Alarm(memory.alarm);
  const readSeq = (text) => readAnswer(settings.mode, text, 0n).seq;
  // This worker hears events, so its sender may be here.
  sender = makeSender({ settings, session, alarm: null }, tell, readSeq);
  try {
    await sender.open();
    postMessage({});
  } catch (error) {
    postMessage({ problem: error.message });
  }
}

/** Tells the loop how a message ended. */
function tell(seq, result) {
  waiting.push([seq, result]);
  // A timer is set for what waits already.
  if (waiting.length === 1) {
    write();
  }
}

function write() {
  while (waiting.length > 0 && ring.write(...waiting[0])) {
    waiting.shift();
  }
  alarm.ring();
  if (waiting.length > 0) {
    setTimeout(write, AGAIN_MS);
  }
}
