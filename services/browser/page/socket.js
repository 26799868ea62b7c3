// Sending over one WebSocket: a text message a command, one back an answer.
//
// When it closes, all messages under way have failed, and the next command opens it anew. What
// is sent before it is open waits inside the page.

/** How long the opening may take before the first deadline. */
const OPEN_MS = 5000;

/** One socket for all messages. */
export class SocketSender {
  blocks = false;
  #address;
  #ended;
  #readSeq;
  #socket = null;
  #waiting = [];
  #underWay = new Set();

  /** `way` is how to the plant: mode and session. `readSeq` reads an answer's seq. */
  constructor(way, ended, readSeq) {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const query = new URLSearchParams({ mode: way.mode, session: way.session });
    this.#address = `${scheme}//${location.host}/socket?${query}`;
    this.#ended = ended;
    this.#readSeq = readSeq;
  }

  /** Opens the socket before the first command. */
  open() {
    return new Promise((resolve, reject) => {
      const socket = this.#connect();
      const late = setTimeout(() => reject(new Error("the WebSocket did not open")), OPEN_MS);
      socket.addEventListener("open", () => {
        clearTimeout(late);
        resolve();
      });
      socket.addEventListener("close", (event) => {
        clearTimeout(late);
        reject(new Error(closed(event)));
      });
    });
  }

  send(seq, text) {
    this.#underWay.add(seq);
    const socket = this.#socket ?? this.#connect();
    if (socket.readyState === WebSocket.OPEN) {
      socket.send(text);
    } else {
      this.#waiting.push(text);
    }
  }

  /** Gives a message up; its answer, should it come, is of no message under way. */
  abort(seq) {
    this.#underWay.delete(seq);
  }

  close() {
    this.#underWay.clear();
    this.#socket?.close();
  }

  #connect() {
    const socket = new WebSocket(this.#address);
    this.#socket = socket;
    socket.addEventListener("open", () => {
      for (const text of this.#waiting.splice(0)) {
        socket.send(text);
      }
    });
    socket.addEventListener("message", (event) => this.#received(socket, event.data));
    socket.addEventListener("close", (event) => this.#lost(socket, closed(event)));
    return socket;
  }

  #received(socket, text) {
    let seq;
    try {
      seq = this.#readSeq(text);
    } catch (error) {
      // It is not known which message this would have answered.
      socket.close();
      this.#lost(socket, error.message);
      return;
    }
    if (this.#underWay.delete(seq)) {
      this.#ended(seq, { text });
    }
  }

  /** The socket is gone, and with it all that was sent over it. */
  #lost(socket, why) {
    if (this.#socket !== socket) {
      return;
    }
    this.#socket = null;
    this.#waiting.length = 0;
    const seqs = [...this.#underWay];
    this.#underWay.clear();
    for (const seq of seqs) {
      this.#ended(seq, { loss: "failed", why });
    }
  }
}

function closed(event) {
  const reason = event.reason === "" ? "" : `: ${event.reason}`;
  return `the WebSocket was closed (${event.code})${reason}`;
}
