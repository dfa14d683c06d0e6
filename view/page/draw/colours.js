// Colours of everything that is drawn, for light and dark grounds. Those of meanings and LEDs come from colours.json, which the program reads too.

/** @typedef {{light: string, dark: string, pattern: "plain"|"stripes"|"dots"|"cross", means: string}} Meaning */
/** @typedef {{fill_opacity: number, raster_opacity: number, leds: {light: string[], dark: string[]}, colours: Record<string, Meaning>}} Table */
/** @typedef {{page: string, ground: string, grid: string, wall: string, solid: string, object: string, body: string, ink: string, halo: string, pick: string, trail: string}} Inks */

/** @type {{light: Inks, dark: Inks}} */
const inks = {
  light: { page: "#e9e7e1", ground: "#fbfaf6", grid: "#e6e3da", wall: "#4a4a46", solid: "#8d8a80", object: "#b79b63", body: "#3b4148", ink: "#1c1f22", halo: "#fbfaf6", pick: "#b0006e", trail: "#5c6670" },
  dark: { page: "#111417", ground: "#1b1f23", grid: "#272c31", wall: "#9aa0a6", solid: "#5d646b", object: "#8a7440", body: "#c3cad1", ink: "#eef1f3", halo: "#14171a", pick: "#ff7fd0", trail: "#8d98a3" },
};

/** Names of LED colours, for people. */
export const led_names = ["off", "red", "green", "yellow", "blue", "magenta", "cyan", "white", "unknown"];

export class Colours {
  /** @param {Table} table @param {boolean} dark */
  constructor(table, dark) {
    this.table = table;
    this.dark = dark;
    this.inks = dark ? inks.dark : inks.light;
    this.leds = dark ? table.leds.dark : table.leds.light;
    /** @type {Map<string, CanvasPattern>} */
    this.patterns = new Map();
  }

  /** The same colours as they are over camera pictures. */
  over_picture() {
    return this.dark ? this : new Colours(this.table, true);
  }

  /** @param {string} name of a meaning; unknown ones are notes @returns {Meaning} */
  meaning(name) {
    return this.table.colours[name] ?? this.table.colours["note"];
  }

  /** @param {string} name of a meaning */
  of(name) {
    const meaning = this.meaning(name);
    return this.dark ? meaning.dark : meaning.light;
  }

  /** What lies over a filled shape of that meaning; null when nothing does.
   * @param {CanvasRenderingContext2D} context @param {string} name */
  pattern(context, name) {
    const kind = this.meaning(name).pattern;
    if (kind === "plain") return null;
    let pattern = this.patterns.get(name);
    if (!pattern) {
      const tile = new OffscreenCanvas(8, 8);
      const inside = /** @type {OffscreenCanvasRenderingContext2D} */ (tile.getContext("2d"));
      inside.strokeStyle = inside.fillStyle = this.of(name);
      inside.beginPath();
      if (kind === "dots") inside.arc(4, 4, 1.1, 0, 7);
      for (const shift of kind === "dots" ? [] : [-8, 0, 8]) {
        inside.moveTo(shift - 1, 9);
        inside.lineTo(shift + 9, -1);
        if (kind === "cross") {
          inside.moveTo(shift - 1, -1);
          inside.lineTo(shift + 9, 9);
        }
      }
      if (kind === "dots") inside.fill();
      else inside.stroke();
      pattern = /** @type {CanvasPattern} */ (context.createPattern(/** @type {any} */ (tile), "repeat"));
      this.patterns.set(name, pattern);
    }
    return pattern;
  }
}
