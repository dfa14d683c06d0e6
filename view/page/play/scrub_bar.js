// The bar of a recorded run: play, speed, steps, and where in time we are.
import { h } from "../dom.js";
import { speeds } from "./player.js";
import { time_words } from "../words.js";

/** A step with the keyboard or a button: a frame of poses, microseconds, where the arena does not tell. */
const usual_frame_us = 100_000;

export class ScrubBar {
  /** @param {import("./player.js").Player} player @param {import("../world/world.js").World} world */
  constructor(player, world) {
    this.player = player;
    this.world = world;
    this.play = h("button", { id: "play", title: "Play or pause (Space)", onclick: () => player.play(!player.playing) }, "▶");
    const step = (/** @type {number} */ by) => h("button", { title: by < 0 ? "A frame back (←)" : "A frame forward (→)", "aria-label": by < 0 ? "a frame back" : "a frame forward", onclick: () => this.step(by) }, by < 0 ? "◁" : "▷");
    this.bar = h("input", { type: "range", min: 0, max: 1000, step: 1, value: 0, id: "scrub", "aria-label": "time", oninput: () => player.seek(Number(this.bar.value) * 1000) });
    this.marks = h("div", { class: "marks", "aria-hidden": "true" });
    this.time = h("output", { id: "time" });
    this.speed = h("select", { "aria-label": "speed", id: "speed", onchange: () => player.set_speed(Number(this.speed.value)) },
      ...speeds.map((s) => h("option", { value: s, selected: s === 1 }, `${s}×`)));
    this.element = h("div", { class: "scrub", hidden: true }, step(-1), this.play, step(1), h("div", { class: "track" }, this.bar, this.marks), this.time, this.speed);
    this.marked = "";
  }

  /** @param {number} by frames */
  step(by) {
    const frame_us = this.world.labs[0]?.arena?.frame_period_us || usual_frame_us;
    this.player.step(by * frame_us);
  }

  /** The next faster or slower speed.
   * @param {1 | -1} by */
  change_speed(by) {
    const at = Math.min(speeds.length - 1, Math.max(0, speeds.indexOf(this.player.speed) + by));
    this.player.set_speed(speeds[at]);
    this.speed.value = String(speeds[at]);
  }

  update() {
    const { player } = this;
    this.bar.max = String(Math.ceil(player.length_us / 1000));
    if (document.activeElement !== this.bar || player.playing) this.bar.value = String(Math.round(player.t_us / 1000));
    this.bar.setAttribute("aria-valuetext", time_words(player.t_us));
    this.time.textContent = `${time_words(player.t_us)} / ${time_words(player.length_us)}${player.growing ? " …" : ""}`;
    this.play.textContent = player.playing ? "❚❚" : "▶";
    this.mark();
  }

  /** Ticks at the events' times. */
  mark() {
    const key = `${this.world.events_version} ${this.player.length_us}`;
    if (key === this.marked || !this.player.length_us) return;
    this.marked = key;
    // those that fall together are one mark
    const places = new Set(this.world.events.map((event) => Math.round((1000 * event.t_us) / this.player.length_us)));
    this.marks.replaceChildren(...[...places].map((place) => {
      const tick = h("i");
      tick.style.left = `${place / 10}%`;
      return tick;
    }));
  }
}
