// Where labels go, so that none lies on another or on a robot. Pixels throughout.

/** @typedef {{x: number, y: number, width: number, height: number}} Box its middle and its sides */
/** @typedef {Box & {radius?: number}} Taken of a disc with its radius, else of a label */
/** @typedef {import("../wire/lcm.js").Message} Message */
/** @typedef {import("../world/placement.js").Placement} Placement */

/** What is taken is kept by squares of this side. */
const cell_px = 48;
/** Labels may touch by so much. */
const touch_px = 0.5;
/** A label that would lie on others goes up by so many lines at most. */
const lines_most = 4;
/** Where a robot's label may lie: above, below, at its sides, at its corners. */
const sides = [[0, -1], [0, 1], [1, 0], [-1, 0], [0.7, -0.7], [-0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]];

/** What is taken already. */
export class Places {
  constructor() {
    /** @type {Map<number, Taken[]>} by square */
    this.cells = new Map();
  }

  /** @param {Taken} taken */
  add(taken) {
    for (const key of squares(taken)) {
      const there = this.cells.get(key);
      if (there) there.push(taken);
      else this.cells.set(key, [taken]);
    }
  }

  /** @param {number} x @param {number} y @param {number} radius */
  add_disc(x, y, radius) {
    this.add({ x, y, width: 2 * radius, height: 2 * radius, radius });
  }

  /** @param {Box} box */
  is_free(box) {
    return squares(box).every((key) => (this.cells.get(key) ?? []).every((taken) => !meet(box, taken)));
  }
}

/** What few labels may not lie on: discs of any size, which squares would take too long for. */
export class Discs {
  /** @param {{x: number, y: number, radius: number}[]} discs */
  constructor(discs) {
    /** @type {Taken[]} */
    this.discs = discs.map(({ x, y, radius }) => ({ x, y, width: 2 * radius, height: 2 * radius, radius }));
  }

  /** @param {Box} box */
  is_free(box) {
    return this.discs.every((disc) => !meet(box, disc));
  }
}

/** Circles that no circle's label may lie on. Not those that surround a labelled one, whose label would find no room at any zoom.
 * @param {Message[]} circles of an overlay_t @param {Placement} p */
export function sites_of(circles, p) {
  const labelled = circles.filter((circle) => circle.label);
  const surrounds = (/** @type {Message} */ a, /** @type {Message} */ b) => b.radius_m < a.radius_m && Math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) < a.radius_m;
  const sites = labelled.length ? circles.filter((circle) => (circle.label || !circle.dashed) && !labelled.some((other) => surrounds(circle, other))) : [];
  return new Discs(sites.map((circle) => ({ x: p.x(circle.x_m, circle.y_m), y: p.y(circle.x_m, circle.y_m), radius: circle.radius_m * p.scale })));
}

/** @param {Box} box @returns {number[]} */
function squares({ x, y, width, height }) {
  const keys = [];
  const [left, right, top, low] = [x - width / 2, x + width / 2, y - height / 2, y + height / 2].map((at) => Math.floor(at / cell_px));
  for (let i = left; i <= right; ++i) for (let j = top; j <= low; ++j) keys.push(i * 65_536 + j);
  return keys;
}

/** @param {Box} a @param {Taken} b */
function meet(a, b) {
  const dx = Math.abs(a.x - b.x), dy = Math.abs(a.y - b.y);
  if (b.radius === undefined) return dx < (a.width + b.width) / 2 && dy < (a.height + b.height) / 2 - touch_px;
  return Math.hypot(Math.max(0, dx - a.width / 2), Math.max(0, dy - a.height / 2)) < b.radius;
}

/** Where a label goes: at the first of these places, each tried higher and higher, at which it lies on nothing; null where there is no room.
 * @param {Places} places gets it, too @param {Places | Discs | null} more what it may not lie on either @param {Box[]} wanted
 * @returns {Box | null} */
export function place_label(places, more, ...wanted) {
  for (let line = 0; line < lines_most; ++line) {
    for (const each of wanted) {
      const box = { ...each, y: each.y - line * each.height };
      if (!places.is_free(box) || (more && !more.is_free(box))) continue;
      places.add(box);
      return box;
    }
  }
  return null;
}

/** Where a label of that size goes beside a robot, or null where there is no room at any side of it.
 * @param {Places} places gets it, too @param {Places | null} more what it may not lie on either @param {number} x @param {number} y @param {number} radius of the robot @param {number} width @param {number} height
 * @returns {Box | null} */
export function place_beside(places, more, x, y, radius, width, height) {
  for (const [across, down] of sides) {
    const box = { x: x + across * (radius + width / 2 + 1), y: y + down * (radius + height / 2 + 1), width, height };
    if (!places.is_free(box) || (more && !more.is_free(box))) continue;
    places.add(box);
    return box;
  }
  return null;
}
