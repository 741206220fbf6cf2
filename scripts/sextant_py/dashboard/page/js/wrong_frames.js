// Wrong frames of the page that commands, each of which the drive has to refuse: the server tells which there are.

import { element } from "./format.js";

const FRAMES = 3;

export class WrongFrames {
  constructor(link) {
    this.link = link;
    this.frames = element("input", { type: "number", min: 1, step: 1, value: FRAMES, "aria-label": "Number of wrong frames" });
    this.buttons = element("div", { class: "choices" });
    const row = element("div", { class: "row" }, this.frames, element("span", { class: "quiet" }, "frames, the next ones"));
    this.node = element("details", { id: "wrong-frames" }, element("summary", {}, "Wrong frames"), row, this.buttons);
  }

  // kinds: their meanings by name
  show(kinds) {
    if (this.buttons.hasChildNodes()) return;
    for (const [kind, meaning] of Object.entries(kinds ?? {})) {
      const button = element("button", { type: "button", "data-wrong": kind, title: meaning }, kind.replaceAll("_", " "));
      button.addEventListener("click", () => this.link.send({ type: "spoil", kind, frames: this.frames.valueAsNumber }));
      this.buttons.append(button);
    }
  }
}
