// Makes elements: h("button", {class: "stop", onclick: f}, "STOP"). Texts are always texts, never HTML.

/** @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, any>} [attributes] on... are listeners, booleans are set or left out
 * @param {...(Node | string | number | null | undefined | false)} children
 * @returns {HTMLElementTagNameMap[T]} */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((c) => c !== null && c !== undefined && c !== false).map((c) => (typeof c === "number" ? String(c) : /** @type {Node | string} */ (c))));
  return element;
}

/** Gives a place these children, and changes only what differs: texts that somebody selects stay selected, and what has the focus keeps it.
 * Listeners of elements that stay are those of before.
 * @param {Element} place @param {...(Node | string | null | undefined | false)} children */
export function patch(place, ...children) {
  const wanted = children.filter((c) => c !== null && c !== undefined && c !== false).map((c) => (typeof c === "string" ? document.createTextNode(c) : /** @type {Node} */ (c)));
  wanted.forEach((node, i) => {
    const old = place.childNodes[i];
    if (!old) place.append(node);
    else if (old.nodeName !== node.nodeName) old.replaceWith(node);
    else if (old instanceof Text) old.data !== node.textContent && (old.data = node.textContent ?? "");
    else if (old instanceof Element && node instanceof Element) {
      for (const { name } of [...old.attributes]) if (!node.hasAttribute(name)) old.removeAttribute(name);
      for (const { name, value } of node.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value);
      patch(old, ...node.childNodes);
    }
  });
  while (place.childNodes.length > wanted.length) place.lastChild?.remove();
}

/** A name that may be broken behind its dots, lines and colons, and nowhere else.
 * @param {string} name */
export function breakable(name) {
  return h("span", {}, ...name.split(/(?<=[./:_])/).flatMap((part, i) => (i ? [h("wbr"), part] : [part])));
}

/** A table: its head, and rows of texts or nodes.
 * @param {string[]} head @param {(string | number | Node)[][]} rows the first of each row is a name, the others are not broken */
export function table(head, rows) {
  return h("table", {}, h("thead", {}, h("tr", {}, ...head.map((t) => h("th", { scope: "col" }, t)))),
    h("tbody", {}, ...rows.map((row) => h("tr", {}, ...row.map((cell, i) => h("td", {}, i || typeof cell !== "string" ? cell : breakable(cell)))))));
}

/** Names and values, one a line.
 * @param {[string, string | Node][]} pairs */
export function facts(pairs) {
  return h("dl", {}, ...pairs.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
}

/** A part of the side column that can be folded.
 * @param {string} title @param {boolean} open */
export function section(title, open) {
  const body = h("div", { class: "body" });
  const element = h("details", { open }, h("summary", {}, title), body);
  return { element, body };
}
