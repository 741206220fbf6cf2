// The stator flux in the α–β plane: its trajectory, the six sectors centred on the active vectors, the vector applied.

import { colour, roundedUp } from "./format.js";

const TRAIL_S = 0.25;
const ARROW = 8;
const SMALLEST_WB = 0.1; // of the edge
const NO_FLUX_WB = 0.01; // below it there is no sector

export class Plane {
  constructor(canvas) {
    this.canvas = canvas;
    this.scale = SMALLEST_WB; // at the edge [Wb]
  }

  // trail: [{alpha, beta}] oldest first; sector: 0 for none; vector: number of the active vector, null where unknown.
  draw({ trail, sector, vector }) {
    const { canvas } = this;
    const size = Math.round(canvas.clientWidth * devicePixelRatio);
    if (!size) return;
    if (canvas.width !== size) canvas.width = canvas.height = size;
    const context = canvas.getContext("2d");
    const largest = trail.reduce((found, { alpha, beta }) => Math.max(found, Math.hypot(alpha, beta)), 0);
    this.scale = Math.max(roundedUp(largest * 1.02), largest < this.scale * 0.4 ? SMALLEST_WB : this.scale);
    const radius = size * 0.4;
    context.clearRect(0, 0, size, size);
    context.save();
    context.translate(size / 2, size / 2);
    context.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineWidth = devicePixelRatio;
    this.drawSectors(context, radius, sector, vector);
    this.drawTrail(context, radius / this.scale, trail);
    context.restore();
  }

  drawSectors(context, radius, sector, vector) {
    if (sector) {
      context.fillStyle = colour("--band");
      context.beginPath();
      context.moveTo(0, 0);
      context.arc(0, 0, radius, -angleOf(sector) - Math.PI / 6, -angleOf(sector) + Math.PI / 6);
      context.fill();
    }
    context.strokeStyle = colour("--grid");
    for (const share of [0.5, 1]) {
      context.beginPath();
      context.arc(0, 0, radius * share, 0, 2 * Math.PI);
      context.stroke();
    }
    for (let index = 1; index <= 6; index++) {
      const angle = angleOf(index);
      context.strokeStyle = colour("--line");
      context.beginPath();
      context.moveTo(0, 0);
      context.lineTo(radius * Math.cos(angle - Math.PI / 6), -radius * Math.sin(angle - Math.PI / 6));
      context.stroke();
      context.fillStyle = index === sector ? colour("--accent") : colour("--quiet");
      const out = radius * 1.13;
      context.fillText(index === vector ? `V${index}` : `${index}`, out * Math.cos(angle), -out * Math.sin(angle));
      if (index === vector) this.arrow(context, radius * Math.cos(angle), -radius * Math.sin(angle), colour("--series-2"));
    }
    context.fillStyle = colour("--quiet");
    context.textAlign = "left";
    context.fillText(`${this.scale} Wb`, radius * 0.74, radius * 0.98);
    context.textAlign = "center";
  }

  drawTrail(context, pixels, trail) {
    context.strokeStyle = colour("--series-1");
    context.lineWidth = 1.5 * devicePixelRatio;
    context.lineJoin = "round";
    for (let index = 1; index < trail.length; index++) {
      context.globalAlpha = 0.15 + (0.75 * index) / trail.length;
      context.beginPath();
      context.moveTo(trail[index - 1].alpha * pixels, -trail[index - 1].beta * pixels);
      context.lineTo(trail[index].alpha * pixels, -trail[index].beta * pixels);
      context.stroke();
    }
    context.globalAlpha = 1;
    const last = trail.at(-1);
    if (last) this.arrow(context, last.alpha * pixels, -last.beta * pixels, colour("--series-1"));
  }

  arrow(context, x, y, stroke) {
    const length = Math.hypot(x, y);
    if (length < 3) return;
    const head = ARROW * devicePixelRatio;
    const angle = Math.atan2(y, x);
    context.strokeStyle = context.fillStyle = stroke;
    context.lineWidth = 2 * devicePixelRatio;
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(x - head * 0.7 * Math.cos(angle), y - head * 0.7 * Math.sin(angle));
    context.stroke();
    context.beginPath();
    context.moveTo(x, y);
    for (const side of [-0.4, 0.4]) context.lineTo(x - head * Math.cos(angle + side), y - head * Math.sin(angle + side));
    context.fill();
  }
}

function angleOf(sector) {
  return ((sector - 1) * Math.PI) / 3;
}

// The sector, centred on its active vector; 0 without flux.
export function sectorOf(alpha, beta) {
  if (Math.hypot(alpha, beta) < NO_FLUX_WB) return 0;
  const degrees = (Math.atan2(beta, alpha) * 180) / Math.PI;
  return ((Math.floor((degrees + 30) / 60) % 6) + 6) % 6 + 1;
}

// The flux of the last quarter of a second before a time.
export function trailOf(history, time) {
  const trail = [];
  for (let number = history.find(time - TRAIL_S), end = history.find(time + 1e-9); number < end; number++) {
    const magnitude = history.value("flux_mean_wb", number);
    const angle = history.value("flux_angle_rad", number);
    trail.push({ alpha: magnitude * Math.cos(angle), beta: magnitude * Math.sin(angle) });
  }
  return trail;
}
