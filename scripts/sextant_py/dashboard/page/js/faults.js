// Faults for the simulated plant: what there is to choose is told by the program that takes them.

import { element, setText } from "./format.js";

const KIND = "kind";
const NONE = "none"; // the kind that ends a fault
const REPLY_MS = 6000; // longest time from a request for the keys to its reply
const PAUSE_MS = 1000; // from a refusal to the next request for the keys

function words(name) {
  return name.replaceAll("_", " ");
}

export class FaultPanel {
  constructor(link) {
    this.link = link;
    this.node = document.getElementById("plant-faults");
    this.buttons = element("div", { class: "choices" });
    this.fields = element("div", { class: "fields" });
    this.inputs = new Map();
    this.say = element("p", { class: "say quiet", role: "status", "aria-live": "polite" });
    const more = element("details", {}, element("summary", {}, "Values"), this.fields);
    this.node.append(element("h2", { id: "plant-faults-title" }, "Faults of the plant"), this.buttons, more, this.say);
    this.node.hidden = true;
    this.nextAsk = 0; // by performance.now() [ms]
  }

  // While the page commands a drive whose plant takes faults; called several times a second then.
  show(isOn) {
    if (isOn && this.node.hidden) {
      this.tell("");
      this.nextAsk = 0;
      this.ask();
    } else if (isOn && !this.buttons.hasChildNodes()) {
      this.ask();
    }
    this.node.hidden = !isOn;
  }

  // The program may start later than the page.
  ask() {
    const now = performance.now();
    if (now < this.nextAsk) return;
    this.nextAsk = now + REPLY_MS;
    this.link.send({ type: "fault_keys" });
  }

  tell(text, isBad = false) {
    setText(this.say, text);
    this.say.classList.toggle("bad", isBad);
  }

  describe(keys) {
    this.tell("");
    const kind = keys.find(({ key }) => key === KIND);
    const made = (kind?.choices ?? []).map((name) => {
      const text = name === NONE ? "No fault" : words(name);
      const button = element("button", { type: "button", "data-kind": name }, text);
      button.addEventListener("click", () => this.give(name));
      return button;
    });
    this.buttons.replaceChildren(...made);
    this.buttons.title = kind?.meaning ?? "";
    this.inputs.clear();
    const others = keys.filter(({ key }) => key !== KIND);
    this.fields.replaceChildren(...others.map((key) => this.field(key)));
  }

  // A value that is left empty is that of the program's file.
  field({ key, unit, meaning, choices, least, most }) {
    const input = choices
      ? element("select", {}, element("option", { value: "" }, "as in the file"))
      : element("input", { type: "number", step: "any", min: least, max: most, placeholder: "as in the file" });
    for (const choice of choices ?? []) input.append(element("option", { value: choice }, choice));
    this.inputs.set(key, input);
    return element("label", { title: meaning }, `${key}${unit ? ` [${unit}]` : ""}`, input);
  }

  give(kind) {
    const values = { [KIND]: kind };
    for (const [key, input] of this.inputs) {
      if (kind === NONE || input.value === "") continue;
      values[key] = input.type === "number" ? input.valueAsNumber : input.value;
    }
    this.link.send({ type: "fault", values });
  }

  takeReply({ problem, kind }) {
    this.nextAsk = performance.now() + PAUSE_MS;
    const done = kind === NONE ? "No fault from now on." : `The plant has: ${words(kind ?? "")}.`;
    this.tell(problem ?? done, Boolean(problem));
  }
}
