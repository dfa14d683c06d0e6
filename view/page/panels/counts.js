// What the scenario counts, as curves over lab time: from the server's series, and live from `status` since then.
import { h, patch, section, table } from "../dom.js";
import { count_name, count_value } from "../words.js";

/** @typedef {{name: string, t_s: number[], y: number[]}} Series */

/** Points that one curve keeps; then every second one goes. */
const points_most = 4000;
/** Colours by Okabe and Ito, with dashes: told apart without colour too. */
const strokes = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const dashes = [[], [8, 4], [2, 3], [10, 3, 2, 3]];
const height_px = 170;
/** Between ticks of whole numbers. */
const whole_steps = Array.from({ length: 13 }, (_, i) => [1, 2, 5].map((n) => n * 10 ** i)).flat();
/** Curves that are drawn at once. */
const curves_most = 6;

export class CountsPanel {
  constructor() {
    const { element, body } = section("Counts", true);
    this.element = element;
    this.now = h("div", { class: "counts" });
    this.place = h("div", { class: "curves" });
    this.list = h("div", { class: "choices" });
    this.choices = h("details", {}, h("summary", {}, "choose curves"), h("p", { class: "about" }, `At most ${curves_most} are drawn at once.`), this.list);
    body.append(this.now, this.place, this.choices, h("button", { id: "curves-csv", title: "All curves as a table", onclick: () => this.save() }, "save as CSV"));
    /** @type {Set<string> | null} Names that are drawn, once somebody has chosen; null: those that the scenario names, else the first. */
    this.chosen = null;
    this.listed = "";
    /** @type {Map<string, Series>} */
    this.series = new Map();
    /** The run of each lab that is noted, by its random number. @type {Map<string, unknown>} */
    this.runs = new Map();
    /** True: the server has given all there is, of a recorded run. */
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

  /** Curves of the run up to now; of a recorded one that is all.
   * @param {Series[]} series @param {boolean} whole */
  set(series, whole) {
    this.whole = whole;
    this.series = new Map(series.map((s) => [s.name, s]));
    this.names = "";
  }

  /** Notes what labs count now.
   * @param {import("../world/world.js").World} world */
  note(world) {
    if (world.about.mode === "recorded") return;
    for (const lab of world.labs) {
      if (!lab.status) continue;
      const t_s = lab.status.stamp_us / 1e6, { nonce } = lab.status;
      if (this.runs.has(lab.name) && this.runs.get(lab.name) !== nonce) {
        // The lab began anew.
        for (const key of [...this.series.keys()]) if (key.startsWith(`${lab.name} `)) this.series.delete(key);
      }
      this.runs.set(lab.name, nonce);
      for (const [name, value] of lab.counts()) {
        const key = `${lab.name} ${name}`;
        let s = this.series.get(key);
        if (!s) this.series.set(key, (s = { name: key, t_s: [], y: [] }));
        if (t_s <= s.t_s[s.t_s.length - 1]) continue; // the server's curve may be newer than the status
        s.t_s.push(t_s);
        s.y.push(value);
        if (s.t_s.length > points_most) {
          s.t_s = s.t_s.filter((_, i) => i % 2 === 0);
          s.y = s.y.filter((_, i) => i % 2 === 0);
        }
      }
    }
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    this.note(world);
    const counts = world.about.mode === "recorded" ? values_at([...this.series.values()], world.t_us / 1e6, world.labs.map((lab) => lab.name))
      : world.labs.flatMap((lab) => lab.counts().map(([name, n]) => ({ lab: lab.name, name, n })));
    this.element.hidden = !counts.length && !this.series.size; // of robots' programs alone, and before a scenario has counted
    patch(this.now, counts_table(counts, (lab, name) => told(world.labs.find((l) => l.name === lab), name)));
    if (!(/** @type {HTMLDetailsElement} */ (this.element).open)) return;
    const all = [...this.series.values()].filter((s) => s.t_s.length > 0);
    const first = named_curves(all.map((s) => s.name), world.labs);
    const chosen = this.chosen ?? new Set(first);
    this.offer(all.map((s) => ({ name: s.name, words: words_of(s.name, world.labs).words })), chosen);
    const list = all.filter((s) => chosen.has(s.name)).sort((a, b) => (this.chosen ? 0 : first.indexOf(a.name) - first.indexOf(b.name))).map((s) => drawn(s, world.labs));
    const names = list.map((s) => s.name).join();
    const key = `${names} ${list.map((s) => `${s.t_s.length} ${s.t_s[s.t_s.length - 1]}`)} ${this.whole ? Math.round(world.t_us / 1e6) : ""}`;
    if (key === this.drawn) return;
    this.drawn = key;
    if (names !== this.names) this.rebuild(list, names, world);
    this.plot?.setData(/** @type {any} */ (align(list)));
  }

  /** Axes and words have the page's ink, which has changed. */
  recolour() {
    this.names = this.drawn = "";
  }

  /** What may be drawn, to be chosen where that is more than is drawn by itself.
   * @param {{name: string, words: string}[]} all @param {Set<string>} chosen */
  offer(all, chosen) {
    const key = JSON.stringify([all, [...chosen]]);
    if (key === this.listed) return;
    this.listed = key;
    this.choices.hidden = all.every(({ name }) => chosen.has(name)) && !this.chosen;
    patch(this.list, ...all.map(({ name, words }, i) => {
      const on = chosen.has(name);
      return h("p", {}, h("input", { type: "checkbox", id: `curve-${i}`, "data-name": name, checked: on, disabled: !on && chosen.size >= curves_most }), " ", h("label", { for: `curve-${i}` }, words));
    }));
    for (const box of this.list.querySelectorAll("input")) {
      box.checked = chosen.has(box.dataset["name"] ?? "");
      box.onchange = () => {
        const name = box.dataset["name"] ?? "", before = [...(this.chosen ?? chosen)]; // two may be clicked before this is written anew
        this.chosen = new Set(box.checked ? [...before, name] : before.filter((other) => other !== name));
        this.drawn = "";
      };
    }
  }

  /** Gives the browser a file with a column for each curve. */
  save() {
    const list = [...this.series.values()].filter((s) => s.t_s.length > 0);
    const columns = align(list), rows = columns[0].map((_, i) => columns.map((column) => column[i] ?? "").join(","));
    const link = h("a", { download: "curves.csv", href: URL.createObjectURL(new Blob([[["time_s", ...list.map((s) => s.name.replaceAll(",", " "))].join(","), ...rows, ""].join("\n")], { type: "text/csv" })) });
    link.click();
    URL.revokeObjectURL(link.href);
  }

  /** @param {Series[]} list @param {string} names @param {import("../world/world.js").World} world */
  rebuild(list, names, world) {
    this.names = names;
    this.plot?.destroy();
    this.plot = null;
    if (!list.length) return;
    const ink = getComputedStyle(this.element).color;
    const axis = { stroke: ink, grid: { stroke: "#8884", width: 1 }, ticks: { stroke: "#8884", width: 1 }, font: "11px system-ui" };
    this.plot = new uPlot({
      ...this.size(), cursor: { drag: { x: false, y: false } }, legend: { live: true },
      scales: { x: { time: false, ...(this.whole && { range: () => /** @type {[number, number]} */ ([0, (world.about.length_us ?? 0) / 1e6]) }) } },
      axes: [{ ...axis, label: "lab time, s", labelSize: 16, size: 28 }, { ...axis, size: 40, ...(list.every((s) => s.y.every(Number.isInteger)) && { incrs: whole_steps }) }],
      series: [{ label: "lab time, s" }, ...list.map((s, i) => ({
        label: s.name, stroke: strokes[i % strokes.length], dash: dashes[Math.floor(i / strokes.length + i) % dashes.length], width: 2, spanGaps: true, points: { show: s.t_s.length === 1, size: 8 }, // a fast run may be noted once
        paths: uPlot.paths.stepped?.({ align: 1 }),
      }))],
      hooks: { draw: [(u) => this.whole && mark(u, world.t_us / 1e6, ink)] },
    }, /** @type {any} */ (align(list)), this.place);
  }
}

/** @typedef {{lab: string, name: string, n: number}} Count */

/** @typedef {import("../world/lab.js").Lab} Lab */

/** A curve's lab and name: live ones are named "LAB COUNT", recorded ones "LAB.COUNT" or "LAB.TABLE.COLUMN".
 * @param {string} name @param {Lab[]} labs */
function parts_of(name, labs) {
  const lab = labs.find((l) => name.startsWith(`${l.name} `) || name.startsWith(`${l.name}.`));
  return { lab, of: lab ? name.slice(lab.name.length + 1) : name };
}

/** What the scenario tells of a count or column.
 * @param {Lab | undefined} lab @param {string} of */
function told(lab, of) {
  return lab?.shown.find((each) => each.of === `series.${of}`);
}

/** The curves that scenarios want to be drawn, in their order, of each lab; if they want none, the first.
 * @param {string[]} names @param {Lab[]} labs */
export function named_curves(names, labs) {
  const wanted = [...new Set(labs.flatMap((lab) => lab.shown).filter((each) => each["curve"]).map((each) => each.of))];
  const found = wanted.flatMap((of) => names.filter((name) => `series.${parts_of(name, labs).of}` === of));
  return (found.length ? found : names).slice(0, curves_most);
}

/** A curve's words for people, its unit, and how many of its numbers make one of that.
 * @param {string} name @param {Lab[]} labs */
function words_of(name, labs) {
  const { lab, of } = parts_of(name, labs), about = told(lab, of), own = count_name(of);
  const { unit, per } = about?.["unit"] ? { unit: about["unit"], per: 1 } : own;
  const words = (about?.["words"] || own.words) + (lab && labs.length > 1 ? `, ${lab.name}` : "");
  return { words: words + (unit && ` (${unit})`), per };
}

/** A row for each count, a column for each lab.
 * @param {Count[]} counts @param {(lab: string, name: string) => import("../wire/lcm.js").Message | undefined} about */
function counts_table(counts, about) {
  const labs = [...new Set(counts.map((c) => c.lab))], names = [...new Set(counts.map((c) => c.name))];
  const at = new Map(counts.map((c) => [`${c.lab} ${c.name}`, c.n]));
  return names.length ? table(["count", ...labs], names.map((name) => [labs.map((lab) => about(lab, name)?.["words"]).find(Boolean) ?? count_name(name).words, ...labs.map((lab) => {
    const n = at.get(`${lab} ${name}`);
    return n === undefined ? "–" : count_value(name, n);
  })])) : "";
}

/** What curves say of a moment: the newest value at or before it. Their names begin with a lab's.
 * @param {Series[]} list @param {number} t_s @param {string[]} labs
 * @returns {Count[]} */
export function values_at(list, t_s, labs) {
  return list.flatMap(({ name, t_s: times, y }) => {
    const i = times.filter((t) => t <= t_s).length - 1, lab = labs.find((l) => name.startsWith(`${l}.`)) ?? "";
    return i < 0 ? [] : [{ lab, name: lab ? name.slice(lab.length + 1) : name, n: y[i] }];
  });
}

/** A curve as it is drawn: in the unit that its name tells.
 * @param {Series} s @param {Lab[]} labs
 * @returns {Series} */
function drawn(s, labs) {
  const { words, per } = words_of(s.name, labs);
  return { name: words, t_s: s.t_s, y: per === 1 ? s.y : s.y.map((y) => y / per) };
}

/** A line where a recorded run stands.
 * @param {uPlot} u @param {number} t_s @param {string} ink */
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

/** Curves on one axis of times, as uPlot wants them.
 * @param {Series[]} list @returns {(number | null)[][]} */
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
