// Changes of the drive's state and its faults, the newest on top.

import { element, number } from "./format.js";

export class EventList {
  constructor(node) {
    this.node = node;
    this.shown = "";
  }

  show(events) {
    const key = JSON.stringify(events.map(({ t_ns, state, gone }) => [t_ns, state, gone]));
    if (key === this.shown) return;
    this.shown = key;
    const items = events.toReversed().map((event) => element("li", {}, timeOf(event), ` ${textOf(event)}`));
    this.node.replaceChildren(...(items.length ? items : [element("li", { class: "quiet" }, "none yet")]));
  }
}

// The time of day here, to the millisecond; under the pointer that of the drive's clock.
function timeOf({ time_s, t_ns }) {
  const time = new Date(time_s * 1000);
  const parts = [time.getHours(), time.getMinutes(), time.getSeconds()].map((part) => String(part).padStart(2, "0"));
  const text = `${parts.join(":")}.${String(time.getMilliseconds()).padStart(3, "0")}`;
  return element("time", { datetime: time.toISOString(), title: `${number(t_ns * 1e-9, 6)} s on the drive's clock` }, text);
}

function textOf({ from, state, latched, gone, reset, reason }) {
  const parts = [from ? `${from} → ${state}` : state];
  if (latched.length) parts.push(latched.join(", "));
  else if (from && reason) parts.push(reason);
  if (reset) parts.push("faults reset");
  else if (gone.length) parts.push(`no longer present: ${gone.join(", ")}`);
  return parts.join("; ");
}
