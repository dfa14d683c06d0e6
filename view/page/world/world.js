// All labs that a server shows, what it says of itself, and the events. Decodes frames and hands them to their labs.
import { DecodeError } from "../wire/lcm.js";
import { Lab } from "./lab.js";

/** @typedef {{t_us: number, lab: number, kind: string, text: string}} Event */
/** @typedef {{version: string, mode: "live"|"recorded", labs: string[], control: boolean, run: string, folder?: string, emulator?: boolean[], commands?: [string, string, string][],
 *   length_us?: number, growing?: boolean, runs?: string[], number?: number, notes?: string[], first_difference?: {period: number, lab: string, t_us: number} | null}} About */
/** @typedef {{per_s: number, bytes_per_s: number, count: number}} Rate */
/** @typedef {import("../wire/wire.js").Frame} Frame */

/** Events that are kept; older ones go. */
const events_most = 2000;

/** Reasons for not understanding a message that are told apart; others count together. */
const reasons_most = 100;
const other_reasons = "other reasons";

/** Channels that are decoded as they come; others only when somebody looks. */
const decoded = new Set(["arena", "poses", "shared", "shown", "overlay", "status", "peers", "to_robots", "robot_texts"]);

export class World {
  /** @param {import("../wire/lcm.js").Types} types */
  constructor(types) {
    this.types = types;
    /** @type {About} */
    this.about = { version: "", mode: "live", labs: [], control: false, run: "" };
    /** @type {Lab[]} */
    this.labs = [];
    /** @type {Event[]} in the order in which they came */
    this.events = [];
    this.events_version = 0;
    /** @type {Record<string, Rate>[]} by lab, then channel */
    this.rates = [];
    /** What this viewer missed because it was slow. */
    this.replaced = 0;
    /** @type {Map<string, number>} Messages that were not understood: why, and how many. */
    this.not_understood = new Map();
  }

  /** Begins anew with the labs of this server, unless they are the same.
   * @param {About} about */
  introduce(about) {
    const same = about.labs.join() === this.about.labs.join() && about.mode === this.about.mode && about.run === this.about.run;
    this.about = about;
    // A server tells its newest events again to whoever comes.
    this.events = [];
    this.events_version += 1;
    if (!same) this.labs = about.labs.map((name, index) => new Lab(index, name));
  }

  /** Takes a message from the server; false when it changes nothing that is drawn.
   * @param {Frame} frame */
  take(frame) {
    const lab = this.labs[frame.lab];
    if (!lab) return this.refuse(`there is no lab ${frame.lab} among ${this.labs.length}`);
    const before = lab.newest.get(frame.channel);
    lab.newest.set(frame.channel, { t_us: frame.t_us, count: (before?.count ?? 0) + 1, bytes: frame.data });
    if (!decoded.has(frame.channel)) return false;
    try {
      // A lab that was started again begins at 0.
      if (frame.channel === "poses" && this.about.mode === "live" && frame.t_us < lab.t_us - 1_000_000) lab.forget();
      lab.absorb(frame.channel, this.types.decode(frame.data).value, frame.t_us);
      return true;
    } catch (error) {
      if (!(error instanceof DecodeError)) throw error;
      return this.refuse(`a message of ${frame.channel} ${error.message}`);
    }
  }

  /** @param {string} why */
  refuse(why) {
    const kind = this.not_understood.has(why) || this.not_understood.size < reasons_most ? why : other_reasons;
    this.not_understood.set(kind, (this.not_understood.get(kind) ?? 0) + 1);
    return false;
  }

  /** @param {Event[]} events */
  tell(events) {
    this.events.push(...events);
    if (this.events.length > events_most) this.events.splice(0, this.events.length - events_most);
    this.events_version += 1;
  }

  /** Lab time of the lab that is furthest, microseconds. */
  get t_us() {
    return this.labs.reduce((most, lab) => Math.max(most, lab.t_us), 0);
  }
}
