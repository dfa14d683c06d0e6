// The address bar holds what is shown: run, time, picked robot, layers. Whoever opens the address, or loads it again, sees the same.

export class Address {
  /** @param {import("./options.js").Options} options @param {import("../play/player.js").Player} player @param {import("../world/world.js").World} world */
  constructor(options, player, world) {
    this.options = options;
    this.player = player;
    this.world = world;
    /** @type {URLSearchParams | null} What it said when the page was opened; null once it was heeded. */
    this.asked = new URLSearchParams(location.hash.slice(1));
  }

  /** Shows what the address asked for, once the labs are known. */
  restore() {
    const { asked, options } = this;
    if (!asked) return;
    this.asked = null;
    const layers = asked.get("layers")?.split(",");
    if (layers) options.set({ shown: /** @type {any} */ (Object.fromEntries(Object.keys(options.shown).map((name) => [name, layers.includes(name)]))) });
    if (asked.get("mode") === "together") options.set({ mode: "together" });
    const [, lab, id] = /^(.+)[/](\d+)$/.exec(asked.get("robot") ?? "") ?? [];
    if (lab) options.set({ pick: { lab, id: Number(id) } });
    const t_s = Number(asked.get("t") ?? NaN);
    if (this.world.about.mode === "recorded" && t_s >= 0) void this.player.seek(t_s * 1e6);
  }

  save() {
    const { options, world } = this;
    if (this.asked) return;
    const said = new URLSearchParams();
    if (world.about.mode === "recorded" && !this.player.playing) said.set("t", (this.player.t_us / 1e6).toFixed(1));
    if (options.pick) said.set("robot", `${options.pick.lab}/${options.pick.id}`);
    if (options.mode === "together") said.set("mode", "together");
    const on = Object.entries(options.shown).filter(([, shown]) => shown).map(([name]) => name);
    if (on.length < Object.keys(options.shown).length) said.set("layers", on.join(","));
    const hash = said.toString().replaceAll("%2F", "/").replaceAll("%2C", ",");
    if (hash !== location.hash.slice(1)) history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
  }
}
