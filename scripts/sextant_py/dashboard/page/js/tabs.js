// One tab a drive.

import { element, setText } from "./format.js";

export class DriveTabs {
  constructor(node, selected) {
    this.node = node;
    this.onSelect = selected;
    this.selected = null;
    this.tabs = new Map();
    node.addEventListener("keydown", (event) => this.step({ ArrowRight: 1, ArrowLeft: -1 }[event.key]));
  }

  show(drives, stateOf) {
    for (const drive of drives) {
      if (!this.tabs.has(drive.drive_id)) this.add(drive.drive_id);
      const dot = this.tabs.get(drive.drive_id).querySelector(".dot");
      dot.dataset.state = drive.timed_out ? "timed-out" : (stateOf(drive) ?? "none");
    }
    if (this.selected === null && drives.length) this.select(drives[0].drive_id);
  }

  add(drive) {
    const attributes = { type: "button", role: "tab", "aria-selected": false, "aria-controls": "drive", tabindex: -1 };
    const tab = element("button", attributes, element("span", { class: "dot" }), `Drive ${drive}`);
    tab.addEventListener("click", () => this.select(drive));
    this.tabs.set(drive, tab);
    const sorted = [...this.tabs.keys()].sort((a, b) => a - b).map((key) => this.tabs.get(key));
    this.node.replaceChildren(...sorted);
  }

  select(drive) {
    if (drive === this.selected) return;
    this.selected = drive;
    for (const [key, tab] of this.tabs) {
      tab.setAttribute("aria-selected", key === drive);
      tab.tabIndex = key === drive ? 0 : -1;
    }
    document.getElementById("drive").setAttribute("aria-label", `Drive ${drive}`);
    setText(document.querySelector("title"), `Drive ${drive} – Sextant`);
    this.onSelect(drive);
  }

  step(by) {
    const keys = [...this.tabs.keys()].sort((a, b) => a - b);
    if (!by || keys.length < 2) return;
    this.select(keys[(keys.indexOf(this.selected) + by + keys.length) % keys.length]);
    this.tabs.get(this.selected).focus();
  }
}
