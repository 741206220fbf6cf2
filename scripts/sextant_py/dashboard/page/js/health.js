// Real-time health of the control thread, and what became of its telemetry.

import { count, element, number, setText } from "./format.js";

const CAUSES = {
  overruns_machine: "by the machine",
  overruns_late_wake: "late wake-up",
  overruns_stage_gap: "gap in a stage",
  overruns_own_execution: "own execution",
};
const QUANTILES = { p50: "p50", p99: "p99", p99_9: "p99.9", max: "max" };
const DISTRIBUTIONS = { wake_latency: "wake-up latency", execution: "execution" };

function rows(list, entries) {
  const nodes = entries.flatMap(([label, value, isBad]) => [
    element("dt", {}, label),
    element("dd", isBad ? { class: "bad" } : {}, value),
  ]);
  list.replaceChildren(...nodes);
}

export class HealthView {
  // rejections: what counts rejected command frames, and the cause of each.
  constructor(rejections) {
    this.rejections = Object.entries(rejections);
    this.counts = element("dl", { class: "values" });
    this.table = element("table", { class: "latency" });
    this.rights = element("p", { class: "quiet" });
    document.getElementById("health").append(this.counts, this.table, this.rights);
    this.telemetry = document.getElementById("telemetry");
    this.shown = "";
  }

  show(statistics, drive, history) {
    const key = JSON.stringify([statistics?.sequence, drive?.received, drive?.lost, history?.missed]);
    if (key === this.shown) return;
    this.shown = key;
    if (statistics) this.showStatistics(statistics);
    else setText(this.rights, "no statistics yet");
    this.showTelemetry(statistics, drive, history);
  }

  showStatistics(s) {
    const inUse = s.r_s_ohm
      ? [
          ["R_s in use", `${number(s.r_s_ohm, 3)} Ω ± ${number(s.r_s_deviation * 100, 0)} %`],
          ["R_r in use", `${number(s.r_r_ohm, 3)} Ω ± ${number(s.r_r_deviation * 100, 0)} %`],
          ["L_m in use", `${number(s.l_m_h * 1e3, 1)} mH ± ${number(s.l_m_deviation * 100, 0)} %`],
        ]
      : [];
    const causes = Object.entries(CAUSES).filter(([name]) => s[name]).map(([name, text]) => [`– ${text}`, count(s[name])]);
    rows(this.counts, [
      ["period × wake-up", `${number(s.period_ns / 1e3, 0)} µs × ${s.wake_every_periods}`],
      ["control periods", count(s.periods)],
      ["missed", count(s.periods_missed), s.periods_missed > 0],
      ["overruns", count(s.overruns), s.overruns > 0],
      ...causes,
      ...(s.periods_unchecked ? [["without checks of currents and speed", count(s.periods_unchecked), true]] : []),
      ...inUse,
      ...(s.winding_temperature_k ? [["winding", `${number(s.winding_temperature_k - 273.15, 0)} °C`]] : []),
    ]);
    const head = element("tr", {}, element("th", { scope: "col" }, "µs, last interval"));
    head.append(...Object.values(QUANTILES).map((text) => element("th", { scope: "col" }, text)));
    const body = Object.entries(DISTRIBUTIONS).map(([name, text]) => {
      const cells = Object.keys(QUANTILES).map((part) => element("td", {}, number(s[`${name}_${part}_us`], 0)));
      return element("tr", {}, element("th", { scope: "row" }, text), ...cells);
    });
    this.table.replaceChildren(element("thead", {}, head), element("tbody", {}, ...body));
    const priority = s.real_time_scheduling ? `SCHED_${s.policy}` : "no real-time priority";
    setText(this.rights, `${priority}, wait ${s.wait.toLowerCase()}, memory ${s.memory_locked ? "" : "not "}locked`);
  }

  showTelemetry(statistics, drive, history) {
    rows(this.telemetry, [
      ["samples received", count(drive?.received)],
      ["lost on the network", count(drive?.lost), drive?.lost > 0],
      ["lost to this page", count(history?.missed), history?.missed > 0],
      ["periods dropped by the drive", count(statistics?.telemetry_dropped), statistics?.telemetry_dropped > 0],
      ["commands accepted", count(statistics?.commands_received)],
      ["commands rejected", count(statistics?.commands_rejected)],
      ...this.rejections
        .filter(([name]) => statistics?.[name])
        .map(([name, text]) => [`– ${text}`, count(statistics[name])]),
    ]);
  }
}
