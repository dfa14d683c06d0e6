// One camera's newest picture, drawn under the arena. The server sends it as seen straight from above, so turning and scaling it is enough.

/** @typedef {import("../world/lab.js").Camera} Camera */

export class CameraPicture {
  /** @param {Camera} camera */
  constructor(camera) {
    this.camera = camera;
    this.busy = false;
    /** @type {ImageBitmap | null} */
    this.newest = null;
    /** Lab time of the newest, microseconds. */
    this.t_us = 0;
  }

  /** Takes a JPEG; one that comes while another is being read is left out. False: it was not used.
   * @param {Uint8Array} jpeg @param {number} t_us its lab time */
  async take(jpeg, t_us) {
    if (this.busy) return false;
    this.busy = true;
    try {
      const before = this.newest;
      this.newest = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
      before?.close();
      this.t_us = t_us;
      return true;
    } catch (error) {
      if (error instanceof DOMException) return false; // no JPEG
      throw error;
    } finally {
      this.busy = false;
    }
  }

  /** @param {CanvasRenderingContext2D} c @param {import("../world/placement.js").Placement} p */
  draw(c, p) {
    if (!this.newest) return;
    c.save();
    p.apply(c);
    const [a, b, e, d, f, g] = this.camera.arena_to_px;
    const area = a * f - b * d;
    if (area !== 0) {
      // The inverse of arena_to_px: from the picture's pixels to the arena's metres.
      c.transform(f / area, -d / area, -b / area, a / area, (b * g - f * e) / area, (d * e - a * g) / area);
      c.drawImage(this.newest, 0, 0, this.camera.width_px, this.camera.height_px);
    }
    c.restore();
  }
}
