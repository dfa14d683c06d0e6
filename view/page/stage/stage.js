// The canvases: three layers over each other, of which only those that changed are drawn again.
import { Panes } from "./panes.js";
import { Sprites } from "../draw/sprites.js";
import { add_to_trails } from "../draw/trails.js";
import { find } from "../draw/robots.js";
import { draw_caption, floor_layer, robot_layer, trail_layer, within } from "../draw/scene.js";

/** @typedef {import("../world/lab.js").Lab} Lab */
/** @typedef {import("../world/world.js").World} World */
/** @typedef {import("./options.js").Options} Options */
/** @typedef {import("../draw/camera_picture.js").CameraPicture} CameraPicture */

/** Trails are drawn whole so often, so that they fade, in this share of their length or milliseconds; in between only what is new. */
const whole_trails_ms = 2000, whole_trails_share = 1 / 16;
/** Height of a caption, CSS pixels. */
const caption_px = 26;

export class Stage {
  /** @param {HTMLElement} root @param {World} world @param {Options} options @param {import("../draw/colours.js").Colours} colours */
  constructor(root, world, options, colours) {
    this.root = root;
    this.world = world;
    this.options = options;
    this.panes = new Panes();
    this.sprites = new Sprites(colours);
    /** @type {Map<Lab, CameraPicture[]>} */
    this.pictures = new Map();
    /** Raised by each new camera picture. */
    this.pictures_version = 0;
    /** @type {{x: number, y: number}[]} Path of the picked robot, in its arena. */
    this.path = [];
    /** A line below the arenas; none when empty. */
    this.caption = "";
    this.contexts = ["floor", "trails", "robots"].map((name) => {
      const canvas = document.createElement("canvas");
      canvas.className = "layer";
      canvas.dataset["layer"] = name;
      root.append(canvas);
      return /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    });
    /** What each layer showed when it was drawn last. */
    this.drawn = { size: "", floor: "", trails: "", robots: "" };
    this.trails_drawn_ms = this.trails_drawn_us = 0;
    /** @type {Map<Lab, Map<number, number>>} How far each lab's trails are drawn. */
    this.trails_done = new Map();
    this.px = 1;
    this.described = "";
  }

  /** @param {import("../draw/colours.js").Colours} colours */
  recolour(colours) {
    this.sprites = new Sprites(colours);
    this.draw_anew();
  }

  /** Draws every layer whole the next time. */
  draw_anew() {
    this.drawn = { size: this.drawn.size, floor: "", trails: "", robots: "" };
  }

  /** Draws what changed.
   * @param {number} now_ms */
  draw(now_ms) {
    this.resize();
    const { options } = this;
    const { labs } = this.world;
    const [floor, trails, robots] = this.contexts;
    const { width, height } = floor.canvas;
    this.describe(labs);
    this.panes.arrange(labs, options.mode, width, height - (this.caption ? caption_px * this.px : 0), this.px);
    if (options.follow && options.pick) this.follow(options.pick);
    const places = `${this.panes.key} ${options.version}`;
    const versions = (/** @type {(lab: Lab) => any} */ of) => labs.map(of).join();

    const floor_key = `${places} ${this.pictures_version} ${versions((l) => l.floor_version)}`;
    if (floor_key !== this.drawn.floor) {
      this.drawn.floor = floor_key;
      this.layer(floor, (scene) => floor_layer(floor, scene));
    }
    const robots_now = versions((l) => l.robots_version);
    const trails_key = `${places} ${versions((l) => l.trails_epoch)}`;
    const passed_us = Math.abs(this.world.t_us - this.trails_drawn_us);
    const stale = (now_ms - this.trails_drawn_ms > whole_trails_ms || passed_us > whole_trails_share * options.trail_s * 1e6) && robots_now !== this.drawn.robots;
    if (trails_key !== this.drawn.trails || stale) {
      this.drawn.trails = trails_key;
      this.trails_drawn_ms = now_ms;
      this.trails_drawn_us = this.world.t_us;
      this.layer(trails, (scene) => trail_layer(trails, scene));
      this.trails_done = new Map(labs.map((lab) => [lab, new Map([...lab.trails].map(([robot, trail]) => [robot, trail.count]))]));
    }
    const robots_key = `${places} ${robots_now} ${this.caption}`;
    if (robots_key === this.drawn.robots) return;
    this.drawn.robots = robots_key;
    this.layer(robots, (scene) => robot_layer(robots, scene));
    if (this.caption) draw_caption(robots, this.caption, this.sprites.colours, caption_px * this.px);
    if (options.shown.trails) this.continue_trails(trails);
  }

