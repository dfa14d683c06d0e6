// What part of a frame a pane shows: its middle, in metres, and pixels per metre. Zooming keeps the point under the pointer in place.
import { Placement } from "../world/placement.js";

/** @typedef {{x: number, y: number, width: number, height: number}} Rectangle in CSS pixels, or in metres */

export class View {
  constructor() {
    this.x_m = 0;
    this.y_m = 0;
    this.px_per_m = 400;
  }

  /** Shows the whole rectangle (metres, x and y its lower left corner), with a margin.
   * @param {Rectangle} world @param {Rectangle} pane */
  fit(world, pane) {
    const margin = 1.08;
    this.x_m = world.x + world.width / 2;
    this.y_m = world.y + world.height / 2;
    this.px_per_m = Math.max(1, Math.min(pane.width / (world.width * margin), pane.height / (world.height * margin)));
  }

  /** @param {Rectangle} pane @returns {Placement} from the frame's metres to pixels */
  placement(pane) {
    const middle_x = pane.x + pane.width / 2, middle_y = pane.y + pane.height / 2;
    return new Placement(middle_x - this.x_m * this.px_per_m, middle_y + this.y_m * this.px_per_m, this.px_per_m, 0, true);
  }

  /** @param {number} factor @param {number} x_px @param {number} y_px @param {Rectangle} pane */
  zoom(factor, x_px, y_px, pane) {
    const fixed = this.placement(pane).inverse(x_px, y_px);
    this.px_per_m = Math.min(200_000, Math.max(5, this.px_per_m * factor));
    const moved = this.placement(pane).inverse(x_px, y_px);
    this.x_m += fixed.x - moved.x;
    this.y_m += fixed.y - moved.y;
  }

  /** @param {number} dx_px @param {number} dy_px */
  pan(dx_px, dy_px) {
    this.x_m -= dx_px / this.px_per_m;
    this.y_m += dy_px / this.px_per_m;
  }
}
