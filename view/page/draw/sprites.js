// Pictures of robots from above: body, heading, LED. Each is drawn once for its size, colour and heading, then copied.
// The LED's mark has a shape of its own for each colour: nothing depends on colour alone.

/** Headings that are told apart. */
const headings = 64;
/** Sprites that are kept; then all go, and those in use come back. */
const sprites_most = 4000;

/** @type {Record<number, number[][]>} Corners of each LED's mark, in shares of its radius; a disc for those without. */
const marks = {
  0: [[-1, -0.25], [1, -0.25], [1, 0.25], [-1, 0.25]], // off: bar
  1: [[0, -1], [0.9, 0.7], [-0.9, 0.7]], // red: triangle up
  2: [[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]], // green: square
  3: [[0, -1.1], [1.1, 0], [0, 1.1], [-1.1, 0]], // yellow: rhombus
  5: [[-0.35, -1], [0.35, -1], [0.35, -0.35], [1, -0.35], [1, 0.35], [0.35, 0.35], [0.35, 1], [-0.35, 1], [-0.35, 0.35], [-1, 0.35], [-1, -0.35], [-0.35, -0.35]], // magenta: plus
  6: [[0, 1], [0.9, -0.7], [-0.9, -0.7]], // cyan: triangle down
  8: [[-0.5, -1], [0.5, -1], [0.5, 1], [-0.5, 1]], // unknown: upright bar
};

/** Around a white LED: it shows on light ground and on light bodies. */
const edge = "#1c1f22";

/** @typedef {import("./colours.js").Colours} Colours */

export class Sprites {
  /** @param {Colours} colours */
  constructor(colours) {
    this.colours = colours;
    /** @type {Map<number, ImageBitmap>} */
    this.made = new Map();
  }

  /** A robot's picture; its middle is the robot's.
   * @param {number} led @param {number} heading_rad on the screen, counter-clockwise
   * @param {number} radius_px of its body @param {boolean} ghost of another lab @param {boolean} [ring] see-through, in the colour of its LED */
  robot(led, heading_rad, radius_px, ghost, ring = false) {
    const turn = ((Math.round((heading_rad / (2 * Math.PI)) * headings) % headings) + headings) % headings;
    const size = Math.max(2, Math.round(radius_px * 2)); // half pixels
    const key = ((size * headings + turn) * 9 + Math.min(led, 8)) * 3 + (ring ? 2 : ghost ? 1 : 0);
    let sprite = this.made.get(key);
    if (!sprite) {
      if (this.made.size >= sprites_most) this.made.clear();
      sprite = this.draw(Math.min(led, 8), (turn / headings) * 2 * Math.PI, size / 2, ghost, ring);
      this.made.set(key, sprite);
    }
    return sprite;
  }

  /** @param {number} led @param {number} heading @param {number} radius @param {boolean} ghost @param {boolean} ring */
  draw(led, heading, radius, ghost, ring) {
    const side = 2 * Math.ceil(radius * 1.5 + 1);
    const canvas = new OffscreenCanvas(side, side);
    const c = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const { body } = this.colours.inks;
    c.translate(side / 2, side / 2);
    c.lineWidth = Math.max(1, radius / 8);
    // The nose: a wedge in the driving direction, out of the body.
    c.beginPath();
    for (const [share, angle] of [[1.45, 0], [1, 0.5], [1, -0.5]]) c.lineTo(Math.cos(heading + angle) * radius * share, -Math.sin(heading + angle) * radius * share);
    c.closePath();
    c.fillStyle = c.strokeStyle = ring ? this.colours.leds[led] : body;
    if (ghost || ring) c.stroke();
    else c.fill();
    c.beginPath();
    c.arc(0, 0, radius - c.lineWidth / 2, 0, 2 * Math.PI);
    if (ghost) {
      c.setLineDash([radius / 2.2, radius / 3.2]);
      c.stroke();
      c.setLineDash([]);
    } else if (ring) {
      c.stroke();
      return canvas.transferToImageBitmap();
    } else c.fill();
    // The LED: as large as the body where there is no room for a mark.
    const light = radius < 5 ? radius * 0.75 : radius * 0.55;
    const marked = Boolean(marks[led]) && radius >= 5;
    c.beginPath();
    if (marked) {
      for (const [x, y] of marks[led]) c.lineTo(x * light, y * light);
      c.closePath();
    } else c.arc(0, 0, light, 0, 2 * Math.PI);
    c.fillStyle = this.colours.leds[led];
    if (led || marked) c.fill();
    if (led === 7) {
      c.strokeStyle = edge;
      c.stroke();
    }
    return canvas.transferToImageBitmap();
  }
}
