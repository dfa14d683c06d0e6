// Links to other labs: state, round trip, clocks, what was dropped and why.
import { facts, h, patch, section, table } from "../dom.js";
import { bytes_words, counted, duration_words, number_words, rate_words } from "../words.js";

/** Names of counters that count something lost. */
const lost = /dropped|expired|gap|ignored|late|lost|missing|refused|not_sent|not_recorded|replaced|skipped|withheld/;

export class LinksPanel {
  constructor() {
    const { element, body } = section("Links", true);
    this.element = element;
    this.body = body;
    /** Labs whose drops are unfolded. @type {Set<string>} */
    this.unfolded = new Set();
  }

  /** @param {import("../world/world.js").World} world */
  update(world) {
    const shown = world.labs.map((lab) => ({ lab, drops: drops_of(lab) })).filter(({ lab, drops }) => is_joined(lab) || drops.length);
    this.element.hidden = !shown.length;
    patch(this.body, ...shown.map(({ lab, drops }) => h("div", { class: "lab" }, h("h2", {}, lab.name),
      ...(is_joined(lab) ? this.peers(lab, world) : []),
      drops.length ? h("details", { open: this.unfolded.has(lab.name) }, h("summary", { onclick: () => this.fold(lab.name) }, `${counted(drops.length, "counter")} of dropped messages`), table(["dropped", "count"], drops.map((c) => [c.name, number_words(c.value)]))) : h("p", {}, "nothing dropped"))));
  }

  /** @param {import("../world/lab.js").Lab} lab @param {import("../world/world.js").World} world */
  peers(lab, world) {
    const peers = lab.peers?.peers ?? [];
    return peers.length ? peers.map((/** @type {import("../wire/lcm.js").Message} */ p) => peer(p, world.rates[lab.index] ?? {})) : [h("p", {}, lab.peers ? "no peers" : "no gateway heard")];
  }

  /** At the click, not at `toggle`: the panel may be written anew in between.
   * @param {string} lab */
  fold(lab) {
    if (!this.unfolded.delete(lab)) this.unfolded.add(lab);
  }
}

/** @param {import("../world/lab.js").Lab} lab */
function drops_of(lab) {
  return [...(lab.status?.counters ?? []), ...(lab.peers?.counters ?? [])].filter((c) => lost.test(c.name) && Number(c.value) > 0);
}

/** Whether a lab has, or waits for, links: a swarm without periods has none, and a lab without others neither.
 * @param {import("../world/lab.js").Lab} lab */
export function is_joined(lab) {
  return Boolean(lab.peers?.peers.length) || (lab.status?.last_period > 0 && lab.shared?.labs.length !== 1);
}

/** @param {import("../wire/lcm.js").Message} p peer_t @param {Record<string, import("../world/world.js").Rate>} rates of the channels of the lab that hears it */
function peer(p, rates) {
  const drops = p.counters.filter((/** @type {any} */ c) => lost.test(c.name) && Number(c.value) > 0);
  return h("div", {}, facts([
    [p.lab, h("span", { class: p.up ? "good" : "attention" }, `${p.up ? "● up" : "○ down"}${p.why ? `: ${p.why}` : ""}`)],
    .../** @type {[string, string][]} */ (p.round_trip_us < 0 ? [] : [["round trip", duration_words(p.round_trip_us)], ["its clock", `${p.clock_offset_us >= 0 ? "+" : "−"}${duration_words(Math.abs(Number(p.clock_offset_us)))} ± ${duration_words(Number(p.clock_uncertainty_us))}`]]),
  ]), p.n_channels ? table(["channel", "age", "per s", "messages", "bytes"], p.channels.map((/** @type {any} */ c) => (
    [c.channel, c.age_us < 0 ? "never" : duration_words(Number(c.age_us)), rates[c.channel] ? rate_words(rates[c.channel].per_s) : "–", number_words(c.messages), bytes_words(Number(c.bytes))]))) : null,
  drops.length ? table(["dropped", "count"], drops.map((/** @type {any} */ c) => [c.name, number_words(c.value)])) : null);
}
