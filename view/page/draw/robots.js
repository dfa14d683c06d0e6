// Draws what moves: objects, ghosts of other labs' robots, own robots, their ids, and what was picked.
import { label } from "./label.js";
import { Places, place_beside } from "./label_place.js";
import { solid_path } from "./floor.js";

/** @typedef {CanvasRenderingContext2D} Context */
/** @typedef {import("../world/lab.js").Lab} Lab */
/** @typedef {import("../world/placement.js").Placement} Placement */
/** @typedef {import("./sprites.js").Sprites} Sprites */
/** @typedef {{lab: string, id: number}} Pick lab: its name among labs */

/** The height of digits beside that of their line, and the room beside the widest, of a label. */
const digit_height = 0.8, beside_words = 0.5;
/** How far a nose reaches out of a robot's body, and what it takes of the space there, in radii of the body. */
const nose_at = 1.2, nose_radius = 0.25;
/** Ids are written where a body is at least so large, pixels across. */
const labelled_px = 11;
/** A ghost's opacity when new, and how much lab time makes it fade to 1/e: this many exchange periods, at least a second. */
const ghost_opacity = 0.75, ghost_periods = 4;

/** @param {Lab} lab @param {import("../world/lab.js").GhostFleet} fleet */
export function opacity_of(lab, fleet) {
  const fade_us = Math.max(1_000_000, ghost_periods * lab.period_us());
  return Math.max(0.12, ghost_opacity * Math.exp(-Math.max(0, lab.age_us(fleet) - lab.period_us()) / fade_us));
}

/** Objects that robots push.
 * @param {Context} c @param {Lab} lab @param {Placement} p @param {Sprites} sprites @param {number} px */
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

/** Pixels of a body: of an own robot, or of another lab's, as large as it is in this arena where its lab is known, else as an own one.
 * @param {Lab} lab @param {Placement} p @param {number} px @param {string} of a lab's name @param {Map<string, number>} sizes radius in the shared world, metres, by lab */
function radius_of(lab, p, px, of, sizes) {
  const shared_m = of === lab.own ? undefined : sizes.get(of);
  return Math.max(2 * px, (shared_m === undefined ? lab.body_radius_m() : shared_m / lab.projection().scale) * p.scale);
}

/** Robots of other labs.
 * @param {Context} c @param {Lab} lab @param {Placement} p @param {Sprites} sprites @param {number} px @param {Map<string, number>} sizes by lab */
export function draw_ghosts(c, lab, p, sprites, px, sizes) {
  for (const fleet of lab.ghosts) {
    const radius = radius_of(lab, p, px, fleet.lab, sizes);
    c.globalAlpha = opacity_of(lab, fleet);
    for (const ghost of fleet.robots) robot(c, ghost, p, sprites, radius, true);
  }
  c.globalAlpha = 1;
}

/** @param {Context} c @param {Lab} lab @param {Placement} p @param {Sprites} sprites @param {number} px @param {boolean} rings see-through, over a camera picture */
export function draw_robots(c, lab, p, sprites, px, rings) {
  const radius = radius_of(lab, p, px, lab.own, new Map());
  for (const r of lab.robots) {
    const doubtful = r.confidence < 0.5;
    if (doubtful) c.globalAlpha = 0.45;
    robot(c, r, p, sprites, radius, false, rings);
    if (doubtful) c.globalAlpha = 1;
  }
}

/** @typedef {{words: string, x: number, y: number, radius: number, opacity: number, ghost: boolean}} Named a robot whose body is large enough for an id; pixels */
/** @typedef {Named & {box: import("./label_place.js").Box}} Name where its id lies */

/** Robots that are to have a name, those of this lab first, for their names get their places first.
 * @param {Lab} lab @param {Placement} p @param {number} px @param {Map<string, number>} sizes by lab @param {boolean} ghosts those, too
 * @param {Places} bodies gets those of its robots, named or not @param {Places} ghost_bodies
 * @returns {Named[]} */
