// The connection: operations are numbered, kept until the server says that they are done, and sent again after a break.

const PAUSES = [200, 500, 1000, 2000, 4000]; // milliseconds before each try to connect again
const LITTLE = 60; // milliseconds
const TOGETHER = 500; // points in one message
const WINDOW = 200; // operations on their way
const GONE = "The server was started anew: open the address that it printed.";

export class Link {
  // on: {welcome, answer, ...} by type of message, and state("here" | "gone" | "refused", text).
  constructor(on) {
    this.on = on;
    this.page = [...crypto.getRandomValues(new Uint8Array(12))].map((b) => b.toString(16).padStart(2, "0")).join("");
    this.session = sessionStorage.getItem("session");
    this.waiting = JSON.parse(sessionStorage.getItem("waiting") ?? "[]");
    sessionStorage.removeItem("waiting");
    this.next = this.waiting.length ? this.waiting.at(-1).number + 1 : 1;
    this.points = [];
    this.tries = 0;
    this.sent = 0;
    this.welcomed = this.paused = false;
    addEventListener("pagehide", () => this.keep());
    this.connect();
  }

  connect() {
    const address = new URL("live", location.href);
    address.protocol = "ws:";
    this.socket = new WebSocket(address);
    this.socket.onopen = () => this.socket.send(JSON.stringify({ type: "hello", page: this.page, session: this.session }));
    this.socket.onmessage = (event) => this.hear(JSON.parse(event.data));
    this.socket.onclose = () => {
      this.welcomed = false;
      if (this.refused) return;
      this.on.state("gone", "reconnecting; keep drawing");
      setTimeout(() => this.again(), PAUSES[Math.min(this.tries++, PAUSES.length - 1)]);
    };
  }

  // A server that answers but does not know this address has another secret: it was started anew.
  async again() {
    const answer = await fetch(new URL(".", location.href), { method: "GET", cache: "no-store" }).catch(() => null);
    if (answer?.status === 404) {
      this.refused = true;
      this.on.state("refused", "not connected");
      this.on.error({ code: "anew", text: GONE });
    } else this.connect();
  }

  hear(message) {
    if (message.type === "welcome") this.resume(message);
    else if (message.type === "done") {
      this.waiting = this.waiting.filter((each) => each.number > message.number);
      this.pump();
    } else if (message.type === "error") this.trouble(message);
    else this.on[message.type]?.(message);
  }

  // What was drawn before the first welcome waits too; a stroke that the page before this one left open is ended first.
  resume(message) {
    this.flush();
    const other = this.session !== null && this.session !== message.session;
    this.session = message.session;
    sessionStorage.setItem("session", this.session);
    this.tries = 0;
    this.waiting = other ? [] : this.waiting.filter((each) => each.number > message.last);
    if (this.waiting.length && this.waiting[0].number !== message.last + 1) this.waiting = [];
    const first = this.waiting.find((each) => each.type !== "tune");
    if (message.drawing.drawn && first?.type === "begin") this.waiting.unshift({ type: "lift" });
    for (const [k, each] of this.waiting.entries()) each.number = message.last + 1 + k;
    this.next = message.last + this.waiting.length + 1;
    this.sent = message.last;
    this.welcomed = true;
    this.paused = false;
    this.on.welcome(message, this.waiting, other);
    this.on.state("here", "connected");
    this.pump();
  }

  trouble(message) {
    if (message.code === "too-fast") {
      this.sent = Math.min(this.sent, (message.number ?? this.waiting[0]?.number ?? this.next) - 1);
      if (this.paused) return;
      this.paused = true;
      setTimeout(() => {
        this.paused = false;
        this.pump();
      }, 1000 * (message.wait ?? 1) + LITTLE);
    } else if (message.code === "out-of-order" && message.expected) {
      if (this.asked === message.expected && performance.now() - this.askedAt < 5 * LITTLE) return;
      [this.asked, this.askedAt] = [message.expected, performance.now()];
      this.sent = Math.min(this.sent, message.expected - 1);
      this.pump();
    } else {
      if (message.code === "closed" || message.code === "full") {
        this.refused = true;
        this.on.state("refused", "not connected");
        this.socket.close();
      }
      this.on.error(message);
    }
  }

  // An operation, done once whatever happens to the connection; what the hand drew before goes first.
  do(type, fields = {}, content = null) {
    this.flush();
    return this.queue({ type, number: this.next++, ...fields }, content).number;
  }

  queue(operation, content = null) {
    if (content) Object.defineProperty(operation, "content", { value: content });
    this.waiting.push(operation);
    this.pump();
    return operation;
  }

  add(point) {
    if (!this.points.length) requestAnimationFrame(() => this.flush());
    this.points.push(point);
  }

  // Points go together, more of them where they wait for a connection.
  flush() {
    while (this.points.length) {
      const last = this.waiting.at(-1);
      const open = last?.type === "points" && last.number > this.sent && last.points.length < TOGETHER;
      const points = this.points.splice(0, TOGETHER - (open ? last.points.length : 0));
      if (open) last.points.push(...points);
      else this.queue({ type: "points", number: this.next++, points });
    }
  }

  // Sends what has not been sent, no farther ahead of what is done than a window.
  pump() {
    if (!this.welcomed || this.paused || this.socket.readyState !== WebSocket.OPEN) return;
    for (const each of this.waiting) {
      if (each.number <= this.sent) continue;
      if (each.number - this.waiting[0].number >= WINDOW) break;
      const text = JSON.stringify(each);
      this.socket.send(each.content ? new Blob([text, "\n", each.content]) : text);
      this.sent = each.number;
    }
  }

  // Before the page goes: what is not done yet is kept for the one that comes after it.
  keep() {
    this.flush();
    sessionStorage.setItem("waiting", JSON.stringify(this.waiting.filter((each) => !each.content)));
  }
}
