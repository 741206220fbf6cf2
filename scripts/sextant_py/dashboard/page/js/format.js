// Numbers as an instrument shows them: with a fixed number of decimals for their unit.

const DECIMALS = { "N·m": 2, "rad/s": 2, rpm: 0, Wb: 4, A: 2, V: 1, kW: 3, W: 0, "°C": 1, "°": 1, s: 4, ms: 3, "1/s": 1, "µs": 1 };

export function number(value, decimals) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

export function quantity(value, unit) {
  return number(value, DECIMALS[unit] ?? 3);
}

// What the last decimal that is shown stands for.
export function resolution(unit) {
  return 10 ** -(DECIMALS[unit] ?? 3);
}

export function unitText(unit) {
  return unit === "1" ? "" : unit;
}

export function count(value) {
  return value === null || value === undefined ? "–" : Math.round(value).toLocaleString("en").replaceAll(",", " ");
}

// The next round number that is not below the value.
export function roundedUp(value) {
  const decade = 10 ** Math.floor(Math.log10(Math.max(value, 1e-9)));
  return [1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].map((step) => step * decade).find((step) => step >= value * 0.9999);
}

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// Replaces the text only where it differs: what does not change is not announced or laid out again.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
