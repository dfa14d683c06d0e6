// What a lab's status (lab_status_t) says: names of its numbers, and sentences about whether robots stand.

/** @typedef {import("../wire/lcm.js").Message} Message */

/** Names of constants of lab_status_t and not_standing_t, by value. */
export const names = {
  phase: ["starting", "waiting", "going_on", "ending", "ended"],
  outcome: ["open", "finished", "stopped", "failed"],
  wanted: ["run", "still", "asleep", "charging", "showing_voltage"],
  why: ["not_told", "not_yet", "moving", "not_in_sight", "not_named"],
};
/** The lab lists no more robots than these. */
const listed_most = 1000;
/** Robots, or rows of them, in a sentence. */
const parts_most = 12;

/** Undefined: unknown.
 * @param {Message | null} status @param {"phase" | "outcome" | "wanted"} field
 * @returns {string | undefined} */
export function word(status, field) {
  return names[field][status?.[field]];
}

/** "4, 7-9, 11", as hal/arenas/robot_words.hpp.
 * @param {number[]} ascending */
export function robots_words(ascending) {
  const parts = [];
  for (let i = 0; i < ascending.length;) {
    if (parts.length === parts_most) return `${parts.join(", ")} and ${ascending.length - i} more`;
    let last = i;
    while (last + 1 < ascending.length && ascending[last + 1] === ascending[last] + 1) ++last;
    if (last === i + 1) last = i;
    parts.push(last === i ? `${ascending[i]}` : `${ascending[i]}-${ascending[last]}`);
    i = last + 1;
  }
  return parts.join(", ");
}

/** Who was not seen to stand, and why, the worst reason first; empty: nobody; undefined: unknown.
 * @param {Message | null} status */
export function not_standing_words(status) {
  const all = status?.["not_standing"];
  if (!Array.isArray(all)) return undefined;
  const reasons = [["moving", "moving"], ["not_in_sight", "not in sight"], ["not_named", "never identified"], ["not_told", "not sent yet"], ["not_yet", "still watched"]];
  const words = reasons.map(([why, says]) => {
    const robots = all.filter((one) => names.why[one.why] === why).map((one) => one.robot);
    return robots.length ? `${robots_words(robots)} (${says})` : "";
  });
  return words.filter(Boolean).join(", ") + (all.length >= listed_most ? ", and perhaps more" : "");
}

/** @type {Record<string, string>} */
const told = { still: "robots told to stop", asleep: "robots told to sleep", charging: "robots told to charge", showing_voltage: "robots told to show their voltage" };

/** What robots were told, where that is to stand; empty: to run, or unknown.
 * @param {Message | null} status */
export function told_words(status) {
  return told[word(status, "wanted") ?? ""] ?? "";
}

/** What robots were told and what cameras saw of it; empty: they should run, or unknown.
 * @param {Message | null} status */
export function standing_words(status) {
  const says = told_words(status), not = not_standing_words(status);
  if (!says || not === undefined) return says;
  if (not) return `${says}; not seen standing: ${not}`;
  // An arena that failed sees nobody, and so names nobody.
  if (word(status, "outcome") === "failed") return `${says}; whether they stand is unknown after the failure`;
  return `${says}; all robots were seen standing`;
}

/** Who keeps robots still in an experiment that has begun and goes on; empty: nobody, or unknown.
 * @param {Message | null} status */
export function keeper(status) {
  const who = status?.["kept_still"] ?? "";
  const runs = word(status, "outcome") === "open" && word(status, "phase") !== "starting";
  return runs && who !== "not begun" && who !== "end" ? who : "";
}

/** @param {string} who as keeper() */
export function keeper_words(who) {
  return who === "safety" ? who : who === "lost peer" ? "a lost peer" : `the ${who}`;
}

/** The sentence that stands above everything while robots are kept still; empty: they are not.
 * @param {string} lab @param {Message | null} status */
export function kept_words(lab, status) {
  const who = keeper(status);
  if (!who) return "";
  const time = word(status, "phase") === "going_on" ? "lab time continues" : "the lab waits, then lab time continues";
  return `${lab}: robots are held by ${keeper_words(who)}; ${time}; ${standing_words(status)}.`;
}

/** How a run finished whose messages were mostly lost, with reasons (hal/loss); undefined: nothing was.
 * @param {Message | null} status */
export function loss_words(status) {
  return /^finished; \d[^;]* of \d/.test(status?.["state"] ?? "") ? status?.["state"].split("; robots were told")[0] : undefined;
}

/** What a lab says of itself. While robots were not seen to stand it does not say that they are paused.
 * @param {Message} status */
export function own_words(status) {
  return not_standing_words(status) ? status["state"].replaceAll("paused", "told to stop") : status["state"];
}
