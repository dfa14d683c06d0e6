// What colours and LEDs mean: those that the scenario draws, in its own words, else in those of the table of colours.
import { h, section } from "../dom.js";
import { Colours } from "../draw/colours.js";
import { shape } from "../draw/floor.js";
import { Sprites } from "../draw/sprites.js";

/** A sample's size, CSS pixels. */
const sample_px = { width: 26, height: 20 };

export class LegendPanel {
  /** @param {import("../stage/stage.js").Stage} stage */
  constructor(stage) {
    const { element, body } = section("Legend", true);
    this.element = element;
    this.stage = stage;
    this.list = h("ul", { class: "legend" });
    body.append(this.list);
    this.key = "";
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    const { colours } = this.stage.sprites, entries = legend_of(world.labs, colours.table);
    const key = JSON.stringify([entries, colours.dark]);
    if (key === this.key) return;
    this.key = key;
    this.element.hidden = !entries.length;
    this.list.replaceChildren(...entries.map(({ of, words }) => h("li", {}, sample(of, colours), h("span", {}, words))));
  }
}

/** @typedef {{of: string, words: string}} Entry */

/** What is to be explained: each colour of what labs draw now, and the LEDs that the scenario has words for.
 * @param {import("../world/lab.js").Lab[]} labs @param {import("../draw/colours.js").Table} table
 * @returns {Entry[]} */
export function legend_of(labs, table) {
  const drawn = new Set(labs.flatMap(({ overlay }) => ["rasters", "polygons", "circles", "lines", "texts"].flatMap((kind) => overlay?.[kind] ?? [])
    .map((shape) => (Object.hasOwn(table.colours, shape.colour) ? shape.colour : "note"))));
  /** @type {Map<string, string>} */
  const told = new Map();
  for (const lab of labs) for (const { of, words } of lab.shown) if (words && !told.has(of)) told.set(of, words);
  const said = [...told].filter(([of]) => of.startsWith("led.") || (of.startsWith("colour.") && drawn.has(of.slice(7))));
  const others = Object.entries(table.colours).filter(([name]) => drawn.has(name) && !told.has(`colour.${name}`)).map(([name, { means }]) => /** @type {[string, string]} */ ([`colour.${name}`, means]));
  return [...said, ...others].map(([of, words]) => ({ of, words }));
}

/** A robot with that LED, or a shape in that colour.
 * @param {string} of @param {Colours} colours */
function sample(of, colours) {
  const { width, height } = sample_px, ratio = devicePixelRatio || 1;
  const canvas = h("canvas", { width: width * ratio, height: height * ratio, "aria-hidden": "true" });
  const c = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  if (of.startsWith("led.")) {
    const robot = new Sprites(colours).robot(Number(of.slice(4)), Math.PI / 2, 7 * ratio, false);
    c.drawImage(robot, Math.round((canvas.width - robot.width) / 2), Math.round((canvas.height - robot.height) / 2));
    return canvas;
  }
  c.rect(2 * ratio, 3 * ratio, (width - 4) * ratio, (height - 6) * ratio);
  shape(c, { colour: of.slice(7), filled: true }, colours, ratio);
  return canvas;
}
