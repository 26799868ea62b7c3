// What sends a run's messages: fetch, a synchronous XMLHttpRequest, or one WebSocket; and where.

import { FetchSender } from "./fetch.js";
import { RemoteSender } from "./remote.js";
import { SocketSender } from "./socket.js";
import { XhrSender } from "./xhr.js";

/**
 * The sender that the settings name; in a worker of its own, if the loop sleeps on an alarm and the sender
 * needs events. `ended` is told how each message ended, `readSeq` reads an answer's seq.
 */
export function makeSender({ settings, session, alarm }, ended, readSeq) {
  const { mode, transport, sender, timeout_ns } = settings;
  const way = { mode, session, path: `/${mode}`, timeout_ms: Math.ceil(timeout_ns / 1e6) };
  if (transport === "http" && sender === "xhr") {
    return new XhrSender(way, ended);
  }
  if (alarm !== null) {
    return new RemoteSender({ settings, session, alarm }, ended);
  }
  return transport === "websocket"
    ? new SocketSender(way, ended, readSeq)
    : new FetchSender(way, ended);
}
