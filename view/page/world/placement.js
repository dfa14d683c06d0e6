// Where a flat frame lies in another: turn, scale, shift. All drawing goes through one that leads from an arena's metres to pixels.

/** @typedef {{x: number, y: number}} Point */

/** out = shift + scale * turn(in); with `flip` the second axis then points down, as on screens. */
export class Placement {
  /** @param {number} shift_x @param {number} shift_y @param {number} scale @param {number} turn_rad @param {boolean} flip */
  constructor(shift_x, shift_y, scale, turn_rad, flip = false) {
    this.shift_x = shift_x;
    this.shift_y = shift_y;
    this.scale = scale;
    this.turn_rad = turn_rad;
    this.flip = flip;
    this.cos = Math.cos(turn_rad) * scale;
    this.sin = Math.sin(turn_rad) * scale;
    this.down = flip ? -1 : 1;
  }

  /** @param {number} x @param {number} y */
  x(x, y) {
    return this.shift_x + this.cos * x - this.sin * y;
  }

  /** @param {number} x @param {number} y */
  y(x, y) {
    return this.shift_y + this.down * (this.sin * x + this.cos * y);
  }

  /** @param {number} out_x @param {number} out_y @returns {Point} */
  inverse(out_x, out_y) {
    const dx = (out_x - this.shift_x) / (this.scale * this.scale);
    const dy = (this.down * (out_y - this.shift_y)) / (this.scale * this.scale);
    return { x: this.cos * dx + this.sin * dy, y: -this.sin * dx + this.cos * dy };
  }

  /** First `this`, then `outer`.
   * @param {Placement} outer */
  then(outer) {
    if (this.flip) throw new Error("only the last placement may flip");
    return new Placement(outer.x(this.shift_x, this.shift_y), outer.y(this.shift_x, this.shift_y), this.scale * outer.scale, this.turn_rad + outer.turn_rad, outer.flip);
  }

  /** Makes `context` draw in the inner frame's units.
   * @param {CanvasRenderingContext2D} context */
  apply(context) {
    context.transform(this.cos, this.down * this.sin, -this.sin, this.down * this.cos, this.shift_x, this.shift_y);
  }
}

/** The frame itself. */
export const identity = new Placement(0, 0, 1, 0);

/** A lab's projection, as `shared` tells it: arena to shared frame.
 * @param {{shift_x_m: number, shift_y_m: number, turn_rad: number, scale: number}} p */
export function projection(p) {
  return new Placement(p.shift_x_m, p.shift_y_m, p.scale > 0 ? p.scale : 1, p.turn_rad);
}
