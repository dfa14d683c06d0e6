// What is drawn in a pane, in three layers from below: what lies still, trails, what moves. Every function depends on its arguments only, so that
// page, pictures and films are drawn by the same ones.
import { draw_floor } from "./floor.js";
import { draw_overlay, overlay_words } from "./overlay.js";
import { draw_trails } from "./trails.js";
import { draw_ghosts, draw_names, draw_objects, draw_pick, draw_robots, place_names } from "./robots.js";
import { draw_label, label } from "./label.js";
import { Places } from "./label_place.js";

/** @typedef {import("../world/lab.js").Lab} Lab */
/** @typedef {import("../stage/view.js").Rectangle} Rectangle */
/** @typedef {import("../world/placement.js").Placement} Placement */
/** @typedef {{labels: boolean, trails: boolean, ghosts: boolean, overlay: boolean, pictures: boolean}} Shown */
/** @typedef {{labs: {lab: Lab, placement: Placement}[], rectangle: Rectangle, title: string}} Pane labs: one, or all of a shared frame */
/** @typedef {{pane: Pane, sprites: import("./sprites.js").Sprites, px: number, shown: Shown, pictures: Map<Lab, import("./camera_picture.js").CameraPicture[]>,
 *   trail_us: number, sizes: Map<string, number>, pick: import("./robots.js").Pick | null, path: {x: number, y: number}[], ruler: {a: {x: number, y: number}, b: {x: number, y: number}, words: string} | null}} Scene ruler in pixels */
/** @typedef {CanvasRenderingContext2D} Context */

/** Keeps a pane's drawing inside it.
 * @param {Context} c @param {Rectangle} r @param {() => void} draw */
export function within(c, r, draw) {
  c.save();
  c.beginPath();
  c.rect(r.x, r.y, r.width, r.height);
  c.clip();
  try {
    draw();
  } finally {
    c.restore();
  }
}

/** @param {Context} c @param {Scene} scene */
export function floor_layer(c, { pane, sprites, px, shown, pictures }) {
  const { colours } = sprites;
  for (const { lab, placement } of pane.labs) {
    const own = shown.pictures ? (pictures.get(lab) ?? []) : [];
    draw_floor(c, lab, placement, colours, px, own);
    if (shown.overlay && lab.overlay) draw_overlay(c, lab.overlay, placement, own.some((x) => x.newest) ? colours.over_picture() : colours, px);
  }
}

/** @param {Context} c @param {Scene} scene */
export function trail_layer(c, { pane, sprites, px, shown, trail_us }) {
  if (!shown.trails) return;
  for (const { lab, placement } of pane.labs) draw_trails(c, lab.trails.values(), placement, sprites.colours.inks.trail, px, lab.t_us, trail_us);
}

/** The ids that are written, and where.
 * @param {Scene} scene */
export function names_of({ pane, sprites, px, shown, sizes }) {
  const places = new Places(), title = title_place(pane, px), { width, height } = label(pane.title, sprites.colours.inks.ink, sprites.colours.inks.page, title_px * px);
  places.add({ ...title, width, height });
  if (shown.overlay) {
    for (const { lab, placement } of pane.labs) {
      for (const { place } of lab.overlay ? overlay_words(lab.overlay, placement, sprites.colours, px) : []) places.add(place);
    }
  }
  return place_names(pane.labs, sprites, px, sizes, shown.ghosts && pane.labs.length === 1, places);
}

/** A camera picture that is older is labelled with its age, microseconds. */
const picture_old_us = 500_000;

/** Whether robots lie over a camera picture: then they are rings, so that the eye can judge the tracker.
 * @param {Scene} scene @param {Lab} lab */
function camera_over({ shown, pictures }, lab) {
  return shown.pictures && (pictures.get(lab) ?? []).some((picture) => picture.newest);
}

/** The upper edge of what a pane shows, pixels.
 * @param {Pane} pane */
function top_of(pane) {
  return Math.min(...pane.labs.flatMap(({ lab: { size }, placement }) => [-1, 1].flatMap((x) => [-1, 1].map((y) => placement.y((x * size.width) / 2, (y * size.height) / 2)))));
}

/** The size of a pane's title. */
const title_px = 13;

/** The middle of a pane's title, pixels.
 * @param {Pane} pane @param {number} px */
function title_place(pane, px) {
  const r = pane.rectangle;
  return { x: r.x + r.width / 2, y: Math.max(r.y + 12 * px, top_of(pane) - 12 * px) };
}

/** @param {Context} c @param {Scene} scene */
export function robot_layer(c, scene) {
  const { pane, sprites, px, shown, sizes, pick, path, ruler } = scene;
  const { inks } = sprites.colours;
  for (const { lab, placement } of pane.labs) {
    draw_objects(c, lab, placement, sprites, px);
    // In a shared frame the robots themselves are there.
    if (shown.ghosts && pane.labs.length === 1) draw_ghosts(c, lab, placement, sprites, px, sizes);
    draw_robots(c, lab, placement, sprites, px, camera_over(scene, lab));
    if (pick && (pane.labs.length === 1 || pick.lab === lab.own)) draw_pick(c, lab, placement, inks.pick, px, pick, path);
  }
  if (shown.labels) draw_names(c, names_of(scene), sprites, px);
  const title = title_place(pane, px);
  draw_label(c, pane.title, title.x, title.y, inks.ink, inks.page, title_px * px);
  for (const { lab, placement } of pane.labs) {
    const old_us = Math.max(0, ...(shown.pictures ? (scene.pictures.get(lab) ?? []) : []).filter((x) => x.newest).map((x) => lab.t_us - x.t_us));
    if (old_us <= picture_old_us) continue;
    const { width, height } = lab.size;
    draw_label(c, `picture ${(old_us / 1e6).toFixed(1)} s old`, placement.x(width / 2, -height / 2) - 60 * px, placement.y(width / 2, -height / 2) - 12 * px, inks.ink, inks.halo, 12 * px);
  }
  if (ruler) {
    c.beginPath();
    c.moveTo(ruler.a.x, ruler.a.y);
    c.lineTo(ruler.b.x, ruler.b.y);
    c.strokeStyle = inks.pick;
    c.lineWidth = 2 * px;
    c.stroke();
    draw_label(c, ruler.words, (ruler.a.x + ruler.b.x) / 2, (ruler.a.y + ruler.b.y) / 2 - 10 * px, inks.ink, inks.halo, 12 * px);
  }
}

/** A line at the bottom of the canvas, drawn anew each time: a clock never says the same twice.
 * @param {Context} c @param {string} words @param {import("./colours.js").Colours} colours @param {number} height_px */
export function draw_caption(c, words, colours, height_px) {
  c.font = `${0.6 * height_px}px system-ui, "DejaVu Sans", sans-serif`;
  c.textAlign = "center";
  c.textBaseline = "middle";
  c.fillStyle = colours.inks.ink;
  c.fillText(words, c.canvas.width / 2, c.canvas.height - height_px / 2);
}

/** All of it on one canvas: pictures and films.
 * @param {Context} c @param {Scene} scene */
export function whole(c, scene) {
  within(c, scene.pane.rectangle, () => {
    floor_layer(c, scene);
    trail_layer(c, scene);
    robot_layer(c, scene);
  });
}
