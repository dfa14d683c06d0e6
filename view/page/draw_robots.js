// Draws what moves: objects, ghosts of other labs' robots, own robots with their ids, and what was picked.
import { label } from "./label.js";
import { solid_path } from "./draw_floor.js";

/**
 * @typedef {CanvasRenderingContext2D} Context
 * @typedef {import("./lab.js").Lab} Lab
 * @typedef {import("./placement.js").Placement} Placement
 * @typedef {import("./sprites.js").Sprites} Sprites
 * @typedef {{lab: string, id: number}} Pick lab: its name among labs
 */

/** Ids are written where a body is at least so large, pixels across. */
const labelled_px = 11;
/** A ghost's opacity when new, and how much lab time makes it fade to 1/e: this many exchange periods, at least a second. */
const ghost_opacity = 0.75, ghost_periods = 4;

/** @param {Lab} lab @param {import("./lab.js").GhostFleet} fleet */
export function opacity_of(lab, fleet) {
  const fade_us = Math.max(1_000_000, ghost_periods * lab.period_us());
  return Math.max(0.12, ghost_opacity * Math.exp(-Math.max(0, lab.age_us(fleet) - lab.period_us()) / fade_us));
}

/**
 * Objects that robots push.
 * @param {Context} c @param {Lab} lab @param {Placement} p @param {Sprites} sprites @param {number} px
 */
export function draw_objects(c, lab, p, sprites, px) {
  const arena = lab.arena;
  if (!arena?.n_objects) return;
  const { object, ink, ground } = sprites.colours.inks;
  const first = arena.solids.length - arena.n_objects;
  for (let i = 0; i < arena.n_objects; ++i) {
    const solid = arena.solids[first + i];
    const at = lab.objects[i] ?? { x: solid.x_m, y: solid.y_m, heading: solid.heading_rad };
    solid_path(c, p, arena, solid, at);
    c.fillStyle = object;
    c.fill();
    c.strokeStyle = ink;
    c.lineWidth = 1.5 * px;
    c.stroke();
    const name = label(arena.object_names[i] ?? "", ink, ground, 11 * px);
    c.drawImage(name.image, Math.round(p.x(at.x, at.y) - name.width / 2), Math.round(p.y(at.x, at.y) - name.height / 2));
  }
}

/**
 * Robots of other labs, as large as they are in this arena where the scale of their lab's projection is known.
 * @param {Context} c @param {Lab} lab @param {Placement} p @param {Sprites} sprites @param {number} px @param {boolean} labels @param {Map<string, number>} scales by lab
 */
export function draw_ghosts(c, lab, p, sprites, px, labels, scales) {
  const own = lab.projection().scale;
  for (const fleet of lab.ghosts) {
    const radius = Math.max(2 * px, (lab.body_radius_m() * p.scale * (scales.get(fleet.lab) ?? own)) / own);
    c.globalAlpha = opacity_of(lab, fleet);
    for (const ghost of fleet.robots) robot(c, ghost, p, sprites, radius, true);
    if (labels && 2 * radius >= labelled_px * px) {
      for (const ghost of fleet.robots) name(c, `${ghost.id}`, ghost, p, sprites, radius, px, true);
    }
  }
  c.globalAlpha = 1;
}

/** @param {Context} c @param {Lab} lab @param {Placement} p @param {Sprites} sprites @param {number} px @param {boolean} labels */
export function draw_robots(c, lab, p, sprites, px, labels) {
  const radius = Math.max(2 * px, lab.body_radius_m() * p.scale);
  for (const r of lab.robots) {
    const doubtful = r.confidence < 0.5;
    if (doubtful) c.globalAlpha = 0.45;
    robot(c, r, p, sprites, radius, false);
    if (doubtful) c.globalAlpha = 1;
  }
  if (!labels || 2 * radius < labelled_px * px) return;
  for (const r of lab.robots) name(c, r.confidence < 0.5 ? `${r.id}?` : `${r.id}`, r, p, sprites, radius, px);
}

/** @param {Context} c @param {{x: number, y: number, heading: number, led: number}} r @param {Placement} p @param {Sprites} sprites @param {number} radius @param {boolean} ghost */
function robot(c, r, p, sprites, radius, ghost) {
  const sprite = sprites.robot(r.led, r.heading + p.turn_rad, radius, ghost);
  const half = sprite.width / 2;
  c.drawImage(sprite, Math.round(p.x(r.x, r.y) - half), Math.round(p.y(r.x, r.y) - half));
}

/** @param {Context} c @param {string} words @param {{x: number, y: number}} r @param {Placement} p @param {Sprites} sprites @param {number} radius @param {number} px @param {boolean} [ghost] */
function name(c, words, r, p, sprites, radius, px, ghost = false) {
  const { ink, trail, halo } = sprites.colours.inks;
  const made = label(words, ghost ? trail : ink, halo, (ghost ? 9 : 10) * px);
  c.drawImage(made.image, Math.round(p.x(r.x, r.y) - made.width / 2), Math.round(p.y(r.x, r.y) - radius - made.height + 2 * px));
}

/**
 * A ring around what was picked, and its path.
 * @param {Context} c @param {Lab} lab @param {Placement} p @param {string} ink @param {number} px @param {Pick} pick @param {{x: number, y: number}[]} path in this lab's arena
 */
export function draw_pick(c, lab, p, ink, px, pick, path) {
  const at = find(lab, pick);
  c.strokeStyle = ink;
  c.lineWidth = 2 * px;
  if (pick.lab === lab.own && path.length > 1) {
    c.beginPath();
    for (const q of path) c.lineTo(p.x(q.x, q.y), p.y(q.x, q.y));
    c.stroke();
  }
  if (!at) return;
  c.beginPath();
  c.arc(p.x(at.x, at.y), p.y(at.x, at.y), Math.max(9 * px, lab.body_radius_m() * p.scale * 1.8), 0, 2 * Math.PI);
  c.stroke();
}

/**
 * The robot or ghost of that id as this lab sees it.
 * @param {Lab} lab @param {Pick} pick
 */
export function find(lab, pick) {
  if (pick.lab === lab.own) return lab.robots.find((r) => r.id === pick.id);
  return lab.ghosts.find((f) => f.lab === pick.lab)?.robots.find((r) => r.id === pick.id);
}
