// The loop: deadlines, a sender and a timer around the controller's end.
//
// It runs the same on the page's main thread and in a worker. Each turn asks the end for its
// next step. What is recorded and told meanwhile is in record.js, setting up in course.js.

import { ControllerEnd } from "./end.js";
import { readLaw } from "./law.js";
import { commandText, first, readAnswer } from "./message.js";
import { Record } from "./record.js";
import { Channel, Interval, Timeout, Wait } from "./timer.js";

/** How long at most until a timeout or a stop is noticed, and something is told. */
const LOOK_MS = 200;

/** A run of deadlines from the clock's epoch on. */
export class Drive {
  #settings;
  #clock;
  #record;
  #end;
  #sender;
  #timer;
  #watch = 0;
  /** What wakes and stops a run that sleeps; only `wait` has it. */
  #alarm;
  /** Takes what came of the run; `null` before it and after it. */
  #over = null;
  /** Whether only the end of a message can bring the next step. */
  #resting = false;
  #firstFailure = null;

  /** `makeSender` is given how a message's end is told, and how an answer's seq is read. */
  constructor({ settings, law, reference, clock, y, alarm, makeSender, tell }) {
    this.#settings = settings;
    this.#clock = clock;
    this.#alarm = alarm;
    const read = readLaw(law);
    this.#end = new ControllerEnd(settings, read, y, 0, settings.duration_ns, reference);
    this.#record = new Record(clock.epoch_ns, this.#end.counts, tell);
    const readSeq = (text) => this.#read(text).seq;
    this.#sender = makeSender((seq, result) => this.#ended(seq, result), readSeq);
  }

  /** Makes the way to the plant, before the start. */
  async open() {
    await this.#sender.open();
  }

  /** Passes all deadlines and waits for all messages; gives what came of it. */
  run() {
    return new Promise((resolve) => {
      this.#over = resolve;
      const { timer, h_ns, floor_ns } = this.#settings;
      const turn = () => this.#turn();
      if (timer === "wait") {
        this.#timer = new Wait(this.#clock, this.#alarm);
        this.#block();
        return;
      }
      this.#watch = setInterval(() => this.#look(), LOOK_MS);
      if (timer === "interval") {
        this.#timer = new Interval(this.#clock, h_ns, floor_ns, () => this.#fired());
        this.#timer.start(0);
        return;
      }
      const Kind = timer === "channel" ? Channel : Timeout;
      this.#timer = new Kind(this.#clock, floor_ns, turn);
      this.#timer.set(0);
    });
  }

  /** Ends the run; messages under way then count as failed. */
  stop() {
    this.#finish("stopped");
  }

