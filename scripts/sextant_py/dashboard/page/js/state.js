// State, readings and faults of one drive.

import { element, quantity, setText } from "./format.js";

const READINGS = [
  ["Torque", "torque_mean_nm", "N·m"],
  ["Request", "torque_requested_nm", "N·m"],
  ["Speed", "speed_rad_s", "rad/s"],
  ["Stator flux", "flux_mean_wb", "Wb"],
  ["Current", "current_mean_a", "A"],
  ["DC link", "u_dc_v", "V"],
  ["Power", "power_w", "W"],
];
const MEAN_S = 0.1; // what a person can read

export class StateView {
  constructor(faults) {
    this.texts = faults;
    this.box = document.getElementById("state");
    this.name = document.getElementById("state-name");
    this.reason = document.getElementById("state-reason");
    this.faults = document.getElementById("faults");
    this.readings = document.getElementById("readings");
    this.shown = "";
    this.outputs = READINGS.map(([label, name, unit]) => {
      const value = element("output", { "data-reading": name });
      this.readings.append(element("div", {}, element("dt", {}, label), element("dd", {}, value, element("small", {}, unit))));
      return value;
    });
  }

  // state: name by the newest telemetry; drive: the server's status of it, null without one.
  show(state, drive, history) {
    const isTimedOut = Boolean(drive?.timed_out);
    this.box.dataset.state = state ?? "none";
    this.box.classList.toggle("timed-out", isTimedOut);
    this.readings.classList.toggle("timed-out-values", isTimedOut);
    setText(this.name, isTimedOut ? `${state ?? "no telemetry"} (last received)` : (state ?? "no drive"));
    setText(this.reason, reasonOf(drive?.state));
    this.showReadings(history);
    this.showFaults(drive?.state);
  }

  showReadings(history) {
    const to = history && !history.isEmpty ? history.lastTime() : 0;
    READINGS.forEach(([, name, unit], index) => {
      const mean = history ? history.summary(name, to - MEAN_S, to).mean : NaN;
      setText(this.outputs[index], quantity(mean, unit));
    });
  }

  showFaults(state) {
    const [active, latched] = [state?.active ?? [], state?.latched ?? []];
    const names = [...new Set([...latched, ...active])];
    const key = JSON.stringify([active, latched, state?.reason]);
    if (key === this.shown) return;
    this.shown = key;
    this.faults.hidden = names.length === 0;
    const items = names.map((name) => {
      const presence = active.includes(name) ? "present" : "latched, no longer present";
      const text = this.texts[name] ? ` ${this.texts[name]}` : "";
      return element("li", {}, element("b", {}, name), ` (${presence})${text ? `:${text}` : ""}`);
    });
    const heading = element("strong", {}, `${names.length === 1 ? "Fault" : `${names.length} faults`}: ${state?.reason ?? ""}`);
    this.faults.replaceChildren(heading, element("ul", {}, ...items));
  }
}

function reasonOf(state) {
  if (!state) return "";
  const lockout = state.lockout ? "locked out until a valid disable" : "";
  return [state.reason, lockout].filter(Boolean).join("; ");
}
