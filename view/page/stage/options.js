// What the user chose to see: one object that controls write and drawing reads.

/** @typedef {{a: import("../world/placement.js").Point, b: import("../world/placement.js").Point, words: string}} Ruler in device pixels */

export class Options {
  constructor() {
    /** @type {"side"|"together"} Labs side by side, or all in the shared frame. */
    this.mode = "side";
    /** @type {"look"|"measure"|"hand"} What a drag does: move the view, measure, or move a robot. */
    this.tool = "look";
    /** @type {import("../draw/scene.js").Shown} */
    this.shown = { labels: true, trails: true, ghosts: true, overlay: true, pictures: true };
    /** Trails show so much of the past, seconds of lab time. */
    this.trail_s = 30;
    /** @type {import("../draw/robots.js").Pick | null} */
    this.pick = null;
    this.follow = false;
    /** @type {Ruler | null} */
    this.ruler = null;
    /** Raised by each change. */
    this.version = 0;
  }

  /** @param {Partial<Options>} values */
  set(values) {
    Object.assign(this, values);
    this.version += 1;
  }

  /** @param {keyof import("../draw/scene.js").Shown} what */
  toggle(what) {
    this.shown = { ...this.shown, [what]: !this.shown[what] };
    this.version += 1;
  }
}
