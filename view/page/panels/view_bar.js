// What is shown and what a drag does.
import { h } from "../dom.js";

/** @type {[keyof import("../draw/scene.js").Shown, string][]} */
const layers = [["labels", "ids"], ["ghosts", "ghosts"], ["overlay", "scenario"], ["pictures", "camera"]];
/** Lengths of trails, seconds of lab time. */
const trails_s = [10, 30, 120, 600];
/** @type {["look"|"measure"|"hand", string, string][]} */
const tools = [["look", "✥ look", "A drag moves the view (L)"], ["measure", "⟷ measure", "A drag measures a distance (M)"], ["hand", "↷ move robots", "A drag moves a robot (H)"]];

export class ViewBar {
  /** @param {import("../stage/options.js").Options} options @param {import("../stage/pointer.js").Pointer} pointer @param {() => void} help */
  constructor(options, pointer, help) {
    this.options = options;
    this.version = -1;
    this.mode = h("button", { title: "Side by side, or all in the shared frame (T)", onclick: () => options.set({ mode: options.mode === "side" ? "together" : "side", ruler: null }) });
    this.follow = h("button", { title: "Keep the picked robot in the middle (F)", onclick: () => options.set({ follow: !options.follow }) }, "follow");
    this.tools = tools.map(([tool, words, title]) => h("button", { title, id: `tool-${tool}`, onclick: () => options.set({ tool, ruler: null }) }, words));
    this.layers = layers.map(([layer, words]) => h("button", { onclick: () => options.toggle(layer) }, words));
    this.trails = h("select", { "aria-label": "trails", title: "Length of the trails", onchange: () => options.set({ shown: { ...options.shown, trails: this.trails.value !== "0" }, trail_s: Number(this.trails.value) || options.trail_s }) },
      h("option", { value: 0 }, "no trails"), ...trails_s.map((s) => h("option", { value: s }, s < 60 ? `trails ${s} s` : `trails ${s / 60} min`)));
    const button = (/** @type {string} */ words, /** @type {string} */ title, /** @type {() => void} */ onclick) => h("button", { title, "aria-label": /[a-z]/.test(words) ? undefined : title, onclick }, words);
    this.element = h("div", { class: "view", role: "toolbar", "aria-label": "what is shown" },
      this.mode, button("⤢ all", "Show everything (0)", () => pointer.fit()), button("+", "Closer (+)", () => pointer.zoom(1.4)), button("−", "Further (−)", () => pointer.zoom(1 / 1.4)),
      this.follow, ...this.tools, ...this.layers, this.trails, h("button", { id: "help", title: "Keys (?)", "aria-label": "Keys (?)", onclick: help }, "?"));
  }

  /** What does nothing here is not shown.
   * @param {import("../world/lab.js").Lab[]} labs @param {boolean} hand robots may be moved */
  update(labs, hand) {
    this.mode.hidden = labs.length < 2;
    this.tools[2].hidden = !hand;
    this.follow.hidden = !this.options.pick;
    const there = { ghosts: labs.some((lab) => lab.ghosts.length), overlay: labs.some((lab) => lab.overlay), pictures: labs.some((lab) => lab.cameras.length) };
    this.layers.forEach((b, i) => (b.hidden = there[/** @type {"ghosts"} */ (layers[i][0])] === false));
    if (this.version === this.options.version) return;
    this.version = this.options.version;
    const { mode, tool, shown, follow, trail_s } = this.options;
    this.trails.value = String(shown.trails ? trail_s : 0);
    this.mode.textContent = mode === "side" ? "▣▣ side by side" : "▣ together";
    this.follow.setAttribute("aria-pressed", String(follow));
    this.tools.forEach((b, i) => b.setAttribute("aria-pressed", String(tools[i][0] === tool)));
    this.layers.forEach((b, i) => b.setAttribute("aria-pressed", String(shown[layers[i][0]])));
  }
}