  /** Steps until there is something to wait for. */
  #turn() {
    if (this.#over === null) {
      return;
    }
    this.#resting = false;
    for (;;) {
      const now_ns = this.#clock.now_ns();
      this.#expire(now_ns);
      const step = this.#end.poll(now_ns);
      switch (step.step) {
        case "send":
          if (!this.#sender.blocks) {
            this.#send(step.command);
            break;
          }
          this.#sendAndWait(step.command);
          this.#record.pulse(now_ns);
          return;
        case "missed":
          this.#record.row(step.row);
          break;
        case "sleep":
          this.#timer.set(step.until_ns);
          this.#record.pulse(now_ns);
          return;
        case "await-answer":
          this.#resting = true;
          return;
        default:
          this.#resting = true;
          this.#settle();
          return;
      }
    }
  }

  /**
   * Sends, and goes back through the timer, so that a loop that is always late still lets the
   * page breathe, and a floor stays one.
   */
  #sendAndWait(command) {
    const { schedule, floor_ns } = this.#settings;
    const before = schedule === "since-send";
    if (before && floor_ns === 0) {
      // This browser's own timer counts while the thread stands still.
      this.#timer.set(this.#end.nextDue_ns);
      this.#send(command);
      return;
    }
    this.#send(command);
    // One of 2011 is made up, and can only be set when the thread is free.
    this.#timer.set(this.#end.nextDue_ns, before ? command.t_send_ns : undefined);
  }

  /** One firing of setInterval. */
  #fired() {
    if (this.#over === null) {
      return;
    }
    const now_ns = this.#clock.now_ns();
    this.#expire(now_ns);
    const step = this.#end.fired(now_ns);
    if (step.step === "send") {
      this.#send(step.command);
    } else if (step.step === "missed") {
      this.#record.row(step.row);
    } else {
      this.#timer.clear();
      this.#resting = true;
      this.#settle();
    }
    this.#record.pulse(now_ns);
  }

  /** The whole run without returning to the event loop. */
  #block() {
    while (!this.#alarm.isStopped) {
      // Read first: what comes in after the look below then ends the sleep at once.
      const { wakes } = this.#alarm;
      this.#sender.collect();
      const now_ns = this.#clock.now_ns();
      this.#expire(now_ns);
      const step = this.#end.poll(now_ns);
      if (step.step === "send") {
        this.#send(step.command);
      } else if (step.step === "missed") {
        this.#record.row(step.row);
      } else if (step.step === "finished" && this.#end.underWay === 0) {
        this.#finish("complete");
        return;
      } else {
        this.#record.pulse(now_ns);
        this.#timer.block(step.until_ns ?? Infinity, LOOK_MS, wakes);
      }
    }
    this.#finish("stopped");
  }

  #send(command) {
    const y = this.#settings.mode === "closed" ? this.#end.y : NaN;
    this.#record.sent(command.t_send_ns, y, first(command.u));
    this.#sender.send(command.seq, commandText(command, this.#clock.epoch_ns));
  }

  /** Takes in how a message ended. */
  #ended(seq, result) {
    const now_ns = this.#clock.now_ns();
    // What came with or after its timeout is late, whoever noticed.
    this.#expire(now_ns);
    let row;
    if (result.text === undefined) {
      row = this.#lose(seq, result, now_ns);
    } else {
      row = this.#answered(seq, result.text, now_ns);
    }
    if (row !== null) {
      this.#record.row(row);
    }
    this.#goOn();
  }

  #answered(seq, text, now_ns) {
    let answer;
    try {
      answer = this.#read(text);
      if (answer.seq !== seq) {
        throw new Error(
          `field \`seq\`: the answer is to command ${answer.seq}, the command was ${seq}`,
        );
      }
    } catch (error) {
      return this.#lose(seq, { loss: "failed", why: error.message }, now_ns);
    }
    return this.#end.answered(answer, now_ns);
  }

  #lose(seq, { loss, why }, now_ns) {
    const row = this.#end.lost(seq, loss, now_ns);
    if (row?.outcome === "failed") {
      this.#firstFailure ??= why;
    }
    return row;
  }

  /** Ends the messages that have waited too long: in order, as all wait equally long. */
  #expire(now_ns) {
    for (;;) {
      const oldest = this.#end.oldest;
      if (oldest === undefined || now_ns - oldest.t_send_ns <= this.#settings.timeout_ns) {
        return;
      }
      this.#sender.abort(oldest.seq);
      this.#record.row(this.#end.lost(oldest.seq, "timeout", now_ns));
    }
  }

  /** Now and then, where nothing else may happen for long. */
  #look() {
    const now_ns = this.#clock.now_ns();
    this.#expire(now_ns);
    this.#goOn();
    this.#record.pulse(now_ns);
  }

  /** Takes the next step, if it waited for a message's end. */
  #goOn() {
    if (!this.#resting) {
      return;
    }
    if (this.#settings.timer === "interval") {
      this.#settle();
    } else {
      this.#turn();
    }
  }

  /** The deadlines are over: ends with the last message. */
  #settle() {
    if (this.#over !== null && this.#end.underWay === 0) {
      this.#finish("complete");
    }
  }

  #finish(outcome) {
    if (this.#over === null) {
      return;
    }
    clearInterval(this.#watch);
    this.#timer.clear?.();
    const now_ns = this.#clock.now_ns();
    for (let oldest = this.#end.oldest; oldest !== undefined; oldest = this.#end.oldest) {
      this.#sender.abort(oldest.seq);
      this.#record.row(this.#end.lost(oldest.seq, "failed", now_ns));
    }
    this.#sender.close();
    this.#record.flush(now_ns);
    const over = this.#over;
    this.#over = null;
    over({
      outcome,
      counts: this.#end.counts,
      first_failure: this.#firstFailure,
      error_ms: this.#record.error_ms,
      rate_achieved_hz: this.#record.rate_hz,
    });
  }

  #read(text) {
    return readAnswer(this.#settings.mode, text, this.#clock.epoch_ns);
  }
}
