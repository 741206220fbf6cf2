// The WebSocket to the server: reconnects by itself, and decodes the frames of sextant_py/dashboard/frames.py.

import { token } from "./token.js";

const RETRY_MS = 1000;
const TELEMETRY = 1;
const CAPTURE = 2;

export class Link {
  // on: {message(object), frame({drive, columns, rows, values}), capture({number, …}), opened(), closed()}
  constructor(on) {
    this.on = on;
    this.closedAt = null;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    // With the token the server keeps what this page does apart from pages without it.
    const query = token() ? `?token=${encodeURIComponent(token())}` : "";
    const socket = new WebSocket(`${scheme}://${location.host}/socket` + query);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.closedAt = null;
      this.on.opened();
    };
    socket.onmessage = (event) => this.take(event.data);
    socket.onclose = () => {
      this.closedAt ??= performance.now();
      this.on.closed();
      setTimeout(() => this.connect(), RETRY_MS);
    };
    this.socket = socket;
  }

  take(data) {
    if (typeof data === "string") {
      this.on.message(JSON.parse(data));
      return;
    }
    const [kind, number, columns, rows] = new Uint32Array(data, 0, 4);
    const values = new Float64Array(data, 16);
    if (kind === TELEMETRY) this.on.frame({ drive: number, columns, rows, values });
    else if (kind === CAPTURE) this.on.capture({ number, columns, rows, values });
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  send(message) {
    if (this.isOpen) this.socket.send(JSON.stringify(message));
  }

  // Milliseconds since the connection was lost; 0 while it stands.
  lostFor() {
    return this.closedAt === null ? 0 : performance.now() - this.closedAt;
  }
}
