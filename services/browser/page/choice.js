// The settings of a run: their words, what each means to a person, and where they are shown.
//
// The first word of a choice is the usual one. Which go together is in setting.js.

/** The presets: their titles and what they stand for. */
export const PRESET_TEXT = {
  worker: ["Worker", "A blocking request every h from a worker that sleeps to the deadline."],
  "paper-2011": [
    "Paper, 2011",
    "The paper's page: one blocking request after the other, timers no shorter than 10 ms.",
  ],
  today: ["The same, today", "The paper's page with the timers of a present browser."],
  "paper-python": ["Paper, Python", "A request every h, whatever is still outstanding."],
  socket: ["WebSocket", "A message every h over one open WebSocket."],
};

/** Which controls are in which group of the page. */
export const GROUPS = {
  "loop-settings": ["mode", "duration", "h", "r"],
  "page-settings": ["transport", "sender", "thread", "timer", "floor", "chores"],
  "deadline-settings": ["schedule", "outstanding", "integrate", "late", "timeout"],
};

/** The choices of words: legend, and a hint a word. */
export const CHOICES = {
  mode: ["Loop", {
    closed: "The plant applies u and answers with y.",
    open: "The plant only acknowledges: a study of timing.",
  }],
  transport: ["Transport", {
    http: "A request a message.",
    websocket: "One connection for all messages.",
  }],
  sender: ["Sender", {
    xhr: "Synchronous XMLHttpRequest: its thread stands still until the answer.",
    fetch: "Asynchronous; a browser has at most six requests to a host on their way.",
  }],
  thread: ["Thread", {
    worker: "A thread of its own, undisturbed by the page.",
    main: "The page's own, as in 2011.",
  }],
  timer: ["Timer", {
    wait: "Atomics.wait: a worker sleeps to the deadline; another has fetch or WebSocket.",
    channel: "MessageChannel turns: no second worker, but a processor is kept busy.",
    timeout: "setTimeout: whole milliseconds, 4 ms at least when nested.",
    interval: "setInterval: each firing is a deadline.",
  }],
  schedule: ["Deadlines", {
    absolute: "start + k h: what is late stays visible.",
    relative: "h after the last message: drifts, as a sleeping loop does.",
    "since-send": "h after the last sending: a timer set before all else.",
  }],
  integrate: ["Integrator advances by", {
    h: "The nominal sample time, as in the paper.",
    elapsed: "The time since the message before.",
  }],
  late: ["An overtaken answer", {
    apply: "Is taken as it comes.",
    drop: "Is left out.",
  }],
};

/** The numbers: label, unit, and the setting with the factor from the unit. */
export const NUMBERS = {
  duration: { label: "Duration", unit: "s", setting: "duration_ns", factor: 1e9 },
  h: { label: "Sample time h", unit: "ms", setting: "h_ns", factor: 1e6, empty: "plant's" },
  r: { label: "Reference r", unit: "", setting: "r", factor: 1 },
  outstanding: {
    label: "Outstanding",
    unit: "",
    setting: "outstanding",
    factor: 1,
    word: "unlimited",
  },
  floor: { label: "Timer floor", unit: "ms", setting: "floor_ns", factor: 1e6 },
  chores: { label: "Drawing, of 100 ms", unit: "ms", setting: "chores_ns", factor: 1e6 },
  timeout: { label: "Timeout", unit: "s", setting: "timeout_ns", factor: 1e9 },
};
