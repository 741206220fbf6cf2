// The page as a vehicle control unit: it renews its demand ten times a second while it commands and is in view.

import { element, number, quantity, setText } from "./format.js";
import { token } from "./token.js";
import { WrongFrames } from "./wrong_frames.js";

const RENEW_MS = 100;
const RESET_MS = 300;
const TEMPERATURES = [
  ["stator winding", "StatorTemperature"],
  ["rotor", "RotorTemperature"],
  ["inverter", "InverterTemperature"],
];

export class CommandPanel {
  constructor(link) {
    this.link = link;
    this.node = document.getElementById("command");
    this.node.classList.add("command");
    this.standing = null; // the server's newest report on who commands
    this.demand = { torque_nm: 0, enable: false, fault_reset: false };
    this.refusal = "";
    this.build();
    setInterval(() => this.renew(), RENEW_MS);
    document.addEventListener("keydown", (event) => event.key === "Escape" && this.isMine && this.disable());
  }

  get isMine() {
    return Boolean(this.standing?.is_mine);
  }

  build() {
    const button = (id, text, act, attributes = {}) => {
      const made = element("button", { type: "button", id, ...attributes }, text);
      made.addEventListener("click", act);
      return made;
    };
    this.take = button("take", "Take control", () => this.takeControl());
    this.release = button("release", "Release", () => this.leave());
    this.enable = button("enable", "Enable", () => this.enableDrive());
    this.stop = button("disable", "Disable", () => this.disable(), { class: "stop", title: "Escape" });
    this.reset = button("reset", "Reset faults", () => this.resetFaults());
    this.zero = button("zero", "0 N·m", () => this.setTorque(0));
    this.slider = element("input", { type: "range", id: "torque-slider", step: 0.5, "aria-label": "Torque request, N·m" });
    this.entry = element("input", { type: "number", id: "torque", step: 0.5, "aria-label": "Torque request, N·m" });
    this.slider.addEventListener("input", () => this.setTorque(Number(this.slider.value)));
    this.entry.addEventListener("change", () => this.setTorque(Number(this.entry.value)));
    this.bus = element("p", { class: "quiet bus" });
    this.say = element("p", { class: "say quiet", role: "status", "aria-live": "polite" });
    this.reported = element("dl", { class: "values" });
    const unit = element("span", { class: "quiet" }, "N·m");
    this.controls = element("div", {}, element("div", { class: "row" }, this.enable, this.stop));
    this.controls.append(this.slider, element("div", { class: "row" }, this.entry, unit, this.zero));
    this.wrong = new WrongFrames(this.link);
    this.controls.append(element("div", { class: "row" }, this.reset, this.release), this.reported, this.wrong.node);
    const title = element("h2", { id: "command-title" }, "Command over CAN");
    this.node.append(title, element("div", { class: "row" }, this.take), this.controls, this.say, this.bus);
    this.show();
  }

  takeControl() {
    this.refusal = "";
    this.demand = { torque_nm: 0, enable: false, fault_reset: false };
    this.setTorque(0);
    this.link.send({ type: "take", token: token() });
  }

  leave() {
    this.demand.enable = false;
    this.link.send({ type: "release" });
  }

  enableDrive() {
    this.setTorque(0);
    this.demand.enable = true;
    this.renew();
    this.show();
  }

  disable() {
    this.setTorque(0);
    this.demand.enable = false;
    this.renew();
    this.show();
  }

  resetFaults() {
    this.disable();
    this.demand.fault_reset = true;
    setTimeout(() => (this.demand.fault_reset = false), RESET_MS);
    this.renew();
  }

  setTorque(torque) {
    const limit = this.standing?.torque_limit_nm ?? 0;
    this.demand.torque_nm = Math.min(Math.max(Number.isFinite(torque) ? torque : 0, -limit), limit);
    this.slider.value = this.entry.value = this.demand.torque_nm;
    this.renew();
  }

  // A page out of view does not command.
  renew() {
    if (this.isMine && document.visibilityState === "visible") this.link.send({ type: "demand", ...this.demand });
  }

  refuse(text) {
    this.refusal = text;
    this.show();
  }

  update(standing) {
    const wasMine = this.isMine;
    this.standing = standing;
    if (wasMine && !this.isMine) this.demand.enable = false;
    if (this.isMine && standing.tripped && this.demand.enable) {
      this.refusal = `The drive did not stay enabled (${standing.first_fault ?? standing.drive_state ?? "no status frames"}).`;
      this.disable();
    }
    this.show();
  }

  lost() {
    if (this.standing) this.update({ ...this.standing, is_mine: false, holder: null, is_sending: false });
  }

  show() {
    const s = this.standing ?? { allowed: false };
    this.node.hidden = !this.standing;
    setText(this.bus, s.bus ?? "");
    const mayTake = s.allowed && !s.holder && !s.has_ended && Boolean(token());
    this.take.parentElement.hidden = this.isMine || !s.allowed;
    this.take.disabled = !mayTake;
    this.controls.hidden = !this.isMine;
    for (const input of [this.slider, this.entry]) {
      input.min = -(s.torque_limit_nm ?? 0);
      input.max = s.torque_limit_nm ?? 0;
      input.disabled = !this.demand.enable;
    }
    if (this.isMine && document.activeElement !== this.entry) this.entry.value = this.demand.torque_nm;
    this.enable.disabled = this.demand.enable || !s.ready;
    this.enable.setAttribute("aria-pressed", this.demand.enable);
    this.stop.disabled = !this.demand.enable;
    this.reset.disabled = s.drive_state !== "FAULT";
    this.zero.disabled = !this.demand.enable;
    const [text, isBad] = this.sentence(s);
    setText(this.say, text);
    this.say.classList.toggle("bad", isBad);
    this.wrong.show(s.wrong_frames);
    if (this.isMine) this.showReport(s);
  }

  sentence(s) {
    if (!s.allowed) return ["Commands are off; start the dashboard with --allow-command.", false];
    if (this.refusal) return [this.refusal, true];
    if (s.has_ended) return ["The process that commands has ended; restart the dashboard.", true];
    if (s.problem) return [s.problem, true];
    if (s.holder && !this.isMine) return [`${s.holder} commands.`, false];
    if (!token()) return ["This page has no token; open it by the address that the dashboard printed.", false];
    if (!this.isMine && s.not_sending) return [`No commands on the bus: ${s.not_sending}.`, false];
    if (!s.drive_state) return [`No status frames of the drive on ${s.bus}.`, true];
    if (s.first_fault) return [`The drive is in FAULT (${s.first_fault}).`, true];
    return ["", false];
  }

  showReport(s) {
    const entries = [
      ["drive, over CAN", s.drive_state ?? "–"],
      ["available", `−${number(s.regenerating_nm, 1)} … ${number(s.motoring_nm, 1)} N·m`],
      ...TEMPERATURES.map(([text, name]) => [text, s.temperatures?.[name]])
        .filter(([, value]) => Number.isFinite(value))
        .map(([text, value]) => [text, `${quantity(value, "°C")} °C`]),
    ];
    this.reported.replaceChildren(
      ...entries.flatMap(([label, value]) => [element("dt", {}, label), element("dd", {}, value)]),
    );
  }
}
