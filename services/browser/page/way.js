// What sends a run's messages: fetch, a synchronous XMLHttpRequest, or one WebSocket.

import { FetchSender } from "./fetch.js";
import { SocketSender } from "./socket.js";
import { XhrSender } from "./xhr.js";

/**
 * The sender that the settings name. `ended` is told how each message ended, `readSeq` reads an answer's
 * seq.
 */
export function makeSender({ settings, session }, ended, readSeq) {
  const { mode, transport, sender, timeout_ns } = settings;
  const way = { mode, session, path: `/${mode}`, timeout_ms: Math.ceil(timeout_ns / 1e6) };
  if (transport === "websocket") {
    return new SocketSender(way, ended, readSeq);
  }
  return sender === "xhr" ? new XhrSender(way, ended) : new FetchSender(way, ended);
}
