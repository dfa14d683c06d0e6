// The way to the server: one WebSocket, opened again when it breaks. Knows the shape of frames, not what they mean.
import { frames_in, parse_frame } from "./wire.js";

/** @typedef {import("./wire.js").Frame} Frame */
/** @typedef {{frame: (frame: Frame) => void, text: (name: string, value: any) => void, any: () => void, state: (open: boolean, why: string) => void}} Listener any: something came, whatever it is */

/** Wait before the first, second, ... attempt to connect again, milliseconds. */
const waits_ms = [200, 400, 800, 1600, 3000];

export class Connection {
  /** @param {string} url @param {Listener} listener */
  constructor(url, listener) {
    this.url = url;
    this.listener = listener;
    this.attempts = 0;
    /** Frames and texts that were not understood. */
    this.refused = 0;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.open();
  }

  open() {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.listener.state(true, "");
    };
    socket.onmessage = (event) => {
      this.attempts = 0;
      this.listener.any();
      this.heard(event.data);
    };
    socket.onclose = (event) => {
      this.listener.state(false, event.reason || "the lab does not answer");
      void this.ask_why(socket);
      const wait_ms = waits_ms[Math.min(this.attempts++, waits_ms.length - 1)];
      setTimeout(() => this.open(), wait_ms);
    };
  }

  /** A browser does not tell why a WebSocket was refused. A server that answers other requests has given the place to somebody else.
   * @param {WebSocket} socket that was closed */
  async ask_why(socket) {
    const answer = await fetch("about.json").catch(() => null);
    if (answer?.ok && this.socket?.readyState !== WebSocket.OPEN && socket.readyState === WebSocket.CLOSED) {
      this.listener.state(false, "the lab is reachable, but has too many viewers, or this page was too slow; a viewer with the token always gets in");
    }
  }

  /** @param {string | ArrayBuffer} data */
  heard(data) {
    if (typeof data !== "string") {
      for (const part of frames_in(data)) {
        const frame = parse_frame(part);
        if (frame) this.listener.frame(frame);
        else this.refused += 1;
      }
      return;
    }
    try {
      for (const [name, value] of Object.entries(JSON.parse(data))) this.listener.text(name, value);
    } catch (error) {
      if (!(error instanceof SyntaxError)) throw error;
      this.refused += 1;
    }
  }

  /** False when nobody is there to hear it.
   * @param {object} message */
  send(message) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
