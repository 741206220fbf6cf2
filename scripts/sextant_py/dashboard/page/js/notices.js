// What is wrong, in sentences above the plots: no server, no telemetry, topics without samples, torque off the request.

import { element, number, setText } from "./format.js";

const PATIENCE_MS = 300; // a page that has only just been opened is not lost

export class Notices {
  constructor(node) {
    this.node = node;
    this.link = document.getElementById("link");
  }

  show(link, status, drive) {
    const lost = link.lostFor();
    const timedOut = drive?.timed_out;
    const texts = [];
    if (lost > PATIENCE_MS) {
      const seconds = number(lost / 1000, 0);
      texts.push(["bad", `No connection to the dashboard's server for ${seconds} s. This page reconnects by itself.`]);
    } else {
      if (timedOut) {
        const since = `Drive ${drive.drive_id}: no telemetry for ${number(timedOut.age_s, 1)} s`;
        texts.push(["bad", `${since}; ${timedOut.reason}. The last picture stays until it returns.`]);
      }
      if (drive?.deviation_nm && !timedOut) {
        const off = number(Math.abs(drive.deviation_nm), 1);
        const side = drive.deviation_nm > 0 ? "above" : "below";
        texts.push(["", `The torque is ${off} N·m ${side} the request.`]);
      }
      texts.push(...status.problems.map((problem) => ["", problem.charAt(0).toUpperCase() + problem.slice(1)]));
    }
    this.showTexts(texts);
    this.showLink(link, lost, timedOut, drive);
  }

  showTexts(texts) {
    while (this.node.children.length > texts.length) this.node.lastChild.remove();
    texts.forEach(([kind, text], index) => {
      const line = this.node.children[index] ?? this.node.appendChild(element("p"));
      line.className = kind ? `notice ${kind}` : "notice";
      setText(line, text);
    });
  }

  showLink(link, lost, timedOut, drive) {
    let [state, text] = ["live", "live"];
    if (lost || !link.isOpen) [state, text] = lost ? ["lost", "server lost"] : ["connecting", "connecting"];
    else if (!drive) [state, text] = ["none", "no drive found"];
    else if (timedOut) [state, text] = ["timed-out", "no telemetry"];
    this.link.dataset.state = state;
    setText(this.link, text);
  }
}
