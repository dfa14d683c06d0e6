// Draws trails: all of them, older parts fainter, or only what came since the last time.

/** @typedef {import("../world/trail.js").Trail} Trail */
/** @typedef {import("../world/placement.js").Placement} Placement */
/** @typedef {CanvasRenderingContext2D} Context */

/** Opacities, of the oldest part first. */
const shades = [0.08, 0.16, 0.28, 0.45];

/** What came in the last `length_us` of lab time before `now_us`.
 * @param {Context} c @param {Iterable<Trail>} trails @param {Placement} p @param {string} ink @param {number} px one CSS pixel @param {number} now_us @param {number} length_us */
export function draw_trails(c, trails, p, ink, px, now_us, length_us) {
  const all = [...trails].map((trail) => ({ trail, from: trail.since(now_us - length_us) }));
  c.strokeStyle = ink;
  c.lineWidth = 1.5 * px;
  shades.forEach((shade, i) => {
    c.globalAlpha = shade;
    c.beginPath();
    for (const each of all) {
      const to = i + 1 < shades.length ? each.trail.since(now_us - length_us * (1 - (i + 1) / shades.length)) : each.trail.count;
      stretch(c, each.trail, each.from, to, p);
      each.from = to;
    }
    c.stroke();
  });
  c.globalAlpha = 1;
}

/** Adds to each trail what came since `drawn`, and notes there how far it is.
 * @param {Context} c @param {Iterable<[number, Trail]>} trails @param {Map<number, number>} drawn serial numbers by robot @param {Placement} p @param {string} ink @param {number} px */
export function add_to_trails(c, trails, drawn, p, ink, px) {
  c.beginPath();
  for (const [robot, trail] of trails) {
    const from = drawn.get(robot) ?? trail.first;
    if (trail.count === from) continue;
    stretch(c, trail, Math.max(trail.first, from - 1), trail.count - 1, p);
    drawn.set(robot, trail.count);
  }
  c.globalAlpha = shades[shades.length - 1];
  c.strokeStyle = ink;
  c.lineWidth = 1.5 * px;
  c.stroke();
  c.globalAlpha = 1;
}

/** The line from one point of a trail to another, both included.
 * @param {Context} c @param {Trail} trail @param {number} from @param {number} to @param {Placement} p */
function stretch(c, trail, from, to, p) {
  for (let serial = from; serial <= to && serial < trail.count; ++serial) {
    const at = serial % trail.points;
    const x = p.x(trail.xs[at], trail.ys[at]), y = p.y(trail.xs[at], trail.ys[at]);
    if (serial === from) c.moveTo(x, y);
    else c.lineTo(x, y);
  }
}
