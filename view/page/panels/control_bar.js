// The operator's buttons, for who may: STOP, pause, resume, reset, arm, disarm. A lab that has taken a command has only said it to its robots:
// what comes of that is in its status, and is shown here as long as no other command is given.
import { h } from "../dom.js";
import { keeper, keeper_words, not_standing_words, standing_words, told_words, word } from "../world/status.js";

/** @type {[string, string, string][]} In the order of buttons: name, words, title. */
const commands = [["pause", "Pause", "key P"], ["resume", "Resume", "key R"], ["reset", "Reset", "Robots restart their program, and wait for Resume"], ["arm", "Arm", ""], ["disarm", "Disarm", ""]];

/** A command to one lab. `refused`: undefined before the answer, then empty or why. `statuses`: how many of the lab had come when the answer did. `took`: robots were told.
 * @typedef {{name: string, refused: string | undefined, statuses: number, took: boolean}} Order */

/** What has become of it, by the lab's newest status. "All were seen to stand" is believed of the second status after the answer only, or of one that
 * tells the end: the first may be from before the command.
 * @param {Order} order @param {import("../world/lab.js").Lab} lab */
export function order_words(order, lab) {
  const { name, refused } = order, { status } = lab;
  if (refused === undefined) return `${name}: sent`;
  if (refused) return `${name} was refused: ${refused}`;
  const said = `${name}: accepted`, wanted = word(status, "wanted"), fresh = lab.statuses - order.statuses;
  if (fresh < 1 || wanted === undefined || name === "arm" || name === "disarm") return said;
  if (wanted === "run") {
    if (name === "resume") return `${said}; robots told to run`;
    return order.took ? `${said}; robots have since been told to run` : said;
  }
  if (name === "resume") return keeper(status) && fresh > 1 ? `${said}; robots are still held by ${keeper_words(keeper(status))}` : said;
  order.took = true;
  const newer = fresh > 1 || (name === "stop" && word(status, "outcome") !== "open");
  return `${said}; ${not_standing_words(status) || newer ? standing_words(status) : told_words(status)}`;
}

export class ControlBar {
  /** @param {import("../world/world.js").World} world @param {(message: object) => Promise<{answer: any}>} ask resolves when the server has answered */
  constructor(world, ask) {
    this.world = world;
    this.ask = ask;
    this.may = false;
    /** For which lab; -1: all. */
    this.lab = -1;
    /** The newest commands, by lab. @type {Map<number, Order>} */
    this.orders = new Map();
    this.said = h("output", { class: "said", role: "status" });
    this.choice = h("select", { "aria-label": "lab for the buttons", onchange: () => (this.lab = Number(this.choice.value)) });
    this.stop_button = h("button", { class: "stop", id: "stop", title: "Stops the robots of all labs (key S)", onclick: () => this.stop() }, "■ STOP");
    this.buttons = h("span", { class: "buttons" });
    this.element = h("div", { class: "control" }, this.stop_button, this.choice, this.buttons, this.said);
    this.key = "";
  }

  /** Shows what may be done.
   * @param {boolean} may */
  allow(may) {
    this.may = may;
    const { about, labs } = this.world;
    const live = about.mode === "live";
    this.element.hidden = !live;
    const own = about.commands ?? commands;
    const key = `${may} ${live} ${about.control} ${about.labs} ${own}`;
    if (key === this.key) return;
    this.key = key;
    this.stop_button.disabled = !may;
    this.stop_button.hidden = Boolean(about.commands) || !about.control;
    this.choice.replaceChildren(h("option", { value: -1 }, "all labs"), ...labs.map((lab) => h("option", { value: lab.index }, lab.name)));
    this.choice.hidden = !may || labs.length < 2;
    this.buttons.replaceChildren(...(may ? own.map(([name, words, title]) => (
      h("button", { id: `command-${name}`, title, onclick: () => this.command(name) }, words))) : []));
    const how = about.control ? ": open the address that the lab printed, with its token, to control it" : "";
    this.say(may || !live ? "" : `read-only${how}`);
  }

  /** STOP is for all labs, whatever was chosen. */
  stop() {
    this.order("stop", this.world.labs);
  }

  /** @param {string} name */
  command(name) {
    this.order(name, this.lab < 0 ? this.world.labs : [this.world.labs[this.lab]]);
  }

  /** @param {string} name @param {import("../world/lab.js").Lab[]} labs */
  async order(name, labs) {
    if (!this.may) return this.say(`${name} was not sent: this page is read-only`);
    this.orders = new Map(labs.map((lab) => [lab.index, { name, refused: undefined, statuses: 0, took: false }]));
    this.update();
    await Promise.all([...this.orders].map(async ([index, order]) => {
      const { answer } = await this.ask({ command: { lab: index, name } });
      order.refused = answer.refused ?? "";
      order.statuses = this.world.labs[index]?.statuses ?? 0;
      this.update();
    }));
  }

  /** Shows what has become of the newest commands. */
  update() {
    if (!this.orders.size) return;
    const words = [...this.orders].map(([index, order]) => {
      const lab = this.world.labs[index];
      return lab ? `${lab.name}: ${order_words(order, lab)}` : "";
    }).join("\n");
    if (this.said.textContent !== words) this.said.textContent = words;
  }

  /** @param {string} words */
  say(words) {
    this.orders.clear();
    this.said.textContent = words;
  }
}
