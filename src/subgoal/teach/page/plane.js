// The vertical plane: from metres to pixels, and everything that is drawn on it.

import { COLOURS } from "./colours.js";
import { drawFlight } from "./quadrotor.js";

const EXAMPLE = [[-1.45, 1.0], [-1.35, 1.5], [-1.05, 2.0], [-0.45, 2.2], [0.1, 2.05], [0.5, 1.6], [0.9, 1.35], [1.45, 1.3]];
const EXAMPLE_GOALS = [[-0.45, 2.2], [1.45, 1.3]];
const EASE = 0.28; // of the way that is left, in each frame
const NEAR = 0.1; // of the height, within which a subgoal is the one of before

export const colourOf = (k) => (k < 0 ? COLOURS.other : COLOURS.palette[k % COLOURS.palette.length]);
export const inkOf = (k) => (COLOURS.inks[k % COLOURS.inks.length]);

export class Plane {
  constructor(canvas) {
    this.canvas = canvas;
    this.view = [-2, 2, 0, 3];
    this.names = ["y", "z"];
    this.units = "m";
    this.strokes = [];
    this.answer = null;
    this.discs = [];
    this.slots = [];
    this.flight = null;
    this.pen = null;
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    new ResizeObserver(() => this.measure()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.measure());
    this.measure();
  }

  measure() {
    const sharp = devicePixelRatio || 1;
    const box = this.canvas.getBoundingClientRect();
    [this.width, this.tall] = [box.width, box.height];
    this.canvas.width = Math.round(box.width * sharp);
    this.canvas.height = Math.round(box.height * sharp);
    this.sharp = sharp;
    const style = getComputedStyle(document.documentElement);
    this.ink = Object.fromEntries(["card", "ink", "faint", "grid", "axis", "path", "accent", "line"].map((name) =>
      [name, style.getPropertyValue(`--${name}`).trim()]));
    this.again();
  }

  get height() { return this.view[3] - this.view[2]; }
  get scale() { return this.width / (this.view[1] - this.view[0]); }
  at([y, z]) { return [(y - this.view[0]) * this.scale, this.tall - (z - this.view[2]) * this.scale]; }
  place(across, down) { return [this.view[0] + across / this.scale, this.view[2] + (this.tall - down) / this.scale]; }
  middle() { return [(this.view[0] + this.view[1]) / 2, (this.view[2] + this.view[3]) / 2]; }
  inside([y, z]) {
    const [left, right, low, high] = this.view;
    return [Math.min(right, Math.max(left, y)), Math.min(high, Math.max(low, z))];
  }

  // A new answer: discs move from where they were. While the pen is down each keeps its number and colour, afterwards
  // they have those of the report.
  show(answer) {
    const before = this.discs;
    this.answer = answer;
    const goals = answer?.subgoals ?? [];
    const kept = goals.map((goal) =>
      before.find((each) => Math.hypot(each.goal.y - goal.y, each.goal.z - goal.z) < NEAR * this.height));
    this.slots = goals.map((_, k) => k);
    if (answer?.stage === "drawing") {
      const taken = new Set();
      this.slots = kept.map((each) => (each && !taken.has(each.slot) && taken.add(each.slot) ? each.slot : -1));
      for (const [k, slot] of this.slots.entries()) {
        if (slot >= 0) continue;
        this.slots[k] = goals.findIndex((_, free) => !taken.has(free));
        taken.add(this.slots[k]);
      }
    }
    this.discs = goals.map((goal, k) => {
      const from = this.calm.matches ? { ...goal, size: 1 } : kept[k] ?? { ...goal, size: 0 };
      return { y: from.y, z: from.z, size: from.size, slot: this.slots[k], goal };
    });
    this.again();
  }

