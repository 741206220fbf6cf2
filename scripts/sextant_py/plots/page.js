// Lays the panels of a page out for its width and in the colours of the reader's system.
"use strict";
{
  const figure = document.querySelector(".plotly-graph-div");
  const meta = figure.layout.meta ?? {};
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const NARROW = 700, HEADING = 22, ENTRY = 19, PADDING = 12, GAP = 20; // [px]
  const FOOT = 48;

  function colours() {
    const [paper, text, grid] = dark.matches ? ["#14181d", "#d8dde3", "#2f3740"] : ["#ffffff", "#1f2429", "#e3e6ea"];
    const update = {
      paper_bgcolor: paper, plot_bgcolor: paper, "font.color": text,
      "hoverlabel.bgcolor": paper, "hoverlabel.font.color": text,
    };
    for (const axis of Object.keys(figure.layout).filter((name) => /^[xy]axis\d*$/.test(name))) {
      for (const what of ["gridcolor", "zerolinecolor", "linecolor"]) update[`${axis}.${what}`] = grid;
    }
    return update;
  }

  // Heading, legend and plot of each panel from above, in pixels, then as shares of the height.
  function places(width) {
    const narrow = width < NARROW;
    const margin = { l: Math.max(narrow ? 52 : 72, Math.min(meta.left_px, 0.4 * width)), r: narrow ? 14 : 26, t: 8, b: FOOT };
    let at = 0;
    const spans = meta.panels.map((panel) => {
      const columns = Math.max(1, Math.floor((width - margin.l - margin.r) / (panel.entry_px + 55)));
      const top = at + HEADING + PADDING + ENTRY * Math.ceil(panel.entries / columns);
      const span = { heading: at, top, bottom: top + panel.height_px };
      at = span.bottom + GAP;
      return span;
    });
    const total = at - GAP;
    const update = { margin, width, height: total + margin.t + margin.b };
    meta.panels.forEach((panel, place) => {
      const span = spans[place], share = (px) => Math.min(1, Math.max(0, 1 - px / total));
      update[`${panel.axis}.domain`] = [share(span.bottom), share(span.top)];
      update[`annotations[${place}].y`] = share(span.heading);
      update[`${panel.legend}.y`] = share(span.heading + HEADING);
    });
    return update;
  }

  function arrange() {
    const width = document.documentElement.clientWidth - 16;
    const side = Math.min(width, 800);
    const layout = meta.panels ? places(width) : { width: side, height: side };
    const names = figure.data.flatMap((trace, place) => (trace.meta ? [place] : []));
    const shown = names.map((place) => (figure.data[place].meta === "narrow") === width < NARROW);
    Plotly.update(figure, names.length ? { visible: shown } : {}, { ...colours(), ...layout }, names);
  }

  arrange();
  dark.addEventListener("change", arrange);
  let last = document.documentElement.clientWidth;
  addEventListener("resize", () => {
    if (document.documentElement.clientWidth === last) return;
    last = document.documentElement.clientWidth;
    arrange();
  });
}
