// The person's controls: made from choice.js, written as a query, read by setting.js.
//
// So a person's run and a launcher's go through the same checks. What the controls do not hold,
// a start and a clock, keeps its defaults.

import { CHOICES, GROUPS, NUMBERS, PRESET_TEXT } from "./choice.js";
import { sentence } from "./sentence.js";
import { InvalidSettings, PRESETS, WORDS, check, readSettings } from "./setting.js";

/** The controls of the page. */
export class Form {
  /** @type {any} */
  #form;
  /** @type {any} */
  #preset;
  #presetHint;
  #error;
  #changed;

  /** `changed` is called with the settings, or `null` when they cannot be. */
  constructor(changed) {
    this.#form = document.getElementById("settings");
    this.#preset = document.getElementById("preset");
    this.#presetHint = document.getElementById("preset-hint");
    this.#error = document.getElementById("settings-error");
    this.#changed = changed;
    for (const [name, [title]] of Object.entries(PRESET_TEXT)) {
      this.#preset.append(new Option(title, name));
    }
    this.#preset.append(new Option("My own", ""));
    for (const [group, names] of Object.entries(GROUPS)) {
      const place = document.getElementById(group);
      place.append(...names.map((name) => (name in CHOICES ? choice(name) : number(name))));
    }
    this.#preset.addEventListener("change", () => this.#choosePreset());
    this.#form.addEventListener("input", () => this.#look());
  }

  /** Shows these settings. */
  show(settings) {
    for (const name of Object.keys(CHOICES)) {
      const word = settings[name] ?? WORDS[name][0];
      this.#form.elements[name].value = word;
    }
    for (const [name, { setting, factor }] of Object.entries(NUMBERS)) {
      const value = settings[setting];
      const shown = typeof value === "number" ? String(value / factor) : (value ?? "");
      this.#form.elements[name].value = shown;
    }
    this.#look();
  }

  /** What is chosen, as readSettings gives it. Throws what is wrong with it. */
  read() {
    const query = new URLSearchParams();
    for (const name of Object.keys(CHOICES)) {
      query.set(name, this.#form.elements[name].value);
    }
    for (const [name, { label, setting, factor, empty, word }] of Object.entries(NUMBERS)) {
      const text = this.#form.elements[name].value.trim();
      if (text === "" && empty !== undefined) {
        continue;
      }
      const value = Number(text);
      if (text === word) {
        query.set(setting, text);
      } else if (text === "" || !Number.isFinite(value)) {
        throw new InvalidSettings(`${label} \`${text}\` is not a number`);
      } else {
        query.set(setting, String(factor === 1 ? value : Math.round(value * factor)));
      }
    }
    const request = readSettings(query);
    check(request.settings);
    return request;
  }

  /** While a run is on, nothing can be chosen. */
  lock(locked) {
    for (const group of this.#form.querySelectorAll("fieldset.group")) {
      group.disabled = locked;
    }
    this.#preset.disabled = locked;
  }

  #choosePreset() {
    const preset = PRESETS[this.#preset.value];
    if (preset !== undefined) {
      const kept = this.#numbers();
      this.show({ ...preset, ...kept });
    }
  }

  /** What a preset leaves as it is. */
  #numbers() {
    const form = this.#form.elements;
    const ns = (name) => {
      const value = Number(form[name].value) * NUMBERS[name].factor;
      return form[name].value === "" || !Number.isFinite(value) ? null : value;
    };
    return {
      mode: form.mode.value,
      late: form.late.value,
      duration_ns: ns("duration"),
      h_ns: ns("h"),
      r: ns("r"),
      timeout_ns: ns("timeout"),
    };
  }

  /** Brings hints, the preset's name and the error into line with what is chosen. */
  #look() {
    const form = this.#form.elements;
    for (const [name, [, hints]] of Object.entries(CHOICES)) {
      document.getElementById(`${name}-hint`).textContent = hints[form[name].value];
    }
    let request = null;
    try {
      request = this.read();
      this.#error.textContent = "";
    } catch (error) {
      this.#error.textContent = sentence(error.message);
    }
    const unused = form.transport.value === "websocket";
    form.sender[0].closest(".choice").classList.toggle("unused", unused);
    if (unused) {
      document.getElementById("sender-hint").textContent = "Not used with a WebSocket.";
    }
    const name = request === null ? "" : presetOf(request.settings);
    this.#preset.value = name;
    this.#presetHint.textContent = name === "" ? "Chosen by hand, below." : PRESET_TEXT[name][1];
    this.#changed(request);
  }
}

/** The name of the preset that these settings are, or none. */
function presetOf(settings) {
  const same = ([, preset]) =>
    Object.entries(preset).every(([name, value]) => settings[name] === value);
  return Object.entries(PRESETS).find(same)?.[0] ?? "";
}

/** Radio buttons in a row, with the hint of the chosen one below. */
function choice(name) {
  const [legend, hints] = CHOICES[name];
  const set = element("fieldset", { className: "choice" });
  set.append(element("legend", { textContent: legend }));
  const row = element("div", { className: "segments" });
  for (const word of Object.keys(hints)) {
    const label = element("label");
    const radio = element("input", { type: "radio", name, value: word });
    radio.setAttribute("aria-describedby", `${name}-hint`);
    label.append(radio, element("span", { textContent: word }));
    row.append(label);
  }
  set.append(row, element("p", { className: "hint", id: `${name}-hint` }));
  return set;
}

/** A number with its unit. */
function number(name) {
  const { label, unit, empty = "", word } = NUMBERS[name];
  const field = element("div", { className: "number" });
  const title = element("label", { htmlFor: `${name}-number`, textContent: label });
  const input = element("input", {
    type: "text",
    id: `${name}-number`,
    name,
    inputMode: word === undefined ? "decimal" : "text",
    placeholder: empty,
    autocomplete: "off",
    spellcheck: false,
  });
  field.append(title, input, element("span", { className: "unit", textContent: unit }));
  return field;
}

function element(tag, properties = {}) {
  return Object.assign(document.createElement(tag), properties);
}
