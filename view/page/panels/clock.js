// The world: a row for each lab with its time, period and speed, and what is to be said of it; of a recorded run what is known of the moment shown.
import { h, patch, section } from "../dom.js";
import { keeper, keeper_words, not_standing_words, own_words, standing_words, word } from "../world/status.js";
import { counted, rate_words, time_words } from "../words.js";

export class ClockPanel {
  constructor() {
    const { element, body } = section("World", true);
    this.element = element;
    this.body = body;
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    const recorded = world.about.mode === "recorded";
    const rows = world.labs.map((lab) => ({ lab, told: lab_words(lab, recorded) }));
    const paced = rows.some(({ told }) => told.period), fast = rows.some(({ told }) => told.speed);
    const period_s = rows.map(({ lab }) => lab.period_us() / 1e6).find((s) => s > 0);
    const head = ["lab", "time", ...(paced ? ["period"] : []), ...(fast ? ["speed"] : [])];
    patch(this.body, h("table", { class: "world" }, h("thead", {}, h("tr", {}, ...head.map((words) => h("th", { scope: "col" }, words)))),
      ...rows.map(({ lab, told }) => h("tbody", {},
        h("tr", {}, h("th", { scope: "row" }, lab.name), h("td", {}, told.time), paced && h("td", {}, told.period), fast && h("td", {}, told.speed)),
        ...[told.arena, told.says].filter(Boolean).map((words) => h("tr", {}, h("td", { colspan: head.length, class: words === told.says && told.attention ? "attention" : "about" }, words)))))),
    period_s !== undefined && h("p", { class: "about" }, `A period is ${period_s} s.`));
  }
}

/** What the panel says of a lab; what is not known is empty. A status is recorded each second of wall time, in which a fast run goes far: of a recorded
 * one the words tell when they were said, and the period is that of the shared view, which each boundary has.
 * @param {import("../world/lab.js").Lab} lab @param {boolean} recorded */
export function lab_words(lab, recorded) {
  const s = lab.status, { arena } = lab;
  const period = recorded ? lab.shared?.period : s?.period;
  const said_at = s ? time_words(s.stamp_us) : "";
  const plain = s && own_words(s) === "running";
  const old = recorded && s && word(s, "phase") === "starting" && lab.t_us > s.stamp_us; // it has begun since, and said no more
  return {
    time: time_words(lab.t_us),
    period: (s && s.last_period === 0) || period === undefined ? "" : `${period}${s ? ` of ${s.last_period}` : ""}`,
    speed: s && !old ? `${rate_words(s.speed)}×` : "",
    arena: arena ? `${arena.width_m} × ${arena.height_m} m, ${arena.platform}, ${lab.robots.length} of ${counted(arena.robots, arena.make || "robot")}` : "",
    says: recorded ? (s && !plain && !old ? `at ${said_at}: ${own_words(s)}` : "") : s ? gate_words(s) + (plain || keeper(s) || word(s, "phase") !== "going_on" ? "" : `; ${own_words(s)}`)
      : lab.newest.has("status") ? "its status cannot be read" : "nothing heard yet",
    attention: Boolean(s && needs_attention(s)),
  };
}

/** @param {import("../wire/lcm.js").Message} status lab_status_t */
function needs_attention(status) {
  return word(status, "phase") === "waiting" || word(status, "outcome") === "failed" || Boolean(keeper(status) || not_standing_words(status));
}

/** Whether the lab runs, waits or ends, and whether its robots run or stand.
 * @param {import("../wire/lcm.js").Message} status lab_status_t */
export function gate_words(status) {
  const phase = word(status, "phase"), who = keeper(status);
  const stand = who || phase === "ending" || phase === "ended" ? standing_words(status) : "";
  const and = stand ? `; ${stand}` : "";
  switch (phase) {
    case "starting": return "◔ starting";
    case "waiting": return `◔ ${own_words(status)}`;
    case "going_on": return who ? `❚❚ robots told to stop by ${keeper_words(who)}; lab time continues${and}` : "▶ running";
    case "ending": return `■ ending: ${word(status, "outcome")}${and}`;
    case "ended": return `■ ended: ${word(status, "outcome")}${and}`;
    default: return status["state"];
  }
}
