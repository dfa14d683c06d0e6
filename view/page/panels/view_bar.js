// What is shown and what a drag does.
import { h } from "../dom.js";

/** @type {[keyof import("../draw/scene.js").Shown, string][]} */
const layers = [["labels", "ids"], ["trails", "trails"], ["ghosts", "ghosts"], ["overlay", "scenario"], ["pictures", "camera"]];
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
    const button = (/** @type {string} */ words, /** @type {string} */ title, /** @type {() => void} */ onclick) => h("button", { title, "aria-label": title, onclick }, words);
    this.element = h("div", { class: "view", role: "toolbar", "aria-label": "what is shown" },
      this.mode, button("⤢ all", "Show everything (0)", () => pointer.fit()), button("+", "Closer (+)", () => pointer.zoom(1.4)), button("−", "Further (−)", () => pointer.zoom(1 / 1.4)),
      this.follow, ...this.tools, ...this.layers, button("?", "Keys (?)", help));
  }

  /** @param {boolean} several @param {boolean} hand robots may be moved */
  update(several, hand) {
    this.mode.hidden = !several;
    this.tools[2].hidden = !hand;
    if (this.version === this.options.version) return;
    this.version = this.options.version;
    const { mode, tool, shown, follow } = this.options;
    this.mode.textContent = mode === "side" ? "▣▣ side by side" : "▣ together";
    this.follow.setAttribute("aria-pressed", String(follow));
    this.tools.forEach((b, i) => b.setAttribute("aria-pressed", String(tools[i][0] === tool)));
    this.layers.forEach((b, i) => b.setAttribute("aria-pressed", String(shown[layers[i][0]])));
  }
}
