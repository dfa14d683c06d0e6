// The picked robot: id, pose, confidence, LED, the newest messages to it, and what its program printed.
import { facts, h, patch, section, table } from "../dom.js";
import { led_names } from "../draw/colours.js";
import { find } from "../draw/robots.js";
import { duration_words, time_words } from "../words.js";

/** Of what a robot printed, the newest. */
const lines_most = 20;

export class RobotPanel {
  /** @param {import("../stage/options.js").Options} options @param {(lab: import("../world/lab.js").Lab, robot: number, line: string) => void} fault @param {() => boolean} may */
  constructor(options, fault, may) {
    const { element, body } = section("Robot", true);
    this.element = element;
    this.options = options;
    this.fault = fault;
    this.may = may;
    this.facts = h("div");
    this.faults = h("div", { class: "buttons", hidden: true });
    body.append(this.facts, this.faults);
    /** For which robot the buttons are. */
    this.buttons_of = "";
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    const { pick, follow } = this.options;
    const lab = pick && world.labs.find((l) => l.own === pick.lab);
    const seen_by = lab ?? world.labs.find((l) => pick && find(l, pick));
    const robot = pick && seen_by && find(seen_by, pick);
    if (!pick) patch(this.facts, h("p", {}, "Click a robot, or press ] for the next one."));
    else if (!robot || !seen_by) patch(this.facts, h("p", {}, `${pick.lab}/${pick.id} is not visible now.`));
    else {
      /** @type {[string, string | Node][]} */
      const pairs = [
        ["robot", `${pick.lab}/${pick.id}${follow ? ", followed" : ""}`],
        ["position", `x ${robot.x.toFixed(4)} m, y ${robot.y.toFixed(4)} m`],
        ["heading", `${((robot.heading * 180) / Math.PI).toFixed(1)}°`],
        ["LED", led_names[Math.min(robot.led, 8)]],
      ];
      if ("confidence" in robot) pairs.push(["confidence", robot.confidence.toFixed(2)], ["seen", robot.age_us ? `${duration_words(robot.age_us)} before` : "in this frame"]);
      else {
        const fleet = seen_by.ghosts.find((f) => f.lab === pick.lab);
        pairs.push(["received by", `${seen_by.name}, in its arena's frame`], ["age", fleet ? duration_words(seen_by.age_us(fleet)) : "–"]);
      }
      const told = lab?.told_to(pick.id) ?? [];
      const printed = lab?.texts.get(pick.id);
      patch(this.facts, facts(pairs), h("h2", {}, "Latest messages to it"), told.length
        ? table(["time", "slot", "kind", "value"], told.map((m) => [time_words(m.t_us), m.slot, m.kind, m.value]))
        : h("p", {}, lab ? "none yet" : "sent by its own lab"), ...(printed ? [h("h2", {}, "Printed by its program"), h("pre", { class: "printed" }, printed.trimEnd().split("\n").slice(-lines_most).join("\n"))] : []));
    }
    this.update_faults(world, lab ?? null);
  }

  /** @param {import("../world/world.js").World} world @param {import("../world/lab.js").Lab | null} lab */
  update_faults(world, lab) {
    const id = this.options.pick?.id;
    const key = lab && world.about.emulator?.[lab.index] && this.may() ? `${lab.name}/${id}` : "";
    if (key === this.buttons_of) return;
    this.buttons_of = key;
    this.faults.hidden = !key;
    if (!lab) return;
    const faults = [["kill", "kill"], ["revive", "revive"], ["cover for 5 s", "cover 5"], ["take away", "take"]];
    this.faults.replaceChildren(...faults.map(([words, line]) => h("button", { onclick: () => this.fault(lab, Number(id), line) }, words)));
  }
}
