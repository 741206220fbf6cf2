// One plot: lines and a band over time, with their values beside the title.

import uPlot from "../vendor/uplot/uPlot.esm.js";
import { colour, element, quantity, resolution, setText, unitText } from "./format.js";

// Where request, estimate and reference agree, each of them is still seen.
const LINE = { width: 1.5, points: { show: false } };
const STYLES = [{ width: 5 }, {}, { dash: [6, 5] }];
const HEIGHT = { wide: 230, narrow: 160 };

const hasRequest = (panel) => panel.lines.some(({ label }) => label === "request");

function colourOf(panel, index) {
  const single = panel.lines.length === 1;
  const isPhases = panel.lines.length > 1 && !hasRequest(panel);
  return colour(isPhases ? `--phase-${index % 3}` : `--series-${single ? 1 : index % 3}`);
}

export class Panel {
  constructor(description, view, sync) {
    this.description = description;
    this.view = view;
    this.sync = sync;
    this.columns = description.lines.map(({ signal }) => ({ name: signal, keep: "both" }));
    const { band } = description;
    if (band) this.columns.push({ name: band.low, keep: "min" }, { name: band.high, keep: "max" });
    this.plot = null;
    this.hovered = null;
    this.node = this.makeNode();
  }

  makeNode() {
    const { title, unit, lines, band, wide, key } = this.description;
    const heading = element("h2", {}, `${title} `, element("small", {}, unitText(unit)));
    const header = element("header", {}, heading);
    this.outputs = lines.map((line) => this.addKey(header, line.label, line.text, "line"));
    if (band) this.range = this.addKey(header, wide ? "min … max" : "", band.text, "area");
    this.place = element("div", { class: "plot" });
    const size = wide ? "panel wide" : "panel";
    return element("section", { class: size, "aria-label": `${title}, ${unit}`, "data-panel": key }, header, this.place);
  }

  addKey(header, label, text, kind) {
    const mark = element("i", { class: kind });
    const output = element("output", kind === "area" ? { class: "range" } : {});
    header.append(element("span", { class: "key", title: text }, mark, label, output));
    return output;
  }

  // Made anew where the colours change.
  build() {
    this.plot?.destroy();
    const { lines, band } = this.description;
    const colours = lines.map((_, index) => colourOf(this.description, index));
    const marks = this.node.querySelectorAll(".key i");
    marks.forEach((mark, index) => (mark.style.background = colours[index] ?? colour("--band")));
    const styles = hasRequest(this.description) ? STYLES : [];
    const series = [{}, ...colours.map((stroke, index) => ({ ...LINE, stroke, ...styles[index] }))];
    const bands = [];
    if (band) {
      const edge = { ...LINE, stroke: colour("--band"), width: 1 };
      series.push({ ...edge }, { ...edge });
      bands.push({ series: [series.length - 1, series.length - 2], fill: colour("--band") });
    }
    const options = { ...this.size(), series, bands, axes: this.axes(), scales: this.scales() };
    Object.assign(options, { legend: { show: false }, cursor: this.cursor(), hooks: this.hooks(), padding: [8, 22, 0, 0] });
    this.plot = new uPlot(options, [[], ...this.columns.map(() => [])], this.place);
  }

  size() {
    return { width: Math.max(this.place.clientWidth, 120), height: this.description.wide ? HEIGHT.wide : HEIGHT.narrow };
  }

  axes() {
    const common = { stroke: colour("--quiet"), font: "11px system-ui, sans-serif", grid: { stroke: colour("--grid"), width: 1 } };
    common.ticks = { stroke: colour("--line"), width: 1, size: 4 };
    const time = { ...common, size: 26, space: 60, values: (_, splits) => splits.map((value) => timeLabel(value, splits)) };
    return [time, { ...common, size: 54, space: 28 }];
  }

  scales() {
    return {
      x: { time: false, range: () => this.view.range() },
      y: { range: (_, low, high) => padded(low, high, 50 * resolution(this.description.unit)) },
    };
  }

  cursor() {
    return {
      sync: { key: this.sync, setSeries: false },
      drag: { x: true, y: false, setScale: false },
      points: { show: false },
    };
  }

  hooks() {
    return {
      setSelect: [(plot) => this.select(plot)],
      setCursor: [(plot) => this.hover(plot)],
      draw: [(plot) => this.drawMarks(plot)],
      ready: [(plot) => this.listen(plot)],
    };
  }

  listen(plot) {
    plot.over.addEventListener("click", (event) => this.click(plot, event));
    plot.over.addEventListener("dblclick", () => this.view.unzoom());
  }

  select(plot) {
    const { left, width } = plot.select;
    if (width < 6) return;
    const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.view.zoomTo(from, to, this.history);
  }

  click(plot, event) {
    if (!this.view.hasCursors) return;
    this.view.placeCursor(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
  }

  hover(plot) {
    this.hovered = plot.cursor.left >= 0 ? plot.posToVal(plot.cursor.left, "x") : null;
    if (this.history) this.showValues();
  }

  drawMarks(plot) {
    const { view } = this;
    if (view.trigger !== null) mark(plot, view.trigger, "T", "--bad", []);
    if (!view.hasCursors) return;
    const [a, b] = view.cursorTimes();
    mark(plot, a, "A", "--cursor-a", [5, 3]);
    mark(plot, b, "B", "--cursor-b", [5, 3]);
  }

  draw(history, origin) {
    this.history = history;
    this.origin = origin;
    if (!this.plot) this.build();
    const [from, to] = this.view.range();
    const places = Math.max(Math.round(this.plot.bbox.width / devicePixelRatio / 1.5), 50);
    this.plot.setData(history.thinned(this.columns, origin + from, origin + to, origin, places));
    this.showValues();
  }

  // Beside the title: the values under the pointer, else the newest.
  showValues() {
    const { lines, band, unit } = this.description;
    const number = this.hovered === null ? this.history.end - 1 : this.history.nearest(this.origin + this.hovered);
    const value = (name) => (number === null || this.history.isEmpty ? NaN : this.history.value(name, number));
    lines.forEach(({ signal }, index) => setText(this.outputs[index], quantity(value(signal), unit)));
    if (band) setText(this.range, `${quantity(value(band.low), unit)} … ${quantity(value(band.high), unit)}`);
  }

  resize() {
    if (this.plot && this.place.clientWidth !== this.plot.width) this.plot.setSize(this.size());
  }
}

// A vertical line with a letter, where its time is in the plot.
function mark(plot, time, letter, name, dashes) {
  const { ctx, bbox, scales } = plot;
  if (time < scales.x.min || time > scales.x.max) return;
  const x = Math.round(plot.valToPos(time, "x", true)) + 0.5;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = colour(name);
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash(dashes.map((length) => length * devicePixelRatio));
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.font = `bold ${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = "left";
  ctx.fillText(letter, x + 3 * devicePixelRatio, bbox.top + 10 * devicePixelRatio);
  ctx.restore();
}

// Seconds, or milliseconds where the steps are below 10 ms.
function timeLabel(value, splits) {
  const step = Math.abs(splits[1] - splits[0]) || 1;
  const [factor, unit] = step < 0.05 ? [1000, "ms"] : [1, "s"];
  const decimals = Math.max(0, Math.ceil(-Math.log10(step * factor) - 1e-9));
  return `${(value * factor + 0).toFixed(decimals).replace("-", "−")} ${unit}`;
}

// A little room above and below, at least that; a constant is shown in the middle.
function padded(low, high, least) {
  if (low === null || high === null) return [-1, 1];
  const room = Math.max((high - low) * 0.08, high - low < least ? least : 0);
  return [low - room, high + room];
}
