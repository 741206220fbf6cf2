// The scope: a trigger on every control period of the drive, and the newest capture.

import { CursorPanel } from "./cursors.js";
import { count, element, number, setText } from "./format.js";
import { History } from "./history.js";
import { Panel } from "./panel.js";
import { sectorOf } from "./plane.js";
import { TriggerForm } from "./trigger_form.js";
import { CaptureView } from "./view.js";

const FRESH_MS = 500; // for so long the newest locus is shown
// The active vectors by switching state, bits 0 to 2: legs a, b, c high.
const VECTORS = { 1: 1, 3: 2, 2: 3, 6: 4, 4: 5, 5: 6 };
const LEGS_OFF = 0b111000;

export class ScopePanel {
  constructor(node, description, link, changed) {
    this.description = description;
    this.link = link;
    this.changed = changed;
    this.isOn = false;
    this.capture = null;
    this.locusMessage = null;
    this.view = new CaptureView(changed);
    this.isDirty = false;
    this.build(node);
  }

  build(node) {
    const button = (id, text, act) => {
      const made = element("button", { type: "button", id }, text);
      made.addEventListener("click", act);
      return made;
    };
    this.form = new TriggerForm(this.description);
    this.armButton = button("scope-arm", "Arm", () => this.arm());
    this.stopButton = button("scope-stop", "Stop", () => this.stop());
    this.cursorButton = button("scope-cursors", "Cursors", () => this.toggleCursors());
    this.wholeButton = button("scope-whole", "Whole capture", () => this.view.unzoom());
    this.download = element("a", { id: "scope-download", class: "button", hidden: "", download: "" }, "Download .h5");
    this.say = element("p", { id: "scope-say", class: "quiet", role: "status", "aria-live": "polite" });
    this.caption = element("p", { id: "scope-caption" });
    this.cursorNode = element("div", { class: "cursor-panel", hidden: "" });
    this.plots = element("div", { class: "plots", hidden: "" });
    this.panels = this.description.panels.map((panel) => new Panel(panel, this.view, "capture"));
    this.plots.append(...this.panels.map((panel) => panel.node));
    this.cursors = new CursorPanel(this.cursorNode, this.description.panels, this.view);
    const buttons = element("div", { class: "toolbar" }, this.armButton, this.stopButton, this.say);
    this.tools = element("div", { class: "toolbar", hidden: "" }, this.caption, this.wholeButton, this.cursorButton, this.download);
    const title = element("h2", { id: "scope-title" }, "Scope ", element("small", { class: "quiet" }, "every control period"));
    node.append(title, this.form.node, buttons, this.tools, this.cursorNode, this.plots);
    this.showStanding();
  }

  arm() {
    this.isOn = true;
    this.link.send({ type: "scope", on: true, ...this.form.settings() });
    this.standing = null;
    this.showStanding("arming");
  }

  stop() {
    this.isOn = false;
    this.link.send({ type: "scope", on: false });
    this.showStanding();
  }

  // A new connection has no scope on the server.
  reconnect() {
    if (this.isOn) this.arm();
  }

  changeDrive() {
    if (this.isOn) this.stop();
  }

  refuse(text) {
    this.isOn = false;
    this.showStanding(text.charAt(0).toUpperCase() + text.slice(1));
  }

  toggleCursors() {
    this.view.hasCursors = !this.view.hasCursors;
    this.cursorButton.setAttribute("aria-pressed", this.view.hasCursors);
    this.isDirty = true;
    this.changed();
  }

  takeReport(report) {
    if (!this.isOn) return;
    this.standing = report;
    const lost = report.lost ? `; ${count(report.lost)} batches lost` : "";
    const waiting = report.rows ? `waiting for: ${report.trigger}` : (report.problem ?? "waiting for the waveform");
    const texts = { waiting, triggered: "triggered", stopped: "stopped after the capture; Arm waits for the next one" };
    const captures = report.captures ? `; ${count(report.captures)} ${report.captures === 1 ? "capture" : "captures"}` : "";
    const unshown = report.unshown ? `; ${count(report.unshown)} not shown: this page is too slow` : "";
    this.showStanding(`${texts[report.state]}${captures}${unshown}${lost}`, report.state);
    if (report.state === "stopped") this.stop();
  }

  showStanding(text = "off: the drive publishes its waveform only while a scope is on", state = "") {
    if (!(this.standing?.state === "stopped" && !this.isOn)) setText(this.say, text);
    this.say.dataset.state = state;
    this.stopButton.disabled = !this.isOn;
    this.armButton.setAttribute("aria-pressed", this.isOn);
  }

  describe(message) {
    this.message = message;
  }

  takeCapture({ number: name, rows, values, columns }) {
    const capacity = 2 ** Math.ceil(Math.log2(Math.max(rows, 2)));
    const gap = 1.5e-9 * this.message.period_ns;
    this.capture = new History(this.description.columns, { capacity, gap });
    this.capture.append({ rows, columns, values });
    this.view.whole = [this.capture.timeAt(this.capture.begin), this.capture.lastTime()];
    this.view.zoom = null;
    const { trigger, missing } = this.message;
    const [from, to] = this.view.whole.map((time) => number(time * 1e3, 1));
    const lost = missing ? `, ${count(missing)} missing` : "";
    setText(this.caption, `Capture ${name}: ${trigger}, ${from} … ${to} ms, ${count(rows)} control periods${lost}`);
    this.download.href = `captures/${name}.h5`;
    for (const node of [this.tools, this.plots, this.download]) node.hidden = false;
    this.isDirty = true;
    this.changed();
  }

  takeLocus(message) {
    this.locusMessage = message;
    this.locusAt = performance.now();
  }

  // For the α–β plane: the flux of the newest control periods and the vector applied; null while there is none.
  locus() {
    const message = this.locusMessage;
    if (!this.isOn || !message || performance.now() - this.locusAt > FRESH_MS) return null;
    const trail = message.alpha.map((alpha, index) => ({ alpha, beta: message.beta[index] }));
    const last = trail.at(-1);
    const sector = message.sector || sectorOf(last.alpha, last.beta);
    const isOff = (message.switch_state & LEGS_OFF) !== 0;
    const vector = isOff ? null : (VECTORS[message.switch_state & 7] ?? null);
    const vectorText = isOff ? "gates off" : vector ? `V${vector}` : message.switch_state & 7 ? "V7 (zero)" : "V0 (zero)";
    return { trail, sector, vector, vectorText };
  }

  rebuild() {
    for (const panel of this.panels) if (panel.plot) panel.build();
    this.isDirty = true;
  }

  resize() {
    for (const panel of this.panels) panel.resize();
    this.isDirty = true;
  }

  show() {
    this.wholeButton.disabled = this.view.zoom === null;
    const shown = `${this.view.range()} ${this.view.cursors} ${this.view.hasCursors}`;
    if (!this.capture || (!this.isDirty && shown === this.shown)) return;
    this.isDirty = false;
    this.shown = shown;
    for (const panel of this.panels) panel.draw(this.capture, 0);
    this.cursors.show(this.capture, 0);
  }
}
