// What the page knows of one lab: the newest of each channel, its robots, their trails, and ghosts of other labs' robots.
// Takes decoded messages; knows neither where they come from nor how they are drawn.
import { DecodeError } from "../wire/lcm.js";
import { Trail, points_each } from "./trail.js";
import { identity, projection } from "./placement.js";

/** @typedef {{id: number, x: number, y: number, heading: number, led: number, confidence: number, age_us: number}} Robot arena frame: metres, radians */
/** @typedef {{lab: string, id: number, x: number, y: number, heading: number, led: number}} Ghost in this lab's arena frame */
/** @typedef {{lab: string, age_us: number, robots: Ghost[]}} GhostFleet age when it was merged, microseconds of lab time */
/** @typedef {{t_us: number, slot: number, kind: string, value: string}} ToRobot */
/** @typedef {{t_us: number, count: number, bytes: Uint8Array}} Newest */
/** @typedef {{name: string, width_px: number, height_px: number, arena_to_px: number[]}} Camera */
/** @typedef {import("../wire/lcm.js").Message} Message */

/** Parts that a frame may have: a thousand robots each. */
const parts_most = 1000;
/** Newest messages to a robot that are kept. */
const messages_each = 8;
const everyone = -1; // whole_to_robot_t
/** What a robot printed is kept up to so many characters. */
const text_most = 4000;

export class Lab {
  /** @param {number} index @param {string} name as the server lists it: LAB, or RUN/LAB */
  constructor(index, name) {
    this.index = index;
    this.name = name;
    /** Its name among labs. */
    this.own = name.slice(name.lastIndexOf("/") + 1);
    /** @type {Map<string, Newest>} by channel */
    this.newest = new Map();
    /** @type {Camera[]} */
    this.cameras = [];
    /** What its camera pictures were made for. */
    this.cameras_key = "";
    /** Raised by each change of what lies still: arena, overlay, camera. */
    this.floor_version = 0;
    /** Raised by each change of robots or ghosts. */
    this.robots_version = 0;
    /** @type {Message | null} */
    this.arena = null;
    /** @type {Message | null} */
    this.status = null;
    /** How many have come. */
    this.statuses = 0;
    /** When anything of it came, milliseconds of the page's clock; 0: never. */
    this.heard_ms = 0;
    /** @type {Message | null} */
    this.peers = null;
    /** @type {Message | null} */
    this.shared = null;
    /** @type {Message | null} */
    this.overlay = null;
    /** @type {Message[]} What the scenario tells of what is seen (shown_words_t). */
    this.shown = [];
    /** @type {Robot[]} ascending id */
    this.robots = [];
    /** @type {{x: number, y: number, heading: number}[]} */
    this.objects = [];
    /** @type {GhostFleet[]} */
    this.ghosts = [];
    /** @type {Map<number, Trail>} by robot */
    this.trails = new Map();
    /** @type {Map<number, ToRobot[]>} by robot, the newest first */
    this.told = new Map();
    /** @type {Map<number, string>} by robot, what its program printed last */
    this.texts = new Map();
    /** Of the newest texts that were taken: the server says the newest again to whoever comes. */
    this.texts_us = -1;
    /** @type {Robot[][]} robots of each part of a frame */
    this.parts = [];
    /** Lab time of the newest of anything that was drawn, microseconds. */
    this.t_us = 0;
    /** Raised when trails begin anew. */
    this.trails_epoch = 0;
  }

  /** Drops everything that a jump in time makes wrong. */
  forget() {
    const { newest, cameras, cameras_key, arena, shown, heard_ms, statuses } = this;
    const versions = { floor_version: this.floor_version + 1, robots_version: this.robots_version + 1, trails_epoch: this.trails_epoch + 1 };
    Object.assign(this, new Lab(this.index, this.name), { newest, cameras, cameras_key, arena, shown, heard_ms, statuses }, versions);
  }

  /** Takes one message.
   * @param {string} channel @param {Message} value @param {number} t_us */
  absorb(channel, value, t_us) {
    if (channel === "poses") this.take_poses(value);
    else if (channel === "shared") this.take_shared(value);
    else if (channel === "to_robots") this.take_told(value);
    else if (channel === "robot_texts") this.take_texts(value);
    else if (channel === "arena") {
      this.arena = value;
      this.floor_version += 1;
    } else if (channel === "overlay") {
      this.overlay = value;
      this.floor_version += 1;
    } else if (channel === "shown") this.shown = value.words;
    else if (channel === "status") {
      this.status = value;
      this.statuses += 1;
    } else if (channel === "peers") this.peers = value;
    if (t_us > this.t_us) this.t_us = t_us;
  }

