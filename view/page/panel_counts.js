// What the scenario counts, as curves over lab time. Live from `status`; of a recorded run from the server's series.
import uPlot from "./vendor/uplot/uPlot.esm.js";
import { h, section } from "./dom.js";

/** @typedef {{name: string, t_s: number[], y: number[]}} Series */

/** Points that one curve keeps; then every second one goes. */
const points_most = 4000;
/** Colours by Okabe and Ito, with dashes: told apart without colour too. */
const strokes = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const dashes = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
const height_px = 170;

export class CountsPanel {
  constructor() {
    const { element, body } = section("Counts", true);
    this.element = element;
    this.now = h("p", { class: "counts" });
    this.place = h("div", { class: "curves" });
    body.append(this.now, this.place);
    /** @type {Map<string, Series>} */
    this.series = new Map();
    /** True: the server has given all there is. */
    this.whole = false;
    /** @type {uPlot | null} */
    this.plot = null;
    this.names = "";
    this.drawn = "";
    new ResizeObserver(() => this.plot?.setSize(this.size())).observe(this.place);
  }

  size() {
    return { width: Math.max(120, this.place.clientWidth), height: height_px };
  }

  /**
   * All curves of a recorded run.
   * @param {Series[]} series
   */
  set(series) {
    this.whole = series.length > 0;
    this.series = new Map(series.map((s) => [s.name, s]));
    this.names = "";
  }

  /**
   * Notes what labs count now.
   * @param {import("./world.js").World} world
   */
  note(world) {
    if (this.whole) return;
    for (const lab of world.labs) {
      if (!lab.status) continue;
      const t_s = lab.status.stamp_us / 1e6;
      for (const [name, value] of lab.counts()) {
        const key = `${lab.name} ${name}`;
        let s = this.series.get(key);
        if (!s) this.series.set(key, (s = { name: key, t_s: [], y: [] }));
        const last = s.t_s.length - 1;
        if (t_s < s.t_s[last]) s.t_s.length = s.y.length = 0; // the lab began anew
        if (t_s === s.t_s[last]) continue;
        s.t_s.push(t_s);
        s.y.push(value);
        if (s.t_s.length > points_most) {
          s.t_s = s.t_s.filter((_, i) => i % 2 === 0);
          s.y = s.y.filter((_, i) => i % 2 === 0);
        }
      }
    }
  }

  /** @param {import("./world.js").World} world */
  update(world) {
    this.note(world);
    const now = world.labs.flatMap((lab) => lab.counts().map(([name, n]) => `${lab.name} ${name}: ${n}`));
    this.now.textContent = now.join(", ") || "The scenario has counted nothing yet.";
    if (!(/** @type {HTMLDetailsElement} */ (this.element).open)) return;
    const list = [...this.series.values()].filter((s) => s.t_s.length > 0).slice(0, 12);
    const names = list.map((s) => s.name).join();
    const key = `${names} ${list.map((s) => `${s.t_s.length} ${s.t_s[s.t_s.length - 1]}`)} ${this.whole ? Math.round(world.t_us / 1e6) : ""}`;
    if (key === this.drawn) return;
    this.drawn = key;
    if (names !== this.names) this.rebuild(list, names, world);
    this.plot?.setData(/** @type {any} */ (align(list)));
  }

  /** @param {Series[]} list @param {string} names @param {import("./world.js").World} world */
  rebuild(list, names, world) {
    this.names = names;
    this.plot?.destroy();
    this.plot = null;
    if (!list.length) return;
    const ink = getComputedStyle(this.element).color;
    const axis = { stroke: ink, grid: { stroke: "#8884", width: 1 }, ticks: { stroke: "#8884", width: 1 }, font: "11px system-ui" };
    this.plot = new uPlot({
      ...this.size(), cursor: { drag: { x: false, y: false } }, legend: { live: true },
      scales: { x: { time: false } },
      axes: [{ ...axis, label: "lab time, s", labelSize: 16, size: 28 }, { ...axis, size: 40 }],
      series: [{ label: "s" }, ...list.map((s, i) => ({
        label: s.name, stroke: strokes[i % strokes.length], dash: dashes[Math.floor(i / strokes.length + i) % dashes.length], width: 2, spanGaps: true, points: { show: false },
        paths: uPlot.paths.stepped?.({ align: 1 }),
      }))],
      hooks: { draw: [(u) => this.whole && mark(u, world.t_us / 1e6, ink)] },
    }, /** @type {any} */ (align(list)), this.place);
  }
}

/**
 * A line where a recorded run stands.
 * @param {uPlot} u @param {number} t_s @param {string} ink
 */
function mark(u, t_s, ink) {
  const x = u.valToPos(t_s, "x", true);
  u.ctx.save();
  u.ctx.strokeStyle = ink;
  u.ctx.beginPath();
  u.ctx.moveTo(x, u.bbox.top);
  u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
  u.ctx.stroke();
  u.ctx.restore();
}

/**
 * Curves on one axis of times, as uPlot wants them.
 * @param {Series[]} list @returns {(number | null)[][]}
 */
export function align(list) {
  const times = [...new Set(list.flatMap((s) => s.t_s))].sort((a, b) => a - b);
  const at = new Map(times.map((t, i) => [t, i]));
  return [times, ...list.map((s) => {
    /** @type {(number | null)[]} */
    const column = new Array(times.length).fill(null);
    s.t_s.forEach((t, i) => (column[/** @type {number} */ (at.get(t))] = s.y[i]));
    return column;
  })];
}