  again() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame((now) => {
      this.due = false;
      this.draw(now);
    });
  }

  draw(now) {
    const c = this.canvas.getContext("2d");
    c.setTransform(this.sharp, 0, 0, this.sharp, 0, 0);
    c.clearRect(0, 0, this.width, this.tall);
    c.lineCap = c.lineJoin = "round";
    this.grid(c);
    if (!this.strokes.length) this.example(c);
    for (const [k, stroke] of this.strokes.entries()) this.stroke(c, stroke, k);
    if (this.settle()) this.again();
    for (const disc of [...this.discs].reverse()) this.disc(c, disc);
    if (this.flight && drawFlight(c, this, this.flight, now)) this.again();
    if (this.pen?.cursor && document.activeElement === this.canvas) this.cursor(c);
  }

  grid(c) {
    const [left, right, low, high] = this.view;
    const rough = (right - left) / 8;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((each) => each * power >= rough * 0.999);
    c.lineWidth = 1;
    c.font = "12px system-ui, sans-serif";
    c.fillStyle = this.ink.faint;
    const label = (value) => String(Math.round(value / step) * step).slice(0, 9).replace("-", "−");
    for (let y = Math.ceil(left / step) * step; y < right - step / 9; y += step) {
      const [x] = this.at([y, 0]);
      this.rule(c, x, 0, x, this.tall);
      c.textAlign = "center";
      if (x > 28 && x < this.width - 60) c.fillText(label(y), x, this.tall - 8);
    }
    for (let z = Math.ceil(low / step) * step; z < high - step / 9; z += step) {
      const [, y] = this.at([0, z]);
      this.rule(c, 0, y, this.width, y);
      c.textAlign = "left";
      if (y > 36 && y < this.tall - 20) c.fillText(label(z), 8, y + 4);
    }
    const unit = this.units ? ` [${this.units}]` : "";
    c.textAlign = "right";
    c.fillText(`${this.names[0]}${unit} →`, this.width - 10, this.tall - 8);
    c.textAlign = "left";
    c.fillText(`↑ ${this.names[1]}${unit}`, 8, 18);
  }

  rule(c, x0, y0, x1, y1) {
    c.strokeStyle = this.ink.grid;
    c.beginPath();
    c.moveTo(x0, y0);
    c.lineTo(x1, y1);
    c.stroke();
  }

  example(c) {
    c.save();
    c.setLineDash([2, 9]);
    c.lineWidth = 3;
    c.strokeStyle = this.ink.axis;
    c.beginPath();
    const points = EXAMPLE.map((each) => this.at(each));
    c.moveTo(...points[0]);
    for (let k = 1; k < points.length - 1; k++) {
      const [a, b] = [points[k], points[k + 1]];
      c.quadraticCurveTo(a[0], a[1], (a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
    }
    c.lineTo(...points.at(-1));
    c.stroke();
    c.setLineDash([]);
    for (const [k, place] of EXAMPLE_GOALS.entries()) {
      const [x, y] = this.at(place);
      this.circle(c, x, y, 15);
      c.fillStyle = this.ink.card;
      c.fill();
      c.lineWidth = 2;
      c.stroke();
      c.fillStyle = this.ink.faint;
      this.number(c, x, y, k + 1, 13);
    }
    c.restore();
  }

  // Parts of a stroke in the colours of their subgoals; what is not learned yet in grey.
  stroke(c, points, k) {
    const cuts = (this.answer?.segments ?? []).filter((each) => each.stroke === k);
    const open = this.answer?.stage === "drawing";
    let [cut, from] = [0, 0];
    for (let i = 1; i <= points.length; i++) {
      const part = cuts[cut];
      const next = cuts[cut + 1];
      const until = !part ? Infinity : next ? (part.end + next.begin) / 2 : open ? part.end + 0.06 : Infinity;
      const last = i === points.length;
      if (!last && points[i][0] <= until) continue;
      this.line(c, points, from, last ? i : i + 1, part ? colourOf(part.subgoal < 0 ? -1 : this.slots[part.subgoal]) : this.ink.path);
      from = i;
      if (part) cut += 1;
    }
  }

  line(c, points, from, to, colour) {
    c.strokeStyle = colour;
    c.lineWidth = 4;
    c.globalAlpha = 0.85;
    c.beginPath();
    for (let i = from; i < to; i++) c.lineTo(...this.at([points[i][1], points[i][2]]));
    c.stroke();
    c.globalAlpha = 1;
  }

  // One step of each disc towards its place; true while they move.
  settle() {
    let moving = false;
    for (const disc of this.discs) {
      for (const [key, goal] of [["y", disc.goal.y], ["z", disc.goal.z], ["size", 1]]) {
        const gap = goal - disc[key];
        const near = Math.abs(gap) < (key === "size" ? 0.01 : 1e-3 * this.height);
        disc[key] = near || this.calm.matches ? goal : disc[key] + EASE * gap;
        moving ||= disc[key] !== goal;
      }
    }
    return moving;
  }

  disc(c, { y, z, size, slot, goal }) {
    const r = size * (goal.counted ? 11 + 16 * Math.sqrt(Math.min(1, goal.share)) : 4);
    const [x, down] = this.whole(this.at([y, z]), r + 6);
    c.fillStyle = c.strokeStyle = goal.counted ? colourOf(slot) : this.ink.faint;
    c.globalAlpha = goal.counted ? 0.16 : 0.1;
    this.circle(c, x, down, size * Math.max(r + 5, goal.radius * this.scale));
    c.fill();
    c.globalAlpha = 1;
    this.circle(c, x, down, r);
    c.fill();
    if (!goal.counted) return;
    c.lineWidth = 2.5;
    c.beginPath();
    c.arc(x, down, r + 3.5, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * goal.inclusion);
    c.stroke();
    c.lineWidth = 2;
    c.strokeStyle = this.ink.card;
    this.circle(c, x, down, r + 1);
    c.stroke();
    c.fillStyle = inkOf(slot);
    if (r > 6) this.number(c, x, down, slot + 1, Math.min(17, r));
  }

  // The nearest place at which a circle of radius r is not cut off by the edge.
  whole([x, y], r) {
    return [Math.min(this.width - r, Math.max(r, x)), Math.min(this.tall - r, Math.max(r, y))];
  }

  circle(c, x, y, r) {
    c.beginPath();
    c.arc(x, y, r, 0, 2 * Math.PI);
  }

  number(c, x, y, text, size) {
    c.font = `650 ${size}px system-ui, sans-serif`;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillText(text, x, y + 0.5);
    c.textBaseline = "alphabetic";
  }

  cursor(c) {
    const [x, y] = this.at(this.pen.cursor);
    c.strokeStyle = this.ink.ink;
    c.lineWidth = 2;
    c.beginPath();
    c.arc(x, y, this.pen.down ? 5 : 9, 0, 2 * Math.PI);
    for (const [a, b] of [[-16, 0], [16, 0], [0, -16], [0, 16]]) {
      c.moveTo(x + a, y + b);
      c.lineTo(x + a / 2, y + b / 2);
    }
    c.stroke();
  }
}
