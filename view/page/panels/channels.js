// All channels with their rates, and the newest message of the one that was opened, decoded.
import { DecodeError } from "../wire/lcm.js";
import { breakable, h, section } from "../dom.js";
import { bytes_words, counted, number_words, rate_words, time_words } from "../words.js";

/** Lines of a decoded message that are shown; more only cost time. */
const lines_most = 400;

export class ChannelsPanel {
  constructor() {
    const { element, body } = section("Channels", false);
    this.element = element;
    this.rows = h("tbody");
    this.message = h("pre", { tabindex: 0, class: "message" });
    this.title = h("h2");
    body.append(h("table", {}, h("thead", {}, h("tr", {}, ...["channel", "per s", "bytes/s", "count"].map((t) => h("th", { scope: "col" }, t)))), this.rows), this.title, this.message);
    /** @type {{lab: number, channel: string} | null} */
    this.opened = null;
    /** The message that is shown: its count. */
    this.shown = "";
    this.listed = "";
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    this.list(world);
    const lab = this.opened && world.labs[this.opened.lab];
    const newest = lab && this.opened ? lab.newest.get(this.opened.channel) : undefined;
    if (!lab || !newest || !this.opened) return;
    const key = `${this.opened.lab} ${this.opened.channel} ${newest.count}`;
    if (key === this.shown) return;
    this.shown = key;
    this.title.textContent = `${lab.name}: ${this.opened.channel}, ${time_words(newest.t_us)}`;
    this.message.textContent = describe(world.types, newest.bytes);
  }

  /** Rows are made once for each set of channels and then only written to: a click may come at any time.
   * @param {import("../world/world.js").World} world */
  list(world) {
    const channels = world.labs.flatMap((lab) => [...new Set([...lab.newest.keys(), ...Object.keys(world.rates[lab.index] ?? {})])].sort().map((channel) => ({ lab, channel })));
    const key = channels.map((c) => `${c.lab.name} ${c.channel}`).join();
    if (key !== this.listed) {
      this.listed = key;
      this.rows.replaceChildren(...channels.map(({ lab, channel }) => h("tr", {},
        h("td", {}, h("button", { class: "link", onclick: () => this.open(lab.index, channel, world) }, breakable(`${lab.name}: ${channel}`))), h("td"), h("td"), h("td"))));
    }
    channels.forEach(({ lab, channel }, i) => {
      const rate = world.rates[lab.index]?.[channel];
      const cells = this.rows.children[i].children;
      cells[1].textContent = rate ? rate_words(rate.per_s) : "–";
      cells[2].textContent = rate ? bytes_words(rate.bytes_per_s) : "–";
      cells[3].textContent = number_words(rate?.count ?? lab.newest.get(channel)?.count ?? 0);
    });
  }

  /** @param {number} lab @param {string} channel @param {import("../world/world.js").World} world */
  open(lab, channel, world) {
    this.opened = { lab, channel };
    this.shown = "";
    this.message.textContent = "no message yet";
    this.update(world);
  }
}

/** A message as indented lines.
 * @param {import("../wire/lcm.js").Types} types @param {Uint8Array} bytes */
export function describe(types, bytes) {
  try {
    const { type, value } = types.decode(bytes);
    /** @type {string[]} */
    const lines = [`${type}, ${bytes_words(bytes.length)}`];
    write(lines, value, "");
    return lines.length > lines_most ? lines.slice(0, lines_most).join("\n") + `\n… ${counted(lines.length - lines_most, "more line")}` : lines.join("\n");
  } catch (error) {
    if (!(error instanceof DecodeError)) throw error;
    return `${counted(bytes.length, "byte")}: the message ${error.message}`;
  }
}

/** @param {string[]} lines @param {any} value @param {string} indent */
function write(lines, value, indent) {
  for (const [name, field] of Object.entries(value)) {
    if (Array.isArray(field) && typeof field[0] === "object") {
      field.forEach((item, i) => {
        lines.push(`${indent}${name}[${i}]`);
        write(lines, item, indent + "  ");
      });
    } else if (field instanceof Uint8Array) lines.push(`${indent}${name} = ${[...field.subarray(0, 64)].join(" ")}${field.length > 64 ? " …" : ""}`);
    else if (Array.isArray(field)) lines.push(`${indent}${name} = ${field.join(" ")}`);
    else lines.push(`${indent}${name} = ${field}`);
  }
}
