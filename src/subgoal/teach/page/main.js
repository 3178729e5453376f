// The page: what the hand draws goes to the server, what the server answers goes on the plane.

import { tableOf } from "./keeping.js";
import { Link } from "./link.js";
import { message, say, showAnswer } from "./panel.js";
import { Pen } from "./pen.js";
import { Plane } from "./plane.js";
import { orderOf } from "./quadrotor.js";

const MOST_BYTES = 16 * 1024 ** 2;
const find = (id) => document.getElementById(id);
const plane = new Plane(find("plane"));
const state = { since: 0, here: false };

// Seconds since the session began, by the clock of this browser.
const origin = Number(sessionStorage.getItem("origin") ?? performance.timeOrigin);
sessionStorage.setItem("origin", origin);
const clock = (stamp) => (performance.timeOrigin - origin + stamp) / 1000;

const link = new Link({ welcome, drawing, answer, opened, flight, saved, file: exported, error, state: connection });
const pen = new Pen(find("plane"), plane, clock, {
  begin(byKeys) {
    land();
    if (byKeys) say("The pen is down.");
    plane.strokes.push([]);
    link.do("begin");
    refresh();
  },
  point(point) {
    plane.strokes.at(-1).push(point);
    link.add(point);
    plane.again();
  },
  lift(byKeys) {
    link.do("lift");
    if (byKeys) say("The pen is up.");
    refresh();
  },
  moved: () => plane.again(),
});
plane.pen = pen;

function welcome(news, waiting, lost) {
  if (lost && plane.strokes.length) return replay();
  drawing(news.drawing);
  for (const each of waiting) follow(each);
  const last = waiting.findLast((each) => ["begin", "lift", "undo", "clear", "file"].includes(each.type));
  const open = last ? last.type === "begin" : news.drawing.drawn;
  if (open && !pen.down) link.do("lift");
  slider("confidence", news.confidence);
  slider("concentration", news.concentration);
}

// Operations that the server has not done yet, on the drawing as it has it.
function follow({ type, points }) {
  if (type === "begin") plane.strokes.push([]);
  else if (type === "points") plane.strokes.at(-1)?.push(...points);
  else if (type === "undo") plane.strokes.pop();
  else if (type === "clear") plane.strokes = [];
  refresh();
}

// The server knows this session no more: it is told everything again.
function replay() {
  for (const [k, stroke] of plane.strokes.entries()) {
    link.do("begin");
    for (let i = 0; i < stroke.length; i += 500) link.do("points", { points: stroke.slice(i, i + 500) });
    if (!pen.down || k < plane.strokes.length - 1) link.do("lift");
  }
}

function drawing(news) {
  plane.strokes = news.strokes;
  plane.view = news.view;
  plane.names = news.names;
  plane.units = news.units;
  if (!news.strokes.length) plane.show(null);
  refresh();
}

function answer(news) {
  if (news.number < state.since) return;
  plane.show(news);
  showAnswer(news, plane.units, plane.slots);
  state.answer = news;
  refresh();
}

function opened(news) {
  const columns = news.columns.length ? `, columns ${news.columns.join(" and ")}` : "";
  const text = `${news.name}: ${news.points} points${columns}, ${news.unit ? `in ${news.unit}` : "unit unknown"}`;
  message(text);
  say(text);
}

function flight(news) {
  const order = orderOf(news, plane);
  const whole = order.map((each) => each.name).join(" → ");
  let over = false;
  const told = (each) => {
    const done = each.progress >= 1;
    const row = each.row + (done ? 1 : 0);
    const passed = order.filter((goal) => goal.row <= row).map((goal) => goal.name).join(" → ");
    find("flown").textContent = `${each.times[row].toFixed(1)} s${passed ? ` · ${passed}` : ""}`;
    if (!done || over) return;
    over = true;
    message(`${news.summary} Order: ${whole}.`);
  };
  plane.flight = { ...news, told };
  find("flown").hidden = false;
  message(`Flying ${whole}`);
  plane.again();
}

