// Each lab's clock, period, speed and gate, in words; of a recorded run what is known of the moment that is shown.
import { facts, h, section } from "../dom.js";
import { keeper, keeper_words, not_standing_words, own_words, standing_words, word } from "../world/status.js";
import { counted, rate_words, time_words } from "../words.js";

export class ClockPanel {
  constructor() {
    const { element, body } = section("Clock and gate", true);
    this.element = element;
    this.body = body;
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    const recorded = world.about.mode === "recorded";
    this.body.replaceChildren(...world.labs.map((lab) => {
      const attention = lab.status && needs_attention(lab.status) ? "attention" : "";
      const rows = clock_rows(lab, recorded).map(([name, words]) => /** @type {[string, string | Node]} */ ([name, name === "gate" || name === "said" ? h("span", { class: attention }, words) : words]));
      return h("div", { class: "lab" }, h("h3", {}, lab.name), facts(rows));
    }));
  }
}

/**
 * What the panel says of a lab: names and words. A status is recorded each second of wall time, in which a fast run goes far: of a recorded one the
 * words tell when they were said, and the period is that of the shared view, which each boundary has.
 * @param {import("../world/lab.js").Lab} lab @param {boolean} recorded
 * @returns {[string, string][]}
 */
export function clock_rows(lab, recorded) {
  const s = lab.status;
  const period = recorded ? lab.shared?.period : s?.period;
  const speed = s ? `${rate_words(s.speed)}×` : "–";
  const said_at = s ? time_words(s.stamp_us) : "";
  return [
    ["clock", time_words(lab.t_us)],
    .../** @type {[string, string][]} */ (s && s.last_period === 0 ? [] : [["period", period === undefined ? "–" : `${period}${s ? ` of ${s.last_period}` : ""}${lab.period_us() ? `, ${lab.period_us() / 1e6} s each` : ""}`]]),
    ...(recorded ? /** @type {[string, string][]} */ (s ? [["said", `at ${said_at}: ${own_words(s)}`], ["speed", `${speed} up to ${said_at}`]] : []) : /** @type {[string, string][]} */ ([
      ["speed", s ? speed + (s.can_wait ? ", can wait" : ", real time") : speed],
      ["gate", s ? gate_words(s) : lab.newest.has("status") ? "its status is not understood" : "nothing heard yet"],
      ["in its words", s ? own_words(s) : "–"],
    ])),
    ["arena", lab.arena ? `${lab.arena.width_m} × ${lab.arena.height_m} m, ${lab.arena.platform}, ${lab.robots.length} of ${counted(lab.arena.robots, "robot")}` : "–"],
  ];
}

/** @param {import("../wire/lcm.js").Message} status lab_status_t */
function needs_attention(status) {
  return word(status, "phase") === "waiting" || word(status, "outcome") === "failed" || Boolean(keeper(status) || not_standing_words(status));
}

/**
 * Whether the lab runs, waits or ends, and whether its robots run or stand.
 * @param {import("../wire/lcm.js").Message} status lab_status_t
 */
export function gate_words(status) {
  const phase = word(status, "phase"), who = keeper(status);
  const stand = who || phase === "ending" || phase === "ended" ? standing_words(status) : "";
  const and = stand ? `; ${stand}` : "";
  switch (phase) {
    case "starting": return "◔ begins";
    case "waiting": return `◔ ${status["lab"]} ${own_words(status).replace(/^waiting/, "waits")}`;
    case "going_on": return who ? `❚❚ robots kept still by ${keeper_words(who)}, lab time runs on${and}` : "▶ runs, waits for nobody";
    case "ending": return `■ ends: ${word(status, "outcome")}${and}`;
    case "ended": return `■ ended: ${word(status, "outcome")}${and}`;
    default: return status["state"];
  }
}
