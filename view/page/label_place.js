// Where labels go, so that none lies on another.

/** @typedef {{x: number, y: number, width: number, height: number}} Place of a label: its middle and its sides, pixels */

/** A label that would lie on others goes up by so many lines at most. */
const lines_most = 4;

/**
 * Where a label goes that should be at x, y: there, or so many lines higher that it lies on none of those placed; there, too, when it finds no room.
 * @param {Place[]} placed gets it, too @param {Place} wanted
 * @returns {Place}
 */
export function place_label(placed, wanted) {
  const is_free = (/** @type {Place} */ a) => placed.every((b) => Math.abs(a.x - b.x) >= (a.width + b.width) / 2 || Math.abs(a.y - b.y) >= (a.height + b.height) / 2 - 0.5);
  const lines = Array.from({ length: lines_most }, (_, line) => ({ ...wanted, y: wanted.y - line * wanted.height }));
  const place = lines.find(is_free) ?? wanted;
  placed.push(place);
  return place;
}
