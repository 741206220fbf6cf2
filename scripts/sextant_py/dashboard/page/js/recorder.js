// Records the telemetry of the drive that is shown, and saves it as a CSV file that scripts/plot and scripts/convert read.

import { count, setText } from "./format.js";

const MOST_ROWS = 300_000; // five minutes at 1 kHz, about 50 MB

export class Recorder {
  constructor(button, columns) {
    this.button = button;
    this.columns = columns;
    this.time = columns.indexOf("t_ns");
    this.stop();
    button.disabled = false;
  }

  get isOn() {
    return this.drive !== null;
  }

  // From the next sample on.
  start(drive) {
    this.drive = drive;
    this.last = null;
    this.show();
  }

  stop() {
    this.drive = null;
    this.rows = 0;
    this.lines = [`${this.columns.join(",")}\n`];
    this.show();
  }

  // last: t_ns of the newest sample before the frame; a server sends older ones again after it was away.
  take({ drive, rows, values }, last) {
    if (drive !== this.drive) return;
    this.last ??= last;
    const lines = [];
    for (let row = 0; row < rows && this.rows < MOST_ROWS; row++) {
      const time = values[this.time * rows + row];
      if (this.last !== null && time <= this.last) continue;
      this.last = time;
      lines.push(this.columns.map((_, column) => cell(values[column * rows + row])).join(","));
      this.rows++;
    }
    if (lines.length) this.lines.push(`${lines.join("\n")}\n`);
    this.show();
    if (this.rows >= MOST_ROWS) this.save();
  }

  save() {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob(this.lines, { type: "text/csv" }));
    link.download = `drive_${this.drive}_${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.csv`;
    this.stop();
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  }

  show() {
    this.button.setAttribute("aria-pressed", this.isOn);
    setText(this.button, this.isOn ? `Save, ${count(this.rows)} samples` : "Record");
  }
}

// Nine digits tell every value of single precision from its neighbours.
function cell(value) {
  if (Number.isNaN(value)) return "";
  return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(9)));
}
