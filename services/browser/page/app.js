// The page: its controls, its display, and one run at a time.
//
// With `?run=1` it starts by itself, as a launcher asks; otherwise it waits for a person.

import { Display } from "./display.js";
import { Form } from "./form.js";
import { Run } from "./run.js";
import { readSettings } from "./setting.js";

const display = new Display();
/** @type {any} */
const button = document.getElementById("go");
/** @type {any} */
const download = document.getElementById("download");
let run = null;
let chosen = null;

const form = new Form((request) => {
  chosen = request;
  button.disabled = run === null && request === null;
});

button.addEventListener("click", () => {
  if (run !== null) {
    button.disabled = true;
    run.stop();
  } else if (chosen !== null) {
    start(chosen);
  }
});

/** Runs to the end; the page can then be used again. */
async function start(request) {
  run = new Run(request, display);
  const mine = run;
  form.lock(true);
  download.hidden = true;
  button.textContent = "Stop";
  button.dataset.does = "stop";
  await mine.toEnd();
  run = null;
  form.lock(false);
  button.textContent = "Start";
  button.dataset.does = "start";
  button.disabled = chosen === null;
  if (mine.ended.counts.due > 0) {
    URL.revokeObjectURL(download.href);
    download.href = URL.createObjectURL(mine.csv());
    download.hidden = false;
  }
}

/** What a person is offered at first, without what this page cannot do. */
function possible(settings) {
  if (settings.timer !== "wait" || globalThis.crossOriginIsolated) {
    return settings;
  }
  document.getElementById("note").textContent =
    "This page is not cross-origin isolated, so timer channel is chosen instead of wait.";
  return { ...settings, timer: "channel" };
}

function open() {
  const standard = readSettings("");
  display.state("ready", "");
  try {
    const asked = readSettings(location.search);
    if (asked.run) {
      form.show(asked.settings);
      start(asked);
    } else {
      form.show(possible(asked.settings));
    }
  } catch (invalid) {
    form.show(possible(standard.settings));
    if (new URLSearchParams(location.search).get("run") === "1") {
      // Through the plant, so that the launcher hears of it.
      start({ ...standard, run: true, invalid });
    } else {
      display.state("failed", `This page's address: ${invalid.message}`);
    }
  }
}

open();
