// The operator's buttons, for who may: STOP, pause, resume, reset, arm, disarm. What the lab refused is shown.
import { h } from "./dom.js";

/**
 * In the order of buttons: name, words, title.
 * @type {[string, string, string][]}
 */
const commands = [["pause", "Pause", "key P"], ["resume", "Resume", "key R"], ["reset", "Reset", "Robots begin their program again, and wait for Resume"], ["arm", "Arm", ""], ["disarm", "Disarm", ""]];

export class ControlBar {
  /** @param {import("./world.js").World} world @param {(message: object) => Promise<{answer: any}>} ask resolves when the server has answered */
  constructor(world, ask) {
    this.world = world;
    this.ask = ask;
    this.may = false;
    /** For which lab; -1: all. */
    this.lab = -1;
    this.said = h("output", { class: "said", role: "status" });
    this.choice = h("select", { "aria-label": "lab that the buttons are for", onchange: () => (this.lab = Number(this.choice.value)) });
    this.stop_button = h("button", { class: "stop", id: "stop", title: "Stops the robots of all labs (key S)", onclick: () => this.stop() }, "■ STOP");
    this.buttons = h("span", { class: "buttons" });
    this.element = h("div", { class: "control" }, this.stop_button, this.choice, this.buttons, this.said);
    this.key = "";
  }

  /**
   * Shows what may be done.
   * @param {boolean} may
   */
  allow(may) {
    this.may = may;
    const { about, labs } = this.world;
    const live = about.mode === "live";
    this.element.hidden = !live;
    const key = `${may} ${live} ${about.labs}`;
    if (key === this.key) return;
    this.key = key;
    this.stop_button.disabled = !may;
    this.choice.replaceChildren(h("option", { value: -1 }, "all labs"), ...labs.map((lab) => h("option", { value: lab.index }, lab.name)));
    this.choice.hidden = !may || labs.length < 2;
    this.buttons.replaceChildren(...(may ? commands.map(([name, words, title]) => (
      h("button", { id: `command-${name}`, title, onclick: () => this.command(name) }, words))) : []));
    this.say(may || !live ? "" : "to look only: open the address that the lab printed, with its token, to control it");
  }

  /** STOP is for all labs, whatever was chosen. */
  stop() {
    this.order("stop", this.world.labs);
  }

  /** @param {string} name */
  command(name) {
    this.order(name, this.lab < 0 ? this.world.labs : [this.world.labs[this.lab]]);
  }

  /** @param {string} name @param {import("./lab.js").Lab[]} labs */
  async order(name, labs) {
    if (!this.may) return this.say(`${name} was not sent: this page may only look`);
    this.say(`${name} sent to ${labs.map((lab) => lab.name).join(", ")}`);
    const answers = await Promise.all(labs.map((lab) => this.ask({ command: { lab: lab.index, name } })));
    this.say(answers.map(({ answer }, i) => `${labs[i].name}: ${answer.refused ? `${name} was refused: ${answer.refused}` : `${name} done`}`).join("; "));
  }

  /** @param {string} words */
  say(words) {
    this.said.textContent = words;
  }
}
