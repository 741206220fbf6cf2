// The settings of a trigger as controls; the forms of a trigger come from the server.

import { element } from "./format.js";

export class TriggerForm {
  // triggers: texts by form ("rise SIGNAL LEVEL [HYSTERESIS]"), signals: units by name, modes: names.
  constructor({ triggers, signals, modes }) {
    this.node = element("form", { class: "trigger" });
    this.node.addEventListener("submit", (event) => event.preventDefault());
    const forms = Object.entries(triggers).map(([form, text]) => element("option", { value: form, title: text }, text));
    this.form = this.add("trigger", element("select", { id: "trigger" }, ...forms), "Trigger");
    const states = /: (.*)$/.exec(triggers["state NAME"] ?? "")?.[1].split(", ") ?? [];
    this.state = this.add("NAME", element("select", {}, ...states.map((name) => element("option", {}, name))), "State");
    const options = Object.entries(signals).map(([name, unit]) => element("option", { value: name }, `${name} [${unit}]`));
    this.signal = this.add("SIGNAL", element("select", {}, ...options), "Signal");
    this.level = this.add("LEVEL", this.number(0), "Level");
    this.size = this.add("SIZE", this.number(5), "Size, N·m");
    this.hysteresis = this.add("HYSTERESIS", this.number(0), "Hysteresis");
    this.mode = this.add("", element("select", {}, ...modes.map((name) => element("option", {}, name))), "Mode");
    this.mode.value = "single";
    this.before = this.add("", this.number(20), "Before, ms");
    this.after = this.add("", this.number(50), "After, ms");
    this.holdOff = this.add("", this.number(0), "Hold-off, ms");
    this.form.addEventListener("change", () => this.show());
    this.show();
  }

  number(value) {
    return element("input", { type: "number", step: "any", value });
  }

  add(part, control, label) {
    this.node.append(element("label", { "data-part": part }, label, control));
    return control;
  }

  // The controls that the form of the trigger has a place for.
  show() {
    for (const label of this.node.querySelectorAll("[data-part]")) {
      const { part } = label.dataset;
      label.hidden = part === part.toUpperCase() && part !== "" && !this.form.value.includes(part);
    }
  }

  settings() {
    const values = { NAME: this.state, SIGNAL: this.signal, LEVEL: this.level, SIZE: this.size, HYSTERESIS: this.hysteresis };
    const text = this.form.value.replace(/[[\]]/g, "").replace(/[A-Z]+/g, (part) => values[part].value);
    return {
      trigger: text,
      mode: this.mode.value,
      before_ms: Number(this.before.value),
      after_ms: Number(this.after.value),
      hold_off_ms: Number(this.holdOff.value),
    };
  }
}
