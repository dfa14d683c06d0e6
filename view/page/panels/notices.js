// What stands above everything: whether the page hears its labs, who keeps robots still, and how runs ended. Knows when something was heard,
// not how.
import { h } from "../dom.js";
import { keeper, kept_words, loss_words, standing_words, word } from "../world/status.js";
import { time_words } from "../words.js";

/** Who is not heard for so long is silent: a server says something each second, milliseconds. */
export const silent_ms = 3000;

/** @typedef {import("../world/world.js").World} World */

/** What the page does not hear, in words; empty: it hears everything.
 * @param {World} world @param {{open: boolean, why: string, heard_ms: number}} connection @param {number} now_ms of the same clock */
export function silence_words(world, connection, now_ms) {
  const live = world.about.mode === "live", { labs } = world;
  const ended = live && labs.length > 0 && labs.every((lab) => word(lab.status, "phase") === "ended");
  if (!connection.open) return ended ? "Not connected: the run and its program have ended. This is the final state." : `Not connected: ${connection.why}. This view is out of date; reconnecting…`;
  const words = (/** @type {string} */ what, /** @type {number} */ since_ms) => `Nothing received ${what} for ${Math.floor((now_ms - since_ms) / 1000)} s. This view is out of date.`;
  if (now_ms - connection.heard_ms >= silent_ms) return words("from this page's server", connection.heard_ms);
  const heard = labs.filter((lab) => lab.heard_ms > 0);
  const newest_ms = Math.max(...heard.map((lab) => lab.heard_ms));
  return live && !ended && heard.length && now_ms - newest_ms >= silent_ms ? words(`from ${heard.map((lab) => lab.name).join(", ")}`, newest_ms) : "";
}

/** How runs ended: a line for each lab whose has, and where results are once all have.
 * @param {World} world */
export function ended_words(world) {
  if (world.about.mode !== "live") return [];
  const ended = world.labs.filter((lab) => word(lab.status, "phase") === "ended");
  const lines = ended.map((lab) => [`${lab.name}: ${loss_words(lab.status) ?? word(lab.status, "outcome") ?? "ended"}`, standing_words(lab.status)].filter(Boolean).join("; "));
  const { folder } = world.about;
  if (!ended.length || ended.length < world.labs.length || !folder) return lines;
  const word_of_shell = /^[\w@%+=:,./-]+$/.test(folder) ? folder : `'${folder.replaceAll("'", "'\\''")}'`;
  return [`ended; results in ${folder}; replay with arkmesh view ${word_of_shell}`, ...lines];
}

export class Notices {
  /** @param {HTMLElement} banner for what is not heard */
  constructor(banner) {
    this.banner = banner;
    this.kept = h("div", { id: "kept", class: "notice", role: "status", hidden: true });
    this.ended = h("div", { id: "ended", class: "notice", role: "status", hidden: true });
    this.connection = { open: true, why: "", heard_ms: 0 };
  }

  /** @param {boolean} open @param {string} why @param {number} now_ms */
  connected(open, why, now_ms) {
    this.connection = { open, why, heard_ms: now_ms };
  }

  /** @param {number} now_ms */
  heard(now_ms) {
    this.connection.heard_ms = now_ms;
  }

  /** @param {World} world @param {number} now_ms */
  update(world, now_ms) {
    const silence = silence_words(world, this.connection, now_ms);
    write(this.banner, silence ? [silence] : []);
    document.body.classList.toggle("apart", Boolean(silence));
    const when = (/** @type {import("../wire/lcm.js").Message | null} */ status) => (status && world.about.mode === "recorded" ? `at ${time_words(status.stamp_us)}: ` : "");
    write(this.kept, world.labs.filter((lab) => keeper(lab.status)).map((lab) => when(lab.status) + kept_words(lab.name, lab.status)));
    write(this.ended, ended_words(world));
  }
}

/** Only what changed, because screen readers read it out.
 * @param {HTMLElement} element @param {string[]} lines */
function write(element, lines) {
  const text = lines.join("\n");
  element.hidden = !text;
  if (element.textContent !== text) element.textContent = text;
}
