// Draws what lies still in an arena: ground, grid, camera picture, walls, obstacles. A function of the lab's state and a placement only.

/** @typedef {import("../world/lab.js").Lab} Lab */
/** @typedef {import("../world/placement.js").Placement} Placement */
/** @typedef {import("./colours.js").Colours} Colours */
/** @typedef {CanvasRenderingContext2D} Context */

/** Lines of the grid are this far apart, metres. */
export const grid_m = 0.1;

/** The path of an arena's sides.
 * @param {Context} c @param {Lab} lab @param {Placement} p */
export function arena_path(c, lab, p) {
  const { width, height } = lab.size;
  path(c, p, [[-width / 2, -height / 2], [width / 2, -height / 2], [width / 2, height / 2], [-width / 2, height / 2]]);
}

/** @param {Context} c @param {Placement} p @param {number[][]} corners in metres */
export function path(c, p, corners) {
  c.beginPath();
  for (const [x, y] of corners) c.lineTo(p.x(x, y), p.y(x, y)); // the first goes there without a line
  c.closePath();
}

/** @param {Context} c @param {Lab} lab @param {Placement} p @param {Colours} colours
 * @param {number} px one CSS pixel @param {import("./camera_picture.js").CameraPicture[]} pictures of this lab */
export function draw_floor(c, lab, p, colours, px, pictures) {
  const { width, height } = lab.size;
  arena_path(c, lab, p);
  c.fillStyle = colours.inks.ground;
  c.fill();
  if (p.scale * grid_m > 12 * px) {
    c.beginPath();
    for (let x = -Math.floor(width / 2 / grid_m) * grid_m; x < width / 2; x += grid_m) line(c, p, x, -height / 2, x, height / 2);
    for (let y = -Math.floor(height / 2 / grid_m) * grid_m; y < height / 2; y += grid_m) line(c, p, -width / 2, y, width / 2, y);
    c.strokeStyle = colours.inks.grid;
    c.lineWidth = px;
    c.stroke();
  }
  for (const picture of pictures) picture.draw(c, p);
  arena_path(c, lab, p);
  c.strokeStyle = colours.inks.wall;
  c.lineWidth = 3 * px;
  c.stroke();
  const solids = lab.arena?.solids ?? [];
  const obstacles = solids.length - (lab.arena?.n_objects ?? 0);
  c.fillStyle = colours.inks.solid;
  for (let i = 0; i < obstacles; ++i) {
    solid_path(c, p, lab.arena, solids[i], { x: solids[i].x_m, y: solids[i].y_m, heading: solids[i].heading_rad });
    c.fill();
  }
}

/** @param {Context} c @param {Placement} p @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2 */
function line(c, p, x1, y1, x2, y2) {
  c.moveTo(p.x(x1, y1), p.y(x1, y1));
  c.lineTo(p.x(x2, y2), p.y(x2, y2));
}

/** The outline of an obstacle or object at a place.
 * @param {Context} c @param {Placement} p @param {any} arena arena_info_t @param {any} solid solid_t @param {{x: number, y: number, heading: number}} at */
export function solid_path(c, p, arena, solid, at) {
  if (solid.radius_m > 0) {
    c.beginPath();
    c.arc(p.x(at.x, at.y), p.y(at.x, at.y), solid.radius_m * p.scale, 0, 2 * Math.PI);
    return;
  }
  const cos = Math.cos(at.heading), sin = Math.sin(at.heading);
  const corners = arena.corners.slice(solid.first_corner, solid.first_corner + solid.n_corners);
  path(c, p, corners.map((/** @type {any} */ q) => [at.x + cos * q.x_m - sin * q.y_m, at.y + sin * q.x_m + cos * q.y_m]));
}

/** Fills and strokes the current path.
 * @param {Context} c @param {import("../wire/lcm.js").Message} of a circle, polygon or line @param {Colours} colours @param {number} px */
export function shape(c, of, colours, px) {
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
