// Which recorded runs are shown: one of a batch, or two that are compared, with the first period in which they differ.
import { h, section } from "../dom.js";
import { counted, distance_words } from "../words.js";

/** Differences of places that are told, the largest. */
const places_most = 6;

export class RunsPanel {
  /** @param {import("../world/world.js").World} world @param {import("../play/player.js").Player} player @param {(about: import("../world/world.js").About) => void} introduce another run @param {() => void} all shows all runs of a batch */
  constructor(world, player, introduce, all) {
    const { element, body } = section("Runs", true);
    this.element = element;
    this.world = world;
    this.player = player;
    this.introduce = introduce;
    this.choice = h("select", { "aria-label": "run of the batch", onchange: () => this.open(this.choice.selectedIndex) });
    this.all = h("button", { id: "all-runs", onclick: all }, "▦ all runs");
    this.notes = h("div");
    this.button = h("button", { id: "difference", onclick: () => this.go() }, "first difference");
    this.said = h("div", { role: "status" });
    body.append(h("div", { class: "buttons" }, this.choice, this.all), this.notes, this.button, this.said);
    this.key = "";
    element.hidden = true;
  }

  update() {
    const { about } = this.world;
    const key = JSON.stringify([about.labs, about.runs, about.number, about.notes, about.first_difference]);
    if (key === this.key) return;
    this.key = key;
    const runs = about.runs ?? [], notes = about.notes ?? [];
    const two = new Set(about.labs.map(run_of)).size === 2;
    this.element.hidden = !notes.length && (about.mode !== "recorded" || (runs.length < 2 && !two));
    this.choice.hidden = this.all.hidden = two || runs.length < 2;
    if (this.choice.options.length !== runs.length) this.choice.replaceChildren(...runs.map((run) => h("option", {}, run)));
    this.choice.selectedIndex = about.number ?? 0;
    this.notes.replaceChildren(...notes.map((note) => h("p", { class: "attention" }, note)));
    this.button.hidden = !about.first_difference;
    this.said.replaceChildren(); // where they differ is one of the notes
  }

  /** Shows another run of the batch.
   * @param {number} run */
  async open(run) {
    this.player.play(false);
    const { answer } = await this.player.ask({ open: { run } });
    if (answer.refused) this.said.replaceChildren(`not opened: ${answer.refused}`);
    else this.introduce(answer.about);
  }

  /** Goes to where the runs begin to differ, and tells whose robots lie apart there. */
  async go() {
    const { world, player } = this, d = world.about.first_difference;
    if (!d) return;
    player.play(false);
    await player.seek(d.t_us);
    const [first, ...others] = [...new Set(world.labs.map((lab) => run_of(lab.name)))].map((run) => world.labs.filter((lab) => run_of(lab.name) === run));
    const pairs = first.flatMap((lab) => others.flat().filter((other) => other.own === lab.own).map((other) => ({ lab, other })));
    this.said.replaceChildren(...pairs.map(({ lab, other }) => h("p", {}, `${lab.own}: ${differences(lab, other)}`)));
  }
}

/** The run in RUN/LAB.
 * @param {string} lab */
function run_of(lab) {
  return lab.slice(0, Math.max(0, lab.lastIndexOf("/")));
}

/** Whose robots lie elsewhere, in words.
 * @param {import("../world/lab.js").Lab} a @param {import("../world/lab.js").Lab} b */
export function differences(a, b) {
  const apart = a.robots.flatMap((r) => {
    const other = b.robots.find((x) => x.id === r.id);
    return other ? [{ id: r.id, d: Math.hypot(r.x - other.x, r.y - other.y) }] : [];
  }).filter(({ d }) => d > 0).sort((x, y) => y.d - x.d);
  if (!apart.length) return "all robots at the same positions; other shared values differ";
  return `${counted(apart.length, "robot differs", "robots differ")} in position; largest differences: ${apart.slice(0, places_most).map(({ id, d }) => `${id} by ${distance_words(d)}`).join(", ")}`;
}
