// Each lab's clock, period, speed and gate, in words.
import { facts, h, section } from "./dom.js";
import { time_words } from "./words.js";

export class ClockPanel {
  constructor() {
    const { element, body } = section("Clock and gate", true);
    this.element = element;
    this.body = body;
  }

  /** @param {import("./world.js").World} world */
  update(world) {
    this.body.replaceChildren(...world.labs.map((lab) => {
      const s = lab.status;
      const waits = s ? gate_words(s) : "nothing heard yet";
      return h("div", { class: "lab" }, h("h3", {}, lab.name), facts([
        ["clock", time_words(lab.t_us)],
        ["period", s ? `${s.period} of ${s.last_period}` + (lab.period_us() ? `, ${lab.period_us() / 1e6} s each` : "") : "–"],
        ["speed", s ? `${Number(s.speed).toPrecision(3)}×` + (s.can_wait ? ", can wait" : ", real time") : "–"],
        ["gate", h("span", { class: s && /wait|failed|lost/.test(s.state) ? "attention" : "" }, waits)],
        ["arena", lab.arena ? `${lab.arena.width_m} × ${lab.arena.height_m} m, ${lab.arena.platform}, ${lab.robots.length} of ${lab.arena.robots} robots` : "–"],
      ]));
    }));
  }
}

/**
 * Who waits for whom, in words.
 * @param {import("./lcm.js").Message} status lab_status_t
 */
export function gate_words(status) {
  const waiting = /^waiting for ([^:]+)(?:: (.*))?$/.exec(status.state);
  if (waiting) return `⏳ ${status.lab} waits for ${waiting[1]}${waiting[2] ? `: ${waiting[2]}` : ""}`;
  if (status.state === "running") return "▶ runs, waits for nobody";
  return status.state;
}
