// Mouse and fingers on the stage: move and zoom the view, pick a robot, measure, move a robot by hand.
import { find } from "../draw/robots.js";
import { distance_words } from "../words.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {import("../world/placement.js").Point} Point */
/** @typedef {import("./panes.js").ViewedPane} ViewedPane */

/** A press that moves less than this is a click, CSS pixels. */
const click_px = 5;

export class Pointer {
  /** @param {Stage} stage @param {import("./options.js").Options} options @param {(lab: import("../world/lab.js").Lab, robot: number, at: Point) => void} move puts a robot at a place in its arena */
  constructor(stage, options, move) {
    this.stage = stage;
    this.options = options;
    this.move = move;
    /** @type {Map<number, Point>} Fingers that are down, in device pixels. */
    this.down = new Map();
    /** @type {{pane: ViewedPane, at: Point, far: boolean, robot: {lab: import("../world/lab.js").Lab, id: number} | null} | null} */
    this.press = null;
    const root = stage.root;
    root.addEventListener("pointerdown", (e) => this.pressed(e));
    root.addEventListener("pointermove", (e) => this.moved(e));
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) root.addEventListener(end, (e) => this.released(e));
    root.addEventListener("dblclick", () => this.fit());
    root.addEventListener("wheel", (e) => {
      e.preventDefault();
      const at = this.place(e);
      this.zoom(Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015)), at);
    }, { passive: false });
  }

  /** @param {MouseEvent} e @returns {Point} */
  place(e) {
    const box = this.stage.root.getBoundingClientRect();
    return { x: (e.clientX - box.x) * this.stage.px, y: (e.clientY - box.y) * this.stage.px };
  }

  fit() {
    this.stage.panes.fit();
    this.options.set({ follow: false, ruler: null });
  }

  /** @param {number} factor @param {Point} [at] default: the middle of each pane */
  zoom(factor, at) {
    const { panes, px } = this.stage;
    const pane = at && panes.at(at.x, at.y);
    for (const each of pane ? [pane] : panes.list) {
      const inner = panes.inner(each, px);
      const point = pane && at ? at : { x: inner.x + inner.width / 2, y: inner.y + inner.height / 2 };
      panes.moved.add(each.key);
      each.view.zoom(factor, point.x, point.y, inner);
    }
  }

  /** Moves the view of every pane.
   * @param {number} dx_px @param {number} dy_px CSS pixels */
  pan(dx_px, dy_px) {
    const { panes, px } = this.stage;
    for (const pane of panes.list) {
      panes.moved.add(pane.key);
      pane.view.pan(-dx_px * px, -dy_px * px);
    }
  }

  /** @param {PointerEvent} e */
  pressed(e) {
    const at = this.place(e), pane = this.stage.panes.at(at.x, at.y);
    this.down.set(e.pointerId, at);
    if (!pane || this.down.size > 1) return;
    try {
      this.stage.root.setPointerCapture(e.pointerId);
    } catch { /* the pointer is gone already */ }
    const hit = this.hit(pane, at);
    const own = hit && pane.labs.find((l) => l.lab.own === hit.lab)?.lab;
    this.press = { pane, at, far: false, robot: this.options.tool === "hand" && hit && own ? { lab: own, id: hit.id } : null };
  }

  /** @param {PointerEvent} e */
  moved(e) {
    const before = this.down.get(e.pointerId);
    if (!before || !this.press) return;
    const at = this.place(e), { panes, px } = this.stage, { pane, at: from, robot } = this.press;
    if (this.down.size === 2) {
      const [other] = [...this.down].filter(([id]) => id !== e.pointerId).map(([, p]) => p);
      const spread = Math.hypot(at.x - other.x, at.y - other.y), was = Math.hypot(before.x - other.x, before.y - other.y);
      panes.moved.add(pane.key);
      if (was > 0) pane.view.zoom(spread / was, (at.x + other.x) / 2, (at.y + other.y) / 2, panes.inner(pane, px));
    }
    this.press.far ||= Math.hypot(at.x - from.x, at.y - from.y) > click_px * px;
    this.down.set(e.pointerId, at);
    if (!this.press.far) return;
    if (this.options.tool === "measure" || robot) this.measure(pane, from, at);
    else {
      panes.moved.add(pane.key);
      if (this.options.follow) this.options.set({ follow: false });
      pane.view.pan((at.x - before.x) / (this.down.size || 1), (at.y - before.y) / (this.down.size || 1));
    }
  }

  /** @param {PointerEvent} e */
  released(e) {
    const at = this.place(e), press = this.press;
    this.down.delete(e.pointerId);
    if (this.down.size) return;
    this.press = null;
    if (!press || e.type === "pointercancel") return;
    if (!press.far) {
      const hit = this.hit(press.pane, at);
      this.options.set({ pick: hit, follow: this.options.follow && hit !== null, ruler: null });
    } else if (press.robot) {
      const { lab, id } = press.robot;
      const placement = press.pane.labs.find((l) => l.lab === lab)?.placement;
      if (placement) this.move(lab, id, placement.inverse(at.x, at.y));
      this.options.set({ ruler: null });
    }
  }

  /** @param {ViewedPane} pane @param {Point} from @param {Point} to */
  measure(pane, from, to) {
    if (this.stage.panes.at(to.x, to.y)?.key !== pane.key) return this.options.set({ ruler: { a: from, b: to, words: "measure within one arena" } });
    const shared = pane.labs.length > 1;
    const placement = shared ? pane.view.placement(this.stage.panes.inner(pane, this.stage.px)) : pane.labs[0].placement;
    const a = placement.inverse(from.x, from.y), b = placement.inverse(to.x, to.y);
    this.options.set({ ruler: { a: from, b: to, words: distance_words(Math.hypot(b.x - a.x, b.y - a.y)) + (shared ? " shared" : "") } });
  }

  /** The nearest robot, or ghost, under a point.
   * @param {ViewedPane} pane @param {Point} at @returns {import("../draw/robots.js").Pick | null} */
  hit(pane, at) {
    let best = null, nearest = Infinity;
    for (const { lab, placement } of pane.labs) {
      const reach = Math.max(10 * this.stage.px, lab.body_radius_m() * placement.scale * 1.3);
      const all = [{ lab: lab.own, robots: /** @type {{id: number, x: number, y: number}[]} */ (lab.robots) }];
      if (pane.labs.length === 1 && this.options.shown.ghosts) all.push(...lab.ghosts);
      for (const fleet of all) {
        for (const r of fleet.robots) {
          const d = Math.hypot(placement.x(r.x, r.y) - at.x, placement.y(r.x, r.y) - at.y);
          if (d < reach && d < nearest) [best, nearest] = [{ lab: fleet.lab, id: r.id }, d];
        }
      }
    }
    return best;
  }

  /** Picks the next or previous robot of the first lab that has the picked one.
   * @param {1 | -1} step */
  next(step) {
    const { pick } = this.options, labs = this.stage.world.labs;
    const lab = labs.find((l) => l.own === pick?.lab) ?? labs[0];
    if (!lab?.robots.length) return;
    const at = pick && find(lab, pick) ? lab.robots.findIndex((r) => r.id === pick.id) + step : 0;
    this.options.set({ pick: { lab: lab.own, id: lab.robots[(at + lab.robots.length) % lab.robots.length].id } });
  }
}
