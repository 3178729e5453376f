// The connection: operations are numbered, kept until the server says that they are done, and sent again after a break.

const PAUSES = [200, 500, 1000, 2000, 4000];

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
    this.welcomed = false;
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
      setTimeout(() => this.connect(), PAUSES[Math.min(this.tries++, PAUSES.length - 1)]);
    };
  }

  hear(message) {
    if (message.type === "welcome") this.resume(message);
    else if (message.type === "done") this.waiting = this.waiting.filter((each) => each.number > message.number);
    else if (message.type === "error") this.trouble(message);
    else this.on[message.type]?.(message);
  }

  resume(message) {
    const other = this.session !== message.session;
    const before = this.session;
    this.session = message.session;
    sessionStorage.setItem("session", this.session);
    this.tries = 0;
    if (other) {
      this.waiting = [];
      this.next = message.last + 1;
    } else {
      this.waiting = this.waiting.filter((each) => each.number > message.last);
      if (this.waiting.length && this.waiting[0].number !== message.last + 1) this.waiting = [];
      this.next = message.last + this.waiting.length + 1;
    }
    this.welcomed = true;
    this.on.state("here", "connected");
    this.on.welcome(message, this.waiting, other && before !== null);
    for (const each of this.waiting) this.transmit(each);
  }

  trouble(message) {
    if (message.code === "too-fast") {
      setTimeout(() => this.again(message.number ?? 0), 1000 * (message.wait ?? 1));
    } else if (message.code === "out-of-order" && message.expected) {
      this.again(message.expected);
    } else {
      if (message.code === "closed" || message.code === "full") {
        this.refused = true;
        this.on.state("refused", "not connected");
        this.socket.close();
      }
      this.on.error(message);
    }
  }

  again(from) {
    for (const each of this.waiting) if (each.number >= from) this.transmit(each);
  }

  // An operation, done once whatever happens to the connection; what the hand drew before goes first.
  do(type, fields = {}, content = null) {
    this.flush();
    const operation = { type, number: this.next++, ...fields };
    if (content) Object.defineProperty(operation, "content", { value: content });
    this.waiting.push(operation);
    this.transmit(operation);
    return operation.number;
  }

  add(point) {
    if (!this.points.length) requestAnimationFrame(() => this.flush());
    this.points.push(point);
  }

  flush() {
    while (this.points.length) {
      const points = this.points.splice(0, 500);
      const operation = { type: "points", number: this.next++, points };
      this.waiting.push(operation);
      this.transmit(operation);
    }
  }

  transmit(operation) {
    if (!this.welcomed || this.socket.readyState !== WebSocket.OPEN) return;
    const text = JSON.stringify(operation);
    this.socket.send(operation.content ? new Blob([text, "\n", operation.content]) : text);
  }

  // Before the page goes: what is not done yet is kept for the one that comes after it.
  keep() {
    this.flush();
    sessionStorage.setItem("waiting", JSON.stringify(this.waiting.filter((each) => !each.content)));
  }
}
