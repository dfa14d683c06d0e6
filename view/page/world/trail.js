// Where a robot has been: the last points of its path, far enough from each other to be seen.

/** Points of all trails together that one lab keeps, so that a thousand robots cost no more than a hundred. */
const points_of_all = 12_000;

/** How many points each of `robots` trails may have.
 * @param {number} robots */
export function points_each(robots) {
  return Math.max(12, Math.min(240, Math.floor(points_of_all / Math.max(1, robots))));
}

/** Robots move at least this far between two points of a trail, metres. */
export const step_m = 0.004;

export class Trail {
  /** @param {number} points */
  constructor(points) {
    this.points = points;
    this.xs = new Float32Array(points);
    this.ys = new Float32Array(points);
    /** Lab time of each point, microseconds. */
    this.times = new Float64Array(points);
    /** Points that ever came; the newest is at (count - 1) % points. */
    this.count = 0;
  }

  /** True when the point was far enough from the last one to be kept.
   * @param {number} x @param {number} y @param {number} t_us */
  add(x, y, t_us) {
    if (this.count > 0) {
      const last = (this.count - 1) % this.points;
      if (Math.hypot(x - this.xs[last], y - this.ys[last]) < step_m) return false;
    }
    const at = this.count++ % this.points;
    this.xs[at] = x;
    this.ys[at] = y;
    this.times[at] = t_us;
    return true;
  }

  /** Serial number of the oldest kept point of that time or later; `count`: there is none.
   * @param {number} t_us */
  since(t_us) {
    let low = this.first, high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle % this.points] < t_us) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Serial number of the oldest point that is kept. */
  get first() {
    return Math.max(0, this.count - this.points);
  }
}
