// The panel of the two cursors: their times, and the value of every signal at each and between them.

import { element, number, quantity, setText } from "./format.js";

export class CursorPanel {
  constructor(node, panels, view) {
    this.view = view;
    this.node = node;
    this.sliders = ["A", "B"].map((letter, index) => this.addSlider(letter, index));
    const columns = ["signal", "A", "B", "B − A", "mean A to B"].map((text) => element("th", { scope: "col" }, text));
    const body = element("tbody");
    this.node.append(element("table", {}, element("thead", {}, element("tr", {}, ...columns)), body));
    this.time = this.addRow(body, "time");
    this.rate = this.addRow(body, "1 / (B − A)");
    this.rows = panels.flatMap(({ title, unit, lines }) =>
      lines.map(({ signal, label }) => ({ signal, unit, cells: this.addRow(body, `${title}, ${label} [${unit}]`) })),
    );
  }

  addSlider(letter, index) {
    const slider = element("input", { type: "range", min: -1, max: 0, step: 0.001, "aria-label": `Cursor ${letter}` });
    const output = element("output");
    slider.addEventListener("input", () => {
      const [from, to] = this.view.range();
      this.view.setCursor(index, to + Number(slider.value) * (to - from));
    });
    const mark = element("span", { class: letter.toLowerCase() }, letter);
    this.node.append(element("label", {}, mark, slider, output));
    return { slider, output };
  }

  addRow(body, label) {
    const cells = Array.from({ length: 4 }, () => element("td"));
    body.append(element("tr", {}, element("th", { scope: "row" }, label), ...cells));
    return cells;
  }

  show(history, origin) {
    this.node.hidden = !this.view.hasCursors;
    if (this.node.hidden || !history || history.isEmpty) return;
    const times = this.view.cursorTimes();
    times.forEach((time, index) => {
      const { slider, output } = this.sliders[index];
      if (document.activeElement !== slider) slider.value = this.view.cursors[index];
      const text = `${quantity(time, "s")} s`;
      slider.setAttribute("aria-valuetext", text);
      setText(output, text);
    });
    this.showTable(history, origin, times);
  }

  showTable(history, origin, [a, b]) {
    const apart = b - a;
    this.fill(this.time, [a, b, apart, null].map((value) => (value === null ? "" : `${quantity(value, "s")} s`)));
    this.fill(this.rate, ["", "", apart ? `${number(1 / apart, 2)} Hz` : "–", ""]);
    const [first, second] = [history.nearest(origin + a), history.nearest(origin + b)];
    for (const { signal, unit, cells } of this.rows) {
      const at = (sample) => (sample === null ? NaN : history.value(signal, sample));
      const { mean } = history.summary(signal, origin + Math.min(a, b), origin + Math.max(a, b));
      this.fill(cells, [at(first), at(second), at(second) - at(first), mean].map((value) => quantity(value, unit)));
    }
  }

  fill(cells, texts) {
    texts.forEach((text, index) => setText(cells[index], text));
  }
}