  /** @param {Message} frame pose_frame_t */
  take_poses(frame) {
    if (!(frame.parts >= 1 && frame.parts <= parts_most && frame.part >= 0 && frame.part < frame.parts)) throw new DecodeError(`is part ${frame.part} of ${frame.parts}`);
    if (frame.part === 0) this.objects = frame.objects.map((/** @type {Message} */ o) => ({ x: o.x_m, y: o.y_m, heading: o.heading_rad }));
    const robots = frame.robots.map((/** @type {Message} */ r) => (
      { id: r.robot, x: r.x_m, y: r.y_m, heading: r.heading_rad, led: r.led, confidence: r.confidence, age_us: r.age_us }));
    this.parts.length = frame.parts;
    this.parts[frame.part] = robots;
    this.robots = frame.parts === 1 ? robots : this.parts.flat();
    const points = points_each(this.robots.length);
    for (const robot of robots) {
      let trail = this.trails.get(robot.id);
      if (!trail) this.trails.set(robot.id, (trail = new Trail(points)));
      trail.add(robot.x, robot.y, frame.stamp_us);
    }
    this.robots_version += 1;
  }

  /** @param {Message} view shared_view_t */
  take_shared(view) {
    this.shared = view;
    const own = this.projection();
    const period_us = this.period_us();
    this.ghosts = view.labs.filter((/** @type {Message} */ l) => l.lab !== this.own).map((/** @type {Message} */ l) => ({
      lab: l.lab,
      age_us: l.age_periods * period_us,
      robots: l.robots.map((/** @type {Message} */ r) => ({
        lab: l.lab, id: r.robot, led: r.led,
        ...own.inverse(r.x_um / 1e6, r.y_um / 1e6), heading: r.heading_urad / 1e6 - own.turn_rad,
      })),
    }));
    this.robots_version += 1;
  }

  /** @param {Message} batch robot_texts_t */
  take_texts(batch) {
    if (batch.stamp_us === this.texts_us) return;
    this.texts_us = batch.stamp_us;
    for (const { robot, text } of batch.texts) this.texts.set(robot, ((this.texts.get(robot) ?? "") + text).slice(-text_most));
  }

  /** @param {Message} batch to_robots_t */
  take_told(batch) {
    for (const m of batch.messages) this.add_told(m.robot, { t_us: batch.stamp_us, slot: m.slot, kind: `${m.kind}`, value: `${m.value}` });
    for (const m of batch.whole ?? []) { // recordings of before know none
      const bytes = [...m.data].map((/** @type {number} */ byte) => (byte & 255).toString(16).padStart(2, "0")).join(" ");
      this.add_told(m.robot, { t_us: batch.stamp_us, slot: m.slot, kind: `message of type ${m.type}`, value: bytes });
    }
  }

  /** @param {number} robot or everyone
   * @param {ToRobot} told */
  add_told(robot, told) {
    const list = this.told.get(robot) ?? [];
    list.unshift(told);
    list.length = Math.min(list.length, messages_each);
    this.told.set(robot, list);
  }

  /** What a robot was told, alone and with all others, the newest first.
   * @param {number} robot */
  told_to(robot) {
    const both = [...(this.told.get(robot) ?? []), ...(this.told.get(everyone) ?? [])];
    return both.sort((a, b) => b.t_us - a.t_us).slice(0, messages_each);
  }

  /** From this lab's arena to the shared frame. */
  projection() {
    return this.shared ? projection(/** @type {any} */ (this.shared)) : identity;
  }

  /** Length of an exchange period, microseconds; 0 while unknown. */
  period_us() {
    return this.shared && this.shared.period > 0 ? this.shared.stamp_us / this.shared.period : 0;
  }

  /** How old the robots of a fleet are by now, microseconds of lab time.
   * @param {GhostFleet} fleet */
  age_us(fleet) {
    return fleet.age_us + Math.max(0, this.t_us - (this.shared?.stamp_us ?? 0));
  }

  /** Radius of a robot seen from above, metres; 0 until the arena tells it. */
  body_radius_m() {
    return this.arena?.body_radius_m ?? 0;
  }

  /** Sides of the arena, metres. */
  get size() {
    return { width: this.arena?.width_m ?? 1, height: this.arena?.height_m ?? 1 };
  }

  /** A counter of `status`, or undefined.
   * @param {string} name */
  counter(name) {
    return this.status?.counters.find((/** @type {Message} */ c) => c.name === name)?.value;
  }

  /** What the scenario counts: name and number.
   * @returns {[string, number][]} */
  counts() {
    return (this.status?.counters ?? []).filter((/** @type {Message} */ c) => c.name.startsWith("counts."))
      .map((/** @type {Message} */ c) => [c.name.slice("counts.".length), Number(c.value)]);
  }
}
