// Draws what a scenario shows people: rasters, polygons, circles, lines and texts, in this order, in colours by meaning.
import { path } from "./draw_floor.js";
import { draw_label, label } from "./label.js";
import { place_label } from "./label_place.js";

/**
 * @typedef {CanvasRenderingContext2D} Context
 * @typedef {import("./placement.js").Placement} Placement
 * @typedef {import("./colours.js").Colours} Colours
 * @typedef {import("./lcm.js").Message} Message
 * @typedef {import("./label_place.js").Place} Place
 */

/** Cells along a side of a raster that browsers can draw. */
const side_most = 16_384;

/** @param {Context} c @param {Message} overlay overlay_t @param {Placement} p @param {Colours} colours @param {number} px one CSS pixel */
export function draw_overlay(c, overlay, p, colours, px) {
  /** @type {Place[]} */
  const placed = [];
  c.save();
  for (const raster of overlay.rasters) draw_raster(c, raster, p, colours, px, placed);
  for (const polygon of overlay.polygons) {
    path(c, p, polygon.corners.map((/** @type {Message} */ q) => [q.x_m, q.y_m]));
    shape(c, polygon, colours, px);
    if (polygon.n_corners > 0) say(c, polygon.label, polygon.colour, mean(polygon.corners), 0, p, colours, px, placed);
  }
  for (const circle of overlay.circles) {
    c.beginPath();
    c.arc(p.x(circle.x_m, circle.y_m), p.y(circle.x_m, circle.y_m), Math.max(0, circle.radius_m * p.scale), 0, 2 * Math.PI);
    shape(c, circle, colours, px);
    say(c, circle.label, circle.colour, circle, circle.radius_m * p.scale + 9 * px, p, colours, px, placed);
  }
  for (const line of overlay.lines) {
    c.beginPath();
    line.points.forEach((/** @type {Message} */ q, /** @type {number} */ i) => {
      if (i) c.lineTo(p.x(q.x_m, q.y_m), p.y(q.x_m, q.y_m));
      else c.moveTo(p.x(q.x_m, q.y_m), p.y(q.x_m, q.y_m));
    });
    shape(c, { ...line, filled: false }, colours, px);
    if (line.n_points > 0) say(c, line.label, line.colour, line.points[line.n_points >> 1], 0, p, colours, px, placed);
  }
  for (const text of overlay.texts) say(c, text.text, text.colour, text, 0, p, colours, px, placed);
  c.restore();
}

/**
 * Fills and strokes the current path.
 * @param {Context} c @param {Message} of @param {Colours} colours @param {number} px
 */
function shape(c, of, colours, px) {
  const colour = colours.of(of.colour);
  if (of.filled) {
    c.globalAlpha = colours.table.fill_opacity;
    c.fillStyle = colour;
    c.fill();
    const pattern = colours.pattern(c, of.colour);
    if (pattern) {
      c.globalAlpha = 0.6;
      c.fillStyle = pattern;
      c.fill();
    }
    c.globalAlpha = 1;
  }
  c.strokeStyle = colour;
  c.lineWidth = 1.8 * px;
  c.setLineDash(of.dashed ? [6 * px, 5 * px] : []);
  c.stroke();
}

/** @param {Context} c @param {Message} raster @param {Placement} p @param {Colours} colours @param {number} px @param {Place[]} placed */
function draw_raster(c, raster, p, colours, px, placed) {
  const { columns, rows, cells } = raster;
  if (columns < 1 || rows < 1 || columns > side_most || rows > side_most || columns * rows !== cells.length) return;
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
  const cos = Math.cos(raster.heading_rad) * raster.cell_m, sin = Math.sin(raster.heading_rad) * raster.cell_m;
  const top = { x_m: raster.x_m + cos * columns / 2 - sin * rows, y_m: raster.y_m + sin * columns / 2 + cos * rows };
  say(c, raster.label, raster.colour, top, 9 * px, p, colours, px, placed);
}

/** @param {Message[]} points */
function mean(points) {
  const sum = (/** @type {string} */ key) => points.reduce((total, q) => total + q[key], 0) / points.length;
  return { x_m: sum("x_m"), y_m: sum("y_m") };
}

/** @param {Context} c @param {string} words @param {string} colour @param {Message} at @param {number} above_px @param {Placement} p @param {Colours} colours @param {number} px @param {Place[]} placed */
function say(c, words, colour, at, above_px, p, colours, px, placed) {
  if (!words) return;
  const ink = colours.of(colour), { halo } = colours.inks, size_px = 11 * px;
  const { width } = label(words, ink, halo, size_px);
  const place = place_label(placed, { x: p.x(at.x_m, at.y_m), y: p.y(at.x_m, at.y_m) - above_px, width, height: 1.2 * size_px });
  draw_label(c, words, place.x, place.y, ink, halo, size_px);
}
