// Each lab's clock, period, speed and gate, in words.
import { facts, h, section } from "./dom.js";
import { keeper, keeper_words, not_standing_words, own_words, standing_words, word } from "./status.js";
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
      const waits = s ? gate_words(s) : lab.newest.has("status") ? "its status is not understood" : "nothing heard yet";
      return h("div", { class: "lab" }, h("h3", {}, lab.name), facts([
        ["clock", time_words(lab.t_us)],
        ["period", s ? `${s["period"]} of ${s["last_period"]}` + (lab.period_us() ? `, ${lab.period_us() / 1e6} s each` : "") : "–"],
        ["speed", s ? `${Number(s["speed"]).toPrecision(3)}×` + (s["can_wait"] ? ", can wait" : ", real time") : "–"],
        ["gate", h("span", { class: s && needs_attention(s) ? "attention" : "" }, waits)],
        ["in its words", s ? own_words(s) : "–"],
        ["arena", lab.arena ? `${lab.arena.width_m} × ${lab.arena.height_m} m, ${lab.arena.platform}, ${lab.robots.length} of ${lab.arena.robots} robots` : "–"],
      ]));
    }));
  }
}

/** @param {import("./lcm.js").Message} status lab_status_t */
function needs_attention(status) {
  return word(status, "phase") === "waiting" || word(status, "outcome") === "failed" || Boolean(keeper(status) || not_standing_words(status));
}

/**
 * Whether the lab runs, waits or ends, and whether its robots run or stand. Of a status of a former version only what it says itself.
 * @param {import("./lcm.js").Message} status lab_status_t
 */
export function gate_words(status) {
  const phase = word(status, "phase"), who = keeper(status);
  const stand = who || phase === "ending" || phase === "ended" ? standing_words(status) : "";
  const and = stand ? `; ${stand}` : "";
  switch (phase) {
    case "starting": return "⏳ begins";
    case "waiting": return `⏳ ${status["lab"]} ${own_words(status).replace(/^waiting/, "waits")}`;
    case "going_on": return who ? `❚❚ robots kept still by ${keeper_words(who)}, lab time runs on${and}` : "▶ runs, waits for nobody";
    case "ending": return `■ ends: ${word(status, "outcome")}${and}`;
    case "ended": return `■ ended: ${word(status, "outcome")}${and}`;
    default: return status["state"];
  }
}
