// Divides the stage among labs: each in a pane of its own, or all in one, in the shared frame. Each pane keeps its view.
import { View } from "./view.js";

/** @typedef {import("../world/lab.js").Lab} Lab */
/** @typedef {import("./view.js").Rectangle} Rectangle */
/** @typedef {import("../draw/scene.js").Pane & {key: string, view: View}} ViewedPane */

export class Panes {
  constructor() {
    /** @type {Map<string, View>} by pane's key */
    this.views = new Map();
    /** @type {Set<string>} Panes that the user has moved are not fitted any more. */
    this.moved = new Set();
    /** @type {ViewedPane[]} */
    this.list = [];
  }

  /** @param {Lab[]} labs @param {"side"|"together"} mode @param {number} width @param {number} height device pixels @param {number} px */
  arrange(labs, mode, width, height, px) {
    const together = mode === "together" && labs.length > 1;
    const groups = together ? [labs] : labs.map((lab) => [lab]);
    const columns = Math.max(1, best_columns(groups.length, width, height));
    const rows = Math.max(1, Math.ceil(groups.length / columns));
    const title_px = 24 * px;
    this.list = groups.map((group, i) => {
      const rectangle = {
        x: Math.floor(((i % columns) * width) / columns), y: Math.floor((Math.floor(i / columns) * height) / rows),
        width: Math.floor(width / columns), height: Math.floor(height / rows),
      };
      const key = together ? "together" : group[0].name;
      let view = this.views.get(key);
      if (!view) this.views.set(key, (view = new View()));
      const inner = { ...rectangle, y: rectangle.y + title_px, height: Math.max(1, rectangle.height - title_px) };
      if (!this.moved.has(key)) view.fit(together ? bounds(group) : around(group[0].size), inner);
      const placement = view.placement(inner);
      return {
        key, view, rectangle: inner, title: together ? `${group.map((l) => l.name).join(" + ")}, shared frame` : title_of(group[0]),
        labs: group.map((lab) => ({ lab, placement: together ? lab.projection().then(placement) : placement })),
      };
    });
    for (const pane of this.list) pane.rectangle = { ...pane.rectangle, y: pane.rectangle.y - title_px, height: pane.rectangle.height + title_px };
  }

  /** The pane's rectangle below its title, which its view refers to.
   * @param {ViewedPane} pane @param {number} px @returns {Rectangle} */
  inner(pane, px) {
    const title_px = 24 * px;
    return { ...pane.rectangle, y: pane.rectangle.y + title_px, height: pane.rectangle.height - title_px };
  }

  /** @param {number} x @param {number} y device pixels */
  at(x, y) {
    return this.list.find(({ rectangle: r }) => x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height);
  }

  /** Shows everything again. */
  fit() {
    this.moved.clear();
  }

  /** All that decides where things are drawn. */
  get key() {
    return this.list.map((p) => `${p.key} ${p.view.x_m} ${p.view.y_m} ${p.view.px_per_m} ${p.rectangle.x} ${p.rectangle.y} ${p.rectangle.width} ${p.rectangle.height} ${p.labs.map((l) => l.placement.shift_x + "," + l.placement.scale)}`).join(";");
  }
}

/** @param {Lab} lab */
function title_of(lab) {
  const others = lab.ghosts.map((fleet) => fleet.lab);
  return others.length ? `${lab.name}, dashed: ${others.join(", ")}` : lab.name;
}

/** How many columns make square panes largest.
 * @param {number} n @param {number} width @param {number} height */
function best_columns(n, width, height) {
  let best = 1, side = 0;
  for (let columns = 1; columns <= n; ++columns) {
    const s = Math.min(width / columns, height / Math.ceil(n / columns));
    if (s > side) [best, side] = [columns, s];
  }
  return best;
}

/** @param {{width: number, height: number}} size @returns {Rectangle} */
function around({ width, height }) {
  return { x: -width / 2, y: -height / 2, width, height };
}

/** What holds all arenas, in the shared frame.
 * @param {Lab[]} labs @returns {Rectangle} */
function bounds(labs) {
  let left = Infinity, right = -Infinity, low = Infinity, high = -Infinity;
  for (const lab of labs) {
    const p = lab.projection(), { width, height } = lab.size;
    for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
      const x = p.x((sx * width) / 2, (sy * height) / 2), y = p.y((sx * width) / 2, (sy * height) / 2);
      [left, right, low, high] = [Math.min(left, x), Math.max(right, x), Math.min(low, y), Math.max(high, y)];
    }
  }
  return { x: left, y: low, width: right - left, height: high - low };
}
