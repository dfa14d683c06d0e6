// The keyboard: one table of keys, which the help shows too.
import { h, table } from "../dom.js";

/** Where the browser keeps whether single keys act. */
const setting = "arkmesh.keys";

/** @typedef {{keys: string[], words: string, act: () => void}} Binding keys: as KeyboardEvent.key tells, letters small */

export class Keys {
  /** @param {Binding[]} bindings */
  constructor(bindings) {
    this.bindings = bindings;
    this.on = h("input", { type: "checkbox", id: "keys-on", onchange: () => localStorage.setItem(setting, this.on.checked ? "on" : "off") });
    this.on.checked = localStorage.getItem(setting) !== "off";
    this.dialog = h("dialog", { "aria-label": "keys" }, table(["key", "what it does"], bindings.map((b) => [b.keys.map((k) => (k === " " ? "Space" : k.length === 1 ? k.toUpperCase() : k)).join(", "), b.words])),
      h("p", {}, this.on, " ", h("label", { for: "keys-on" }, "single keys work even when another element has the focus")),
      h("form", { method: "dialog" }, h("button", {}, "close")));
    document.body.append(this.dialog);
    document.addEventListener("keydown", (event) => this.pressed(event));
  }

  help() {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }

  /** @param {KeyboardEvent} event */
  pressed(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !this.on.checked) return;
    const target = /** @type {HTMLElement} */ (event.target);
    // Letters choose in a list; STOP is STOP everywhere.
    if (target.tagName === "SELECT" && event.key.toLowerCase() !== "s") return;
    // Space and Enter press the button that has the focus.
    if (/^(BUTTON|SUMMARY)$/.test(target.tagName) && (event.key === " " || event.key === "Enter")) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const binding = this.bindings.find((b) => b.keys.includes(key));
    if (!binding || event.repeat && /^[a-z]$/.test(key)) return;
    event.preventDefault();
    binding.act();
  }
}
