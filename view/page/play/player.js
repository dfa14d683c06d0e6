// Plays a recorded run: keeps the time, asks the server ahead for what comes, and hands out each frame when its time has come.

/** @typedef {import("../wire/wire.js").Frame} Frame */
/** @typedef {{send: (message: object) => boolean, show: (frame: Frame) => void, jumped: () => void}} Out jumped: everything before is wrong now */

/** Moments that are drawn per second of wall time. */
const moments_per_s = 30;
/** Moments that are asked for at once, and how many are kept ahead. */
const chunk = 30, ahead = 60;
/** At the end of a run that still grows we look for more so often, milliseconds. */
const look_ms = 1000;
/** What drawing takes. */
export const channels = ["arena", "poses", "shared", "shown", "overlay", "status", "peers", "to_robots"];
/** Speeds that are offered. */
export const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];

export class Player {
  /** @param {Out} out */
  constructor(out) {
    this.out = out;
    this.length_us = 0;
    this.growing = false;
    this.t_us = 0;
    this.speed = 1;
    this.playing = false;
    /** @type {Frame[]} Frames that wait for their time, in order. */
    this.waiting = [];
    /** Up to where the server was asked. */
    this.asked_us = 0;
    this.request = 0;
    /** @type {Map<number, "seek"|"frames">} Requests that are under way: what for. */
    this.open = new Map();
    /** Called when the newest seek is done. @type {(() => void) | null} */
    this.arrived = null;
    /** The seek that counts; answers to earlier requests are old. */
    this.oldest = 0;
    this.last_ms = 0;
    /** When we looked last whether the run has grown. */
    this.looked_ms = 0;
    /** Answers to requests that others made.
     * @type {Map<number, {frames: Frame[], elsewhere: boolean, done: (frames: Frame[], answer: any) => void}>} */
    this.asked = new Map();
  }

  /** @param {number} length_us @param {boolean} growing */
  introduce(length_us, growing) {
    this.length_us = length_us;
    this.growing = growing;
  }

  /** Asks anything, beside the playing; of another run, too.
   * @param {Record<string, any>} what @returns {Promise<{frames: Frame[], answer: any}>} */
  ask(what) {
    const request = ++this.request;
    return new Promise((resolve) => {
      this.asked.set(request, { frames: [], elsewhere: what["run"] !== undefined, done: (frames, answer) => resolve({ frames, answer }) });
      if (!this.out.send({ request, ...what })) this.done({ request, refused: "there is no connection to the server" });
    });
  }

  /** Goes to a time. Resolves when everything of that time was shown, or another jump came.
   * @param {number} t_us
   * @returns {Promise<void>} */
  seek(t_us) {
    this.t_us = Math.min(Math.max(0, t_us), this.length_us);
    this.waiting = [];
    this.open.clear();
    this.asked_us = this.t_us;
    const request = (this.oldest = ++this.request);
    this.open.set(request, "seek");
    this.out.jumped();
    this.arrived?.();
    this.out.send({ request, seek: { t_us: Math.round(this.t_us) } });
    return new Promise((resolve) => (this.arrived = resolve));
  }

  /** The connection broke: nothing that was under way will be answered. */
  lost() {
    for (const request of [...this.asked.keys()]) this.refused(request, "the connection broke before the answer");
  }

  /** The connection is a new one. */
  reconnect() {
    this.lost();
    if (this.length_us > 0) this.seek(this.t_us);
  }

  /** @param {boolean} playing */
  play(playing) {
    if (playing && this.t_us >= this.length_us && !this.growing) this.seek(0);
    this.playing = playing;
    this.last_ms = 0;
  }

  /** @param {number} speed */
  set_speed(speed) {
    this.speed = speed;
    // What was asked for has the old step: ask anew from here.
    this.waiting = [];
    this.asked_us = this.t_us;
    this.oldest = this.request + 1;
    this.open.clear();
  }

  /** A step of the given lab time, forward or back.
   * @param {number} by_us */
  step(by_us) {
    this.play(false);
    this.seek(this.t_us + by_us);
  }

  /** Lab time between two moments that are drawn. */
  get step_us() {
    return Math.max(1, Math.round((this.speed * 1e6) / moments_per_s));
  }

  /** @param {Frame} frame */
  take(frame) {
    const asked = this.asked.get(frame.request);
    if (asked) asked.frames.push(frame);
    else if (frame.request < this.oldest || !this.open.has(frame.request)) return;
    else if (this.open.get(frame.request) === "seek") this.out.show(frame);
    else this.waiting.push(frame);
  }

  /** @param {any} answer `done` of the server */
  done(answer) {
    const asked = this.asked.get(answer.request);
    this.asked.delete(answer.request);
    if (this.open.get(answer.request) === "seek") this.arrived?.();
    this.open.delete(answer.request);
    asked?.done(asked.frames, answer);
    if (asked?.elsewhere) return;
    if (answer.length_us > this.length_us) {
      // What was asked for beyond the old end was not there yet.
      this.asked_us = Math.min(this.asked_us, Math.max(this.t_us, this.length_us));
      this.length_us = answer.length_us;
    }
    if (answer.growing !== undefined) this.growing = answer.growing;
  }

  /** The server refused a request: it is over.
   * @param {number} request @param {string} why */
  refused(request, why) {
    this.done({ request, refused: why });
  }

  /** Lets wall time pass.
   * @param {number} now_ms */
  tick(now_ms) {
    if (!this.playing) return;
    // A page that was hidden goes on where it was.
    const passed_ms = this.last_ms ? Math.min(250, now_ms - this.last_ms) : 0;
    this.last_ms = now_ms;
    if (![...this.open.values()].includes("seek")) this.ask_ahead();
    // Time stands while what belongs to it is still on its way.
    const known_us = this.open.size ? Math.min(this.length_us, Math.max(this.t_us, this.waiting[this.waiting.length - 1]?.t_us ?? this.t_us)) : this.asked_us;
    this.t_us = Math.min(this.t_us + passed_ms * 1000 * this.speed, Math.max(this.t_us, known_us), this.length_us);
    let due = 0;
    while (due < this.waiting.length && this.waiting[due].t_us <= this.t_us) this.out.show(this.waiting[due++]);
    this.waiting.splice(0, due);
    if (this.t_us < this.length_us) return;
    if (!this.growing) this.playing = false;
    else if (now_ms - this.looked_ms > look_ms) {
      this.looked_ms = now_ms;
      void this.ask({ seek: { t_us: this.length_us, channels: [] } });
    }
  }

  ask_ahead() {
    const step_us = this.step_us;
    if (this.open.size >= 3 || this.asked_us >= this.length_us || this.asked_us - this.t_us > ahead * step_us) return;
    const request = ++this.request;
    this.open.set(request, "frames");
    this.out.send({ request, frames: { from_us: Math.round(this.asked_us + step_us), step_us, count: chunk, channels } });
    this.asked_us += chunk * step_us;
  }
}
