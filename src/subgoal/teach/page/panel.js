// What was found, in words and bars.

import { colourOf, inkOf } from "./plane.js";

const find = (id) => document.getElementById(id);
const percent = (p) => (p > 0.995 ? "> 99 %" : `${Math.round(100 * p)} %`);
const few = (n) => `${n} subgoal${n === 1 ? "" : "s"}`;
const STAGES = { drawing: "while you draw", settled: "settling", full: "converged" };
const QUIET = 2500; // milliseconds between two sentences while drawing

let said = 0;
let saidLast = "";

// slots: the number of each subgoal on the plane, from 0.
export function showAnswer(answer, units, slots) {
  const chip = find("stage");
  if (!answer || (!answer.subgoals.length && !answer.status)) {
    find("headline").textContent = "No subgoals yet";
    chip.textContent = "";
    find("certainty").textContent = "They appear here, with how sure they are.";
    saidLast = "";
    find("bars").replaceChildren();
    find("goals").replaceChildren();
    find("bars").setAttribute("aria-label", "How many subgoals: nothing drawn yet");
    return;
  }
  find("headline").textContent = answer.subgoals.length ? few(answer.n) : "No subgoals yet";
  const full = answer.stage === "full";
  chip.textContent = !answer.subgoals.length ? "" : full && !answer.converged ? "not converged" : STAGES[answer.stage];
  chip.className = `chip ${full ? (answer.converged ? "good" : "bad") : ""}`;
  chip.title = answer.status;
  const open = answer.stage === "drawing";
  find("certainty").textContent = answer.subgoals.length ? sureness(answer) : open ? "Draw on." : answer.status;
  bars(answer.subgoals.length ? answer : { ...answer, counts: {} });
  const listed = answer.subgoals.map((goal, k) => [slots[k], goal]).filter(([, goal]) => goal.counted);
  listed.sort((a, b) => a[0] - b[0]);
  const rows = listed.map(([slot, goal]) => row(goal, slot, units));
  if (answer.subgoals.length > listed.length) rows.push(rest(answer.subgoals.length - listed.length));
  find("goals").replaceChildren(...rows);
  tell(answer, listed);
}

// How probable the number in the headline is, and that another is likelier where one is.
function sureness({ counts, n }) {
  const sure = counts[n] ?? 0;
  const [likeliest, most] = Object.entries(counts).reduce((a, b) => (b[1] > a[1] ? b : a), ["", 0]);
  const other = `${n} reach 5 % of the path on average, though ${likeliest} is likelier (${percent(most)})`;
  return [sure ? `${percent(sure)} sure` : "", most > sure ? other : ""].filter(Boolean).join("; ");
}

function bars(answer) {
  const counts = Object.entries(answer.counts).map(([k, p]) => [Number(k), p]).sort((a, b) => a[0] - b[0]);
  if (!counts.length) return find("bars").replaceChildren();
  const low = Math.max(1, (counts[0][0]) - 1);
  const high = (counts.at(-1)[0]) + 1;
  const all = new Map(counts);
  const made = [];
  for (let k = low; k <= high; k++) {
    const p = all.get(k) ?? 0;
    const bar = document.createElement("span");
    bar.className = k === answer.n ? "bar most" : "bar";
    const column = document.createElement("i");
    column.style.setProperty("--p", p);
    const name = document.createElement("b");
    name.textContent = k;
    bar.append(p >= 0.005 ? percent(p) : "", column, name);
    made.push(bar);
  }
  find("bars").replaceChildren(...made);
  find("bars").setAttribute("aria-label", `How many subgoals: ${counts.map(([k, p]) => `${k} with ${percent(p)}`).join(", ")}`);
}

function row(goal, k, units) {
  const item = document.createElement("li");
  const disc = document.createElement("span");
  disc.className = "disc";
  disc.textContent = k + 1;
  disc.style.background = colourOf(k);
  disc.style.color = inkOf(k);
  const what = document.createElement("span");
  what.className = "what";
  what.textContent = `${percent(goal.share)} of the path`;
  const where = document.createElement("span");
  where.className = "faint";
  const size = units === "m" && goal.radius < 1 ? `${Math.round(100 * goal.radius)} cm` : `${goal.radius.toPrecision(2)} ${units || "units"}`;
  where.textContent = `± ${size}`;
  where.title = `certain to ${percent(goal.inclusion)}`;
  item.append(disc, what, where);
  return item;
}

function rest(n) {
  const item = document.createElement("li");
  item.className = "faint";
  item.textContent = `${n} more with less than 5 % of the path`;
  return item;
}

// Now and then while one draws, and the answer that stays.
function tell(answer, listed) {
  const now = performance.now();
  const open = answer.stage === "drawing";
  if (!answer.subgoals.length || answer.stage === "settled" || (open && now - said < QUIET)) return;
  const places = listed.map(([slot, goal]) => `${slot + 1} at ${goal.y.toFixed(1)}, ${goal.z.toFixed(1)}`);
  const text = `${few(answer.n)}, ${sureness(answer)}: ${places.join("; ")}`;
  if (text === saidLast) return;
  [said, saidLast] = [now, text];
  say(text);
}

// To those who listen.
export function say(text) {
  find("news").textContent = text;
}

export function message(text, bad = false) {
  const line = find("message");
  line.textContent = text;
  line.classList.toggle("bad", bad);
}
