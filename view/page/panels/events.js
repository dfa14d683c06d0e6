// What happened, the newest first.
import { h, section } from "../dom.js";
import { time_words } from "../words.js";

/** Lines that are shown. */
const lines_most = 200;

export class EventsPanel {
  /** @param {((t_us: number) => void) | null} jump to a time of a recorded run */
  constructor(jump) {
    const { element, body } = section("Events", true);
    this.element = element;
    this.list = h("ol", { class: "events" });
    body.append(this.list);
    this.jump = jump;
    this.shown = -1;
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    if (world.events_version === this.shown) return;
    this.shown = world.events_version;
    const newest = world.events.slice(-lines_most).reverse();
    this.list.replaceChildren(...newest.map((event) => {
      const time = time_words(event.t_us), jump = this.jump;
      return h("li", {}, jump ? h("button", { class: "link", onclick: () => jump(event.t_us) }, time) : h("time", {}, time), ` ${world.labs[event.lab]?.name ?? ""} ${event.text}`);
    }));
    if (!newest.length) this.list.replaceChildren(h("li", {}, "nothing yet"));
  }
}
