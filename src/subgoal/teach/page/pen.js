// The hand: pointer and keys turned into strokes of points (t, y, z).

const SPEED = 0.9; // of the pen moved by keys, in canvas heights per three seconds
const TAP = 0.02; // of the canvas height, for each press of an arrow key
const STEP = 1e-4; // seconds between two points, at least

export class Pen {
  // plane: gives places; clock(stamp): seconds; on: {begin, point, lift, moved}.
  constructor(canvas, plane, clock, on) {
    Object.assign(this, { canvas, plane, clock, on });
    this.down = false;
    this.heard = false;
    this.last = -Infinity;
    this.held = new Set();
    this.cursor = null;
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => this.release(event));
    canvas.addEventListener("keydown", (event) => this.key(event, true));
    canvas.addEventListener("keyup", (event) => this.key(event, false));
    canvas.addEventListener("blur", () => this.let());
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  press(event) {
    this.heard = true;
    if (event.button > 0 || this.down) return;
    event.preventDefault();
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.pointer = event.pointerId;
    this.cursor = null;
    this.begin();
    this.put(event.timeStamp, this.place(event));
  }

  // A pointer that was pressed before the page could hear it draws from its first move on.
  move(event) {
    if (!this.heard && event.buttons === 1) this.press(event);
    if (!this.down || event.pointerId !== this.pointer) return;
    const events = event.getCoalescedEvents?.() ?? [];
    for (const each of events.length ? events : [event]) this.put(each.timeStamp, this.place(each));
  }

  release(event) {
    if (!this.down || event.pointerId !== this.pointer) return;
    this.pointer = null;
    this.end();
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return this.plane.inside(this.plane.place(event.clientX - box.left, event.clientY - box.top));
  }

  begin(byKeys = false) {
    this.down = true;
    this.on.begin(byKeys);
  }

  put(stamp, [y, z]) {
    const time = this.clock(stamp);
    if (!(time > this.last + STEP)) return;
    this.last = time;
    this.on.point([Math.round(time * 1e6) / 1e6, Math.round(y * 1e6) / 1e6, Math.round(z * 1e6) / 1e6]);
  }

  end(byKeys = false) {
    this.down = false;
    this.on.lift(byKeys);
  }

  key(event, pressed) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const name = event.key;
    if (name.startsWith("Arrow")) {
      event.preventDefault();
      pressed ? this.held.add(name) : this.held.delete(name);
      if (pressed && !event.repeat) this.step(name, event.timeStamp);
      if (pressed && !this.running) this.run(event.timeStamp);
    } else if (name === " ") {
      event.preventDefault();
      if (pressed && !event.repeat && !this.down) this.penDown(event.timeStamp);
      else if (!pressed && this.down && this.pointer == null) this.end(true);
    } else if (pressed && !event.repeat && name.toLowerCase() === "p" && this.pointer == null) {
      this.down ? this.end(true) : this.penDown(event.timeStamp);
    } else if (pressed && name === "Escape") this.let();
  }

  let() {
    this.held.clear();
    if (this.down && this.pointer == null) this.end(true);
    this.on.moved();
  }

  penDown(stamp) {
    this.cursor ??= this.plane.middle();
    this.begin(true);
    this.put(stamp, this.cursor);
  }

  step(name, stamp) {
    const [y, z] = (this.cursor ??= this.plane.middle());
    const far = TAP * this.plane.height;
    const across = (name === "ArrowRight") - (name === "ArrowLeft");
    const up = (name === "ArrowUp") - (name === "ArrowDown");
    this.cursor = this.plane.inside([y + across * far, z + up * far]);
    if (this.down && this.pointer == null) this.put(stamp, this.cursor);
    this.on.moved();
  }

  // Moves the cursor while arrow keys are held.
  run(stamp) {
    this.running = true;
    this.cursor ??= this.plane.middle();
    let before = stamp;
    const frame = (now) => {
      const seconds = Math.min(0.05, Math.max(0, (now - before) / 1000));
      before = now;
      const far = (SPEED / 3) * this.plane.height * seconds;
      const [y, z] = this.cursor;
      const across = this.held.has("ArrowRight") - this.held.has("ArrowLeft");
      const up = this.held.has("ArrowUp") - this.held.has("ArrowDown");
      this.cursor = this.plane.inside([y + across * far, z + up * far]);
      if (this.down && this.pointer == null) this.put(now, this.cursor);
      this.on.moved();
      if (this.held.size) requestAnimationFrame(frame);
      else this.running = false;
    };
    requestAnimationFrame(frame);
  }
}