function named_robots(lab, p, px, sizes, ghosts, bodies, ghost_bodies) {
  /** @type {Named[]} */
  const out = [];
  const add = (/** @type {{id: number, x: number, y: number, heading: number}} */ r, /** @type {string} */ words, /** @type {number} */ radius, /** @type {number} */ opacity, /** @type {boolean} */ ghost) => {
    const x = p.x(r.x, r.y), y = p.y(r.x, r.y), at = r.heading + p.turn_rad, places = ghost ? ghost_bodies : bodies;
    places.add_disc(x, y, radius);
    places.add_disc(x + Math.cos(at) * nose_at * radius, y - Math.sin(at) * nose_at * radius, nose_radius * radius);
    if (2 * radius >= labelled_px * px) out.push({ words, x, y, radius, opacity, ghost });
  };
  const own = radius_of(lab, p, px, lab.own, sizes);
  for (const r of lab.robots) add(r, r.confidence < 0.5 ? `${r.id}?` : `${r.id}`, own, 1, false);
  for (const fleet of ghosts ? lab.ghosts : []) {
    const radius = radius_of(lab, p, px, fleet.lab, sizes), opacity = opacity_of(lab, fleet);
    for (const ghost of fleet.robots) add(ghost, `${ghost.id}`, radius, opacity, true);
  }
  return out;
}

/** Ids of robots, each beside its robot, where they cover neither another word nor a robot; who has no such place has none. Only an own robot's id may lie on
 * a ghost, where there is no other room.
 * @param {{lab: Lab, placement: Placement}[]} labs of a pane @param {Sprites} sprites @param {number} px @param {Map<string, number>} sizes by lab
 * @param {boolean} ghosts those of other labs' robots, too @param {Places} places what is taken already, of words; gets these
 * @returns {Name[]} */
export function place_names(labs, sprites, px, sizes, ghosts, places) {
  const ghost_bodies = new Places();
  const all = labs.flatMap(({ lab, placement }) => named_robots(lab, placement, px, sizes, ghosts, places, ghost_bodies));
  return all.sort((a, b) => Number(a.ghost) - Number(b.ghost)).flatMap((named) => {
    const { image, size_px } = name_label(named, sprites, px);
    const place = (/** @type {Places | null} */ more) => place_beside(places, more, named.x, named.y, named.radius, image.width - beside_words * size_px, digit_height * size_px);
    const box = place(ghost_bodies) ?? (named.ghost ? null : place(null));
    return box ? [{ ...named, box }] : [];
  });
}

/** @param {Context} c @param {Name[]} names @param {Sprites} sprites @param {number} px */
export function draw_names(c, names, sprites, px) {
  for (const name of names) {
    const { image } = name_label(name, sprites, px);
    c.globalAlpha = Math.min(1, name.opacity / ghost_opacity); // of new ghosts they can be read
    c.drawImage(image.image, Math.round(name.box.x - image.width / 2), Math.round(name.box.y - image.height / 2));
  }
  c.globalAlpha = 1;
}

/** @param {Named} named @param {Sprites} sprites @param {number} px */
function name_label({ words, ghost }, sprites, px) {
  const { ink, trail, halo } = sprites.colours.inks, size_px = (ghost ? 9 : 10) * px;
  return { image: label(words, ghost ? trail : ink, halo, size_px), size_px };
}

/** @param {Context} c @param {{x: number, y: number, heading: number, led: number}} r @param {Placement} p @param {Sprites} sprites @param {number} radius @param {boolean} ghost @param {boolean} [ring] */
function robot(c, r, p, sprites, radius, ghost, ring = false) {
  const sprite = sprites.robot(r.led, r.heading + p.turn_rad, radius, ghost, ring);
  const half = sprite.width / 2;
  c.drawImage(sprite, Math.round(p.x(r.x, r.y) - half), Math.round(p.y(r.x, r.y) - half));
}

/** A ring around what was picked, and its path.
 * @param {Context} c @param {Lab} lab @param {Placement} p @param {string} ink @param {number} px @param {Pick} pick @param {{x: number, y: number}[]} path in this lab's arena */
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

/** The robot or ghost of that id as this lab sees it.
 * @param {Lab} lab @param {Pick} pick */
export function find(lab, pick) {
  if (pick.lab === lab.own) return lab.robots.find((r) => r.id === pick.id);
  return lab.ghosts.find((f) => f.lab === pick.lab)?.robots.find((r) => r.id === pick.id);
}
