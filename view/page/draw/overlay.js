// Draws what a scenario shows people: rasters, polygons, circles, lines and texts, in this order, in colours by meaning.
import { path, shape } from "./floor.js";
import { draw_label, label } from "./label.js";
import { Places, place_label, sites_of } from "./label_place.js";

/** @typedef {CanvasRenderingContext2D} Context */
/** @typedef {import("../world/placement.js").Placement} Placement */
/** @typedef {import("./colours.js").Colours} Colours */
/** @typedef {import("../wire/lcm.js").Message} Message */
/** @typedef {{words: string, colour: string, place: import("./label_place.js").Box}} PlacedWords */

/** Height of words, CSS pixels. */
const words_px = 11;

/** Cells along a side of a raster that browsers can draw. */
const side_most = 16_384;

/** @param {Context} c @param {Message} overlay overlay_t @param {Placement} p @param {Colours} colours @param {number} px one CSS pixel */
export function draw_overlay(c, overlay, p, colours, px) {
  c.save();
  for (const raster of overlay.rasters) draw_raster(c, raster, p, colours);
  for (const polygon of overlay.polygons) {
    path(c, p, polygon.corners.map((/** @type {Message} */ q) => [q.x_m, q.y_m]));
    shape(c, polygon, colours, px);
  }
  for (const circle of overlay.circles) {
    c.beginPath();
    c.arc(p.x(circle.x_m, circle.y_m), p.y(circle.x_m, circle.y_m), Math.max(0, circle.radius_m * p.scale), 0, 2 * Math.PI);
    shape(c, circle, colours, px);
  }
  for (const line of overlay.lines) {
    c.beginPath();
    for (const q of line.points) c.lineTo(p.x(q.x_m, q.y_m), p.y(q.x_m, q.y_m));
    shape(c, { ...line, filled: false }, colours, px);
  }
  for (const { words, colour, place } of overlay_words(overlay, p, colours, px)) draw_label(c, words, place.x, place.y, colours.of(colour), colours.inks.halo, words_px * px);
  c.restore();
}

/** The words of an overlay, and where they lie; what finds no room is left out until the view is closer.
 * @param {Message} overlay overlay_t @param {Placement} p @param {Colours} colours @param {number} px one CSS pixel
 * @returns {PlacedWords[]} */
export function overlay_words(overlay, p, colours, px) {
  const places = new Places(), sites = sites_of(overlay.circles, p), above_px = 9 * px, size_px = words_px * px;
  /** @type {PlacedWords[]} */
  const out = [];
  const say = (/** @type {string} */ words, /** @type {string} */ colour, /** @type {Message} */ at, /** @type {number} */ up_px, /** @type {import("./label_place.js").Discs | null} */ more = null) => {
    if (!words) return;
    const { width } = label(words, colours.of(colour), colours.inks.halo, size_px), x = p.x(at.x_m, at.y_m), y = p.y(at.x_m, at.y_m);
    const box = (/** @type {number} */ aside, /** @type {number} */ up) => ({ x: x + aside * width, y: y - up, width, height: 1.2 * size_px });
    const place = place_label(places, more, ...(more ? [0, 0.3, -0.3].flatMap((aside) => [box(aside, up_px), box(aside, -up_px)]) : [box(0, up_px)]));
    if (place) out.push({ words, colour, place });
  };
  for (const raster of overlay.rasters) if (can_draw(raster)) say(raster.label, raster.colour, top_of(raster), above_px);
  for (const polygon of overlay.polygons) if (polygon.n_corners > 0) say(polygon.label, polygon.colour, mean(polygon.corners), 0);
  for (const circle of overlay.circles) say(circle.label, circle.colour, circle, circle.radius_m * p.scale + above_px, sites);
  for (const line of overlay.lines) if (line.n_points > 0) say(line.label, line.colour, line.points[line.n_points >> 1], 0);
  for (const text of overlay.texts) say(text.text, text.colour, text, 0);
  return out;
}

/** @param {Message} raster */
function can_draw({ columns, rows, cells }) {
  return columns >= 1 && rows >= 1 && columns <= side_most && rows <= side_most && columns * rows === cells.length;
}

/** The middle of its upper side.
 * @param {Message} raster */
function top_of({ columns, rows, cell_m, heading_rad, x_m, y_m }) {
  const cos = Math.cos(heading_rad) * cell_m, sin = Math.sin(heading_rad) * cell_m;
  return { x_m: x_m + (cos * columns) / 2 - sin * rows, y_m: y_m + (sin * columns) / 2 + cos * rows };
}

/** @param {Context} c @param {Message} raster @param {Placement} p @param {Colours} colours */
function draw_raster(c, raster, p, colours) {
  if (!can_draw(raster)) return;
  const { columns, rows, cells } = raster;
  const tile = new OffscreenCanvas(columns, rows);
  const inside = /** @type {OffscreenCanvasRenderingContext2D} */ (tile.getContext("2d"));
  const image = inside.createImageData(columns, rows);
  const rgb = parseInt(colours.of(raster.colour).slice(1), 16);
  for (let i = 0; i < cells.length; ++i) {
    image.data[4 * i] = rgb >> 16;
    image.data[4 * i + 1] = (rgb >> 8) & 255;
    image.data[4 * i + 2] = rgb & 255;
    image.data[4 * i + 3] = cells[i] * colours.table.raster_opacity;
  }
  inside.putImageData(image, 0, 0);
  c.save();
  p.apply(c);
  c.translate(raster.x_m, raster.y_m);
  c.rotate(raster.heading_rad);
  c.imageSmoothingEnabled = false;
  c.drawImage(tile, 0, 0, columns * raster.cell_m, rows * raster.cell_m);
  c.restore();
}

/** @param {Message[]} points */
function mean(points) {
  const sum = (/** @type {string} */ key) => points.reduce((total, q) => total + q[key], 0) / points.length;
  return { x_m: sum("x_m"), y_m: sum("y_m") };
}