function land() {
  plane.flight = null;
  find("flown").hidden = true;
  message("");
}

function saved(news) {
  message(`Saved in ${news.folder}`);
}

function exported(news) {
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(new Blob([news.text], { type: "text/plain" }));
  anchor.download = news.name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
  message(`${news.name} is among your downloads.`);
}

function error(news) {
  message(news.text, true);
}

function connection(kind, text) {
  find("link").className = `link ${kind === "here" ? "here" : "gone"}`;
  find("link-text").textContent = text;
  state.here = kind === "here";
  state.refused = kind === "refused";
  refresh();
}

function refresh() {
  const drawn = plane.strokes.some((each) => each.length);
  find("invitation").classList.toggle("off", plane.strokes.length > 0);
  const found = drawn && !pen.down && Boolean(plane.answer?.subgoals.length);
  for (const id of ["fly", "save", "csv", "json"]) allow(id, found && state.here);
  for (const id of ["undo", "clear"]) allow(id, !pen.down && plane.strokes.length > 0);
  allow("open", state.here);
  find("keep").hidden = !(state.refused && drawn);
  plane.again();
}

// A button that can be pressed or not; the focus does not stay on one that cannot.
function allow(id, can) {
  const button = find(id);
  if (!can && document.activeElement === button) plane.canvas.focus({ preventScroll: true });
  button.disabled = !can;
}

function edit(type) {
  land();
  state.since = link.do(type);
  follow({ type });
  if (!plane.strokes.length) {
    plane.show(null);
    showAnswer(null);
    say("The sheet is empty.");
  } else say("The last stroke is taken away.");
  refresh();
}

function open(file) {
  if (!file || !state.here) return;
  if (file.size > MOST_BYTES) return message("This file is too large: at most 16 MiB.", true);
  land();
  message(`Reading ${file.name} …`);
  state.since = link.do("file", { name: file.name }, file);
}

// Sliders are logarithmic.
function slider(id, value) {
  find(id).value = Math.log10(value);
  label(id, value);
}

function label(id, value) {
  const letter = id === "confidence" ? "α" : "η";
  find(`${id}-value`).textContent = `${letter} = ${value.toPrecision(2)}`;
  find(id).setAttribute("aria-valuetext", value.toPrecision(2));
}

const values = () => ({ confidence: 10 ** find("confidence").value, concentration: 10 ** find("concentration").value });
let tuning = false;
for (const id of ["confidence", "concentration"]) {
  find(id).addEventListener("input", () => {
    label(id, values()[id]);
    if (tuning) return;
    tuning = true;
    requestAnimationFrame(() => {
      tuning = false;
      link.do("tune", values());
    });
  });
  label(id, values()[id]);
}

find("fly").addEventListener("click", () => {
  land();
  message("Preparing the flight …");
  link.do("fly");
});
find("save").addEventListener("click", () => {
  message("Saving …");
  link.do("save");
});
for (const id of ["csv", "json"]) find(id).addEventListener("click", () => link.do("export", { format: id }));
find("keep").addEventListener("click", () => exported({ name: "recording.csv", text: tableOf(plane) }));
for (const id of ["undo", "clear"]) find(id).addEventListener("click", () => edit(id));
find("open").addEventListener("click", () => find("file").click());
find("file").addEventListener("change", (event) => {
  open(event.target.files[0]);
  event.target.value = "";
});
addEventListener("keydown", (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === "z" && !find("undo").disabled) {
    event.preventDefault();
    edit("undo");
  }
});
const sheet = find("sheet");
for (const name of ["dragover", "drop", "dragleave"]) {
  addEventListener(name, (event) => {
    event.preventDefault();
    sheet.classList.toggle("over", name === "dragover");
    if (name === "drop") open(event.dataTransfer.files[0]);
  });
}
showAnswer(null);
refresh();

export { link, pen, plane };
