// All runs of a batch at a glance: a row for each combination of settings, a column for each seed; in each cell the run's result and its last moment.
import { h } from "../dom.js";
import { Panes } from "../stage/panes.js";
import { whole } from "../draw/scene.js";
import { grid_of } from "./batch_table.js";
import { World } from "../world/world.js";
import { count_name, number_words } from "../words.js";

/** A thumbnail, CSS pixels. */
const thumbnail_px = { width: 132, height: 92 };
/** What of a moment it shows. */
const channels = ["arena", "overlay", "poses", "shared"];
const shown = { labels: false, trails: false, ghosts: false, overlay: true, pictures: false };
export class BatchGrid {
  /** @param {import("../world/world.js").World} world @param {import("../stage/stage.js").Stage} stage @param {import("../play/player.js").Player} player
   * @param {(run: number) => void} open shows a run */
  constructor(world, stage, player, open) {
    this.world = world;
    this.stage = stage;
    this.player = player;
    this.open = open;
    this.result = h("select", { "aria-label": "result that is shown", onchange: () => this.fill() });
    this.body = h("div");
    this.title = h("h2");
    this.element = h("dialog", { class: "batch", "aria-label": "runs of the batch" },
      h("div", { class: "buttons" }, this.title, this.result, h("button", { onclick: () => this.element.close() }, "close")), this.body);
    document.body.append(this.element);
    /** @type {import("./batch_table.js").Table | null} */
    this.table = null;
    /** @type {{run: number, canvas: HTMLCanvasElement}[]} Runs whose last moment is still to be drawn. */
    this.waiting = [];
    this.drawing = false;
    this.seen = new IntersectionObserver((entries) => entries.forEach(({ isIntersecting, target }) => isIntersecting && this.want(/** @type {HTMLCanvasElement} */ (target))), { root: this.element, rootMargin: "200px" });
  }

  async show() {
    const { answer } = await this.player.ask({ batch: {} });
    this.title.textContent = answer.batch?.name ?? "";
    this.table = answer.batch ?? null;
    const told = this.world.labs.flatMap((lab) => lab.shown), results = this.table ? grid_of(this.table).results : [];
    this.result.hidden = !results.length;
    this.result.replaceChildren(...results.map((name) => h("option", { value: name }, words_of(name, told))));
    const wanted = told.find((each) => each["curve"] && results.includes(each.of.slice("series.".length)));
    if (wanted) this.result.value = wanted.of.slice("series.".length);
    if (answer.batch) this.fill();
    else this.body.replaceChildren(h("p", {}, `not shown: ${answer.refused}`));
    if (!this.element.open) this.element.showModal();
  }

  fill() {
    if (!this.table) return;
    const { columns } = this.table, { names, seeds, rows } = grid_of(this.table), told = this.world.labs.flatMap((lab) => lab.shown);
    const state = columns.indexOf("state"), why = columns.indexOf("why"), value = columns.indexOf(this.result.value);
    this.waiting = [];
    this.seen.disconnect();
    this.body.replaceChildren(h("table", {},
      h("thead", {}, h("tr", {}, ...names.map((name) => h("th", { scope: "col" }, words_of(name, told))), ...seeds.map((seed) => h("th", { scope: "col" }, `seed ${seed}`)))),
      h("tbody", {}, ...rows.map(({ settings, runs }) => h("tr", {}, ...settings.map((setting) => h("th", { scope: "row" }, setting)), ...seeds.map((seed) => {
        const row = runs.get(seed);
        if (!row) return h("td", {}, "–");
        const words = row.cells[state] === "finished" ? number_of(row.cells[value]) : `${row.cells[state]}: ${row.cells[why]}`, { run } = row;
        if (run === null) return h("td", {}, h("span", { title: "it has no recording" }, words));
        const canvas = h("canvas", { "data-run": run, "aria-hidden": "true" });
        this.seen.observe(canvas);
        return h("td", {}, h("button", { class: "run", title: `replay run ${row.cells[0]}`, onclick: () => (this.element.close(), this.open(run)) }, canvas, h("span", {}, words)));
      }))))));
  }

  /** @param {HTMLCanvasElement} canvas that has come into view */
  want(canvas) {
    this.seen.unobserve(canvas);
    this.waiting.push({ run: Number(canvas.dataset["run"]), canvas });
    void this.draw();
  }

  /** Draws what waits, one run after the other. */
  async draw() {
    if (this.drawing) return;
    this.drawing = true;
    for (let next; (next = this.waiting.shift()) && this.element.open;) await this.thumbnail(next.run, next.canvas);
    this.drawing = false;
  }

  /** @param {number} run @param {HTMLCanvasElement} canvas */
  async thumbnail(run, canvas) {
    const { answer } = await this.player.ask({ open: { run } });
    if (!answer.about) return;
    const { frames } = await this.player.ask({ run, seek: { t_us: answer.about.length_us, channels } });
    const world = new World(this.world.types), px = Math.min(2, devicePixelRatio || 1);
    world.introduce(answer.about);
    for (const frame of frames) world.take(frame);
    Object.assign(canvas, { width: thumbnail_px.width * px, height: thumbnail_px.height * px });
    const c = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")), panes = new Panes();
    panes.arrange(world.labs, "side", canvas.width, canvas.height, 0);
    for (const pane of panes.list) {
      whole(c, { pane: { ...pane, title: "" }, sprites: this.stage.sprites, px: 0.5 * px, shown, pictures: new Map(), trail_us: 0, sizes: new Map(), pick: null, path: [], ruler: null });
    }
  }
}

/** @param {string} text */
function number_of(text) {
  return /^-?\d+$/.test(text) ? number_words(BigInt(text)) : text;
}

/** A setting or a count in words, with its unit.
 * @param {string} name @param {import("../wire/lcm.js").Message[]} told */
function words_of(name, told) {
  const [own, lab] = name.split("@"), about = told.find(({ of }) => of === `setting.${own}` || of === `series.${own}`);
  const { words, unit } = count_name(own.replace(/^(scenario|sensors)\.[^.]+\.|^arena\./, ""));
  return (about?.["words"] || words) + (about?.["unit"] || unit ? ` (${about?.["unit"] || unit})` : "") + (lab ? `, ${lab}` : "");
}