  /** Who does not see the canvas is told what is on it.
   * @param {Lab[]} labs */
  describe(labs) {
    const words = `The arenas, from above. ${labs.map((lab) => `${lab.name}: ${lab.arena ? `${lab.arena.robots} robots` : "not known yet"}`).join("; ")}.`;
    if (this.described === words) return;
    this.described = words;
    this.contexts.forEach(({ canvas }, i) => {
      canvas.setAttribute("role", "img");
      if (i === 2) canvas.setAttribute("aria-label", words);
      else canvas.setAttribute("aria-hidden", "true");
    });
  }

  /** @param {CanvasRenderingContext2D} c */
  continue_trails(c) {
    for (const pane of this.panes.list) {
      within(c, pane.rectangle, () => {
        for (const { lab, placement } of pane.labs) {
          const done = this.trails_done.get(lab) ?? new Map();
          this.trails_done.set(lab, done);
          add_to_trails(c, lab.trails, done, placement, this.sprites.colours.inks.trail, this.px);
        }
      });
    }
  }

  /** @param {CanvasRenderingContext2D} c @param {(scene: import("../draw/scene.js").Scene) => void} draw */
  layer(c, draw) {
    c.clearRect(0, 0, c.canvas.width, c.canvas.height);
    this.panes.list.forEach((pane, i) => within(c, pane.rectangle, () => draw(this.scene(pane, i === 0))));
  }

  /** @param {import("../draw/scene.js").Pane} pane @param {boolean} first @returns {import("../draw/scene.js").Scene} */
  scene(pane, first) {
    const { shown, pick, ruler, trail_s } = this.options;
    const sizes = new Map(this.world.labs.filter((lab) => lab.shared).map((lab) => [lab.own, lab.body_radius_m() * lab.projection().scale]));
    return { trail_us: trail_s * 1e6, sizes, pane, sprites: this.sprites, px: this.px, shown, pictures: this.pictures, pick, path: this.path, ruler: first || ruler ? ruler : null };
  }

  resize() {
    this.px = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.max(1, Math.round(this.root.clientWidth * this.px)), height = Math.max(1, Math.round(this.root.clientHeight * this.px));
    const size = `${width} ${height}`;
    if (size === this.drawn.size) return;
    for (const { canvas } of this.contexts) Object.assign(canvas, { width, height });
    this.drawn = { size, floor: "", trails: "", robots: "" };
  }

  /** Keeps the picked robot in the middle.
   * @param {import("../draw/robots.js").Pick} pick */
  follow(pick) {
    for (const pane of this.panes.list) {
      for (const { lab } of pane.labs) {
        const at = find(lab, pick);
        if (!at || (pane.labs.length > 1 && lab.own !== pick.lab)) continue;
        const place = pane.labs.length > 1 ? { x: lab.projection().x(at.x, at.y), y: lab.projection().y(at.x, at.y) } : at;
        this.panes.moved.add(pane.key);
        if (pane.view.x_m === place.x && pane.view.y_m === place.y) continue;
        [pane.view.x_m, pane.view.y_m] = [place.x, place.y];
        const placement = pane.view.placement(this.panes.inner(pane, this.px));
        for (const l of pane.labs) l.placement = pane.labs.length > 1 ? l.lab.projection().then(placement) : placement;
        break;
      }
    }
  }
}
