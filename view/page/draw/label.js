// Short texts with a halo, drawn once and then copied: drawing text anew costs ten times more.

/** @typedef {{image: ImageBitmap, width: number, height: number}} Label */

/** @type {Map<string, Label>} */
const labels = new Map();
/** Labels that are kept; then all go, and those in use come back. */
const labels_most = 6000;
const measure = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(1, 1).getContext("2d"));

/** @param {string} words @param {string} ink @param {string} halo @param {number} size_px @returns {Label} */
export function label(words, ink, halo, size_px) {
  const key = `${words}|${ink}|${halo}|${size_px}`;
  let made = labels.get(key);
  if (!made) {
    if (labels.size >= labels_most) labels.clear();
    const font = `${size_px}px system-ui, "DejaVu Sans", sans-serif`;
    measure.font = font;
    const width = Math.ceil(measure.measureText(words).width + size_px / 2);
    const height = Math.ceil(size_px * 1.5);
    const canvas = new OffscreenCanvas(Math.max(1, width), Math.max(1, height));
    const c = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d"));
    c.font = font;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.lineJoin = "round";
    c.lineWidth = size_px / 4;
    c.strokeStyle = halo;
    c.strokeText(words, width / 2, height / 2);
    c.fillStyle = ink;
    c.fillText(words, width / 2, height / 2);
    made = { image: canvas.transferToImageBitmap(), width, height };
    labels.set(key, made);
  }
  return made;
}

/** Centred at x, y (pixels).
 * @param {CanvasRenderingContext2D} c @param {string} words @param {number} x @param {number} y @param {string} ink @param {string} halo @param {number} size_px */
export function draw_label(c, words, x, y, ink, halo, size_px) {
  const made = label(words, ink, halo, size_px);
  c.drawImage(made.image, Math.round(x - made.width / 2), Math.round(y - made.height / 2));
}
