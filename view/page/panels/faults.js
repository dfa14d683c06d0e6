// Faults of emulated testbeds, one click each: cameras and the overhead controller. Those of a robot are in its own panel.
import { h, section } from "../dom.js";

/** What the emulator's control port takes of a camera, and of the controller: words, line. @type {[string, string][]} */
const camera_faults = [["freeze", "frozen"], ["darken", "dark"], ["remove", "gone"], ["repair", "ok"]];
/** @type {[string, string][]} */
const controller_faults = [["unplug", "ohc unplug"], ["plug in", "ohc plug"], ["50 bytes of garbage", "ohc garbage 50"]];

export class FaultsPanel {
  /** @param {(lab: import("../world/lab.js").Lab, line: string) => void} fault @param {() => boolean} may */
  constructor(fault, may) {
    const { element, body } = section("Faults", false);
    this.element = element;
    this.body = body;
    this.fault = fault;
    this.may = may;
    this.key = "";
    element.hidden = true;
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    const labs = this.may() ? world.labs.filter((lab) => world.about.emulator?.[lab.index]) : [];
    const key = JSON.stringify(labs.map((lab) => [lab.name, lab.cameras.map((c) => c.name)]));
    if (key === this.key) return;
    this.key = key;
    this.element.hidden = !labs.length;
    const row = (/** @type {string} */ what, /** @type {import("../world/lab.js").Lab} */ lab, /** @type {[string, string][]} */ faults) => h("p", { class: "buttons" }, what,
      ...faults.map(([words, line]) => h("button", { onclick: () => this.fault(lab, line) }, words)));
    this.body.replaceChildren(...labs.map((lab) => h("div", {}, h("h2", {}, lab.name),
      ...lab.cameras.map(({ name }) => row(name, lab, camera_faults.map(([words, what]) => [words, `camera ${name} ${what}`]))), row("controller", lab, controller_faults))));
  }
}
