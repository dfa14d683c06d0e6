// The page's modules that need no browser: bytes to messages, places, views, trails, playing.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import test from "node:test";
import { DecodeError, Types } from "../../view/page/wire/lcm.js";
import { Lab } from "../../view/page/world/lab.js";
import { Discs, Places, place_beside, place_label, sites_of } from "../../view/page/draw/label_place.js";
import { Panes } from "../../view/page/stage/panes.js";
import { Placement, projection } from "../../view/page/world/placement.js";
import { Player } from "../../view/page/play/player.js";
import { Trail, points_each, step_m } from "../../view/page/world/trail.js";
import { View } from "../../view/page/stage/view.js";
import { World } from "../../view/page/world/world.js";
import { align, named_curves, values_at } from "../../view/page/panels/counts.js";
import { describe } from "../../view/page/panels/channels.js";
import { grid_of } from "../../view/page/panels/batch_table.js";
import { legend_of } from "../../view/page/panels/legend.js";
import { gate_words, lab_words } from "../../view/page/panels/clock.js";
import { differences } from "../../view/page/panels/runs.js";
import { ended_words, silence_words } from "../../view/page/panels/notices.js";
import { kept_words, names, own_words, robots_words, standing_words } from "../../view/page/world/status.js";
import { order_words } from "../../view/page/panels/control_bar.js";
import { frames_in, parse_frame } from "../../view/page/wire/wire.js";
import { token_of } from "../../view/page/wire/token.js";
import { count_name, count_value, rate_words, time_words } from "../../view/page/words.js";

const types = new Types({
  types: {
    outer_t: {
      fingerprint: "0102030405060708",
      fields: [
        { name: "n", type: "int32_t" }, { name: "stamp", type: "int64_t" }, { name: "x", type: "double" }, { name: "name", type: "string" },
        { name: "inner", type: "inner_t", dims: ["n"] }, { name: "bytes", type: "byte", dims: ["2"] }, { name: "grid", type: "int16_t", dims: ["n", "2"] },
      ],
    },
    inner_t: { fingerprint: "1112131415161718", fields: [{ name: "m", type: "int32_t" }, { name: "values", type: "int8_t", dims: ["m"] }, { name: "on", type: "boolean" }] },
  },
});

/** Bytes of an outer_t with one inner_t, written by hand. */
const good = Uint8Array.from([
  1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 1, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfe, 0x3f, 0xf8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0xc3, 0xa4, 0,
  0, 0, 0, 2, 5, 0xfb, 1, 9, 200, 0, 7, 0xff, 0xff,
]);

test("a message written by hand is decoded, nested counts and signs too", () => {
  const { type, value } = types.decode(good);
  assert.equal(type, "outer_t");
  assert.deepEqual({ ...value, bytes: [...value.bytes] }, { n: 1, stamp: -2, x: 1.5, name: "ä", inner: [{ m: 2, values: [5, -5], on: true }], bytes: [9, 200], grid: [[7, -1]] });
  assert.match(describe(types, good), /inner\[0\]\n {2}m = 2/);
});

test("every shortened message, a long one, a huge count and a strange type are refused with words", () => {
  for (let length = 0; length < good.length; ++length) assert.throws(() => types.decode(good.slice(0, length)), DecodeError);
  assert.throws(() => types.decode(Uint8Array.from([...good, 0])), /1 byte too many/);
  const huge = good.slice();
  huge[8] = 0x7f;
  assert.throws(() => types.decode(huge), /more than its bytes can hold/);
  huge[8] = 0xff;
  assert.throws(() => types.decode(huge), /more than its bytes can hold/);
  assert.throws(() => types.decode(new Uint8Array(40)), /unknown to this server/);
  assert.equal(types.decode(good).value.n, 1, "and the next good one is read again");
});

/** The types of lcmtypes/, as the program tells them. */
function real_types() {
  const folder = mkdtempSync(`${tmpdir()}/types-`), root = new URL("../..", import.meta.url).pathname;
  try {
    execFileSync("python3", [`${root}/hal/layout/make_types.py`, `${root}/lcmtypes`, `${folder}/types.json`]);
    return JSON.parse(readFileSync(`${folder}/types.json`, "utf8"));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

test("random bytes of every type are refused or read, never anything else, and a lab takes what was read", () => {
  const json = real_types(), all = new Types(json), lab = new Lab(0, "a");
  const of_channel = Object.fromEntries(Object.entries(json.channels).map(([channel, type]) => [type, channel]));
  let seed = 1, read = 0;
  const random = () => (seed = (Math.imul(seed, 1103515245) + 12345) >>> 0) >>> 16;
  for (const [name, type] of Object.entries(json.types)) {
    for (let i = 0; i < 400; ++i) {
      // Mostly zeros: counts are small then, and decoding gets far.
      const bytes = Uint8Array.from({ length: 8 + (random() % 300) }, () => (random() % 12 ? 0 : random() & 255));
      bytes.set(type.fingerprint.match(/../g).map((byte) => parseInt(byte, 16)));
      try {
        const value = all.decode(bytes).value;
        read += 1;
        lab.absorb(of_channel[name] ?? "", value, 0);
      } catch (error) {
        assert.ok(error instanceof DecodeError, `${name}: ${error.stack}`);
      }
    }
  }
  assert.ok(read > 0);
});

test("64 random bits stay exact", () => {
  const run = new Types({ types: { t: { fingerprint: "0000000000000001", fields: [{ name: "nonce", type: "int64_t" }] } } });
  assert.equal(run.decode(Uint8Array.from([0, 0, 0, 0, 0, 0, 0, 1, 0x25, 0x99, 1, 2, 3, 4, 5, 7])).value.nonce, 0x2599010203040507n);
});

test("a frame's head is little-endian, and what is no frame is none", () => {
  const bytes = Uint8Array.from([1, 2, 3, 0, 7, 0, 0, 0, 0x40, 0x42, 0x0f, 0, 0, 0, 0, 0, 97, 98, 99, 5, 6]);
  const frame = parse_frame(bytes.buffer);
  assert.deepEqual({ ...frame, data: [...frame.data] }, { kind: "message", lab: 2, request: 7, t_us: 1_000_000, channel: "abc", data: [5, 6] });
  assert.equal(parse_frame(bytes.buffer.slice(0, 18)), null);
  assert.equal(parse_frame(Uint8Array.from([9, ...bytes.slice(1)]).buffer), null);
  const bundle = [3, 0, 0, 0, bytes.length, 0, 0, 0, ...bytes, bytes.length, 0, 0, 0, ...bytes];
  const parts = frames_in(Uint8Array.from(bundle).buffer);
  assert.deepEqual(parts.map((part) => parse_frame(part)), [frame, frame]);
  assert.deepEqual(frames_in(bytes.buffer), [bytes.buffer]);
  assert.equal(parse_frame(frames_in(Uint8Array.from(bundle.slice(0, 12)).buffer)[0]), null, "one that is cut off");
});

test("placements: there and back, and one after another", () => {
  const p = new Placement(0.3, -0.2, 2, 0.7), screen = new Placement(400, 300, 500, 0, true);
  const there = { x: p.x(0.1, 0.25), y: p.y(0.1, 0.25) }, back = p.inverse(there.x, there.y);
  assert.ok(Math.hypot(back.x - 0.1, back.y - 0.25) < 1e-12);
  const joined = p.then(screen);
  assert.ok(Math.abs(joined.x(0.1, 0.25) - screen.x(there.x, there.y)) < 1e-9 && Math.abs(joined.y(0.1, 0.25) - screen.y(there.x, there.y)) < 1e-9);
  assert.ok(screen.y(0, 1) < screen.y(0, 0), "north is up");
});

test("zooming keeps the point under the pointer", () => {
  const view = new View(), pane = { x: 10, y: 20, width: 600, height: 400 };
  view.fit({ x: -0.5, y: -0.5, width: 1, height: 1 }, pane);
  const before = view.placement(pane).inverse(100, 90);
  view.zoom(3, 100, 90, pane);
  const after = view.placement(pane).inverse(100, 90);
  assert.ok(Math.hypot(before.x - after.x, before.y - after.y) < 1e-12);
});

const shared = (age_periods) => ({
  stamp_us: 4_000_000, period: 2, shift_x_m: 0, shift_y_m: 0, turn_rad: Math.PI / 2, scale: 2, n_labs: 2, labs: [
    { lab: "a", period: 2, age_periods: 0, robots: [], fields: [] },
    { lab: "b", period: 2, age_periods, robots: [{ robot: 5, x_um: 0, y_um: 1_000_000, heading_urad: 1_570_796, led: 2 }], fields: [] }],
});
const poses = (t_us, x, part = 0, parts = 1, robot = 0) => (
  { stamp_us: t_us, number: 0, part, parts, objects: [], robots: [{ robot, x_m: x, y_m: 0, heading_rad: 0, led: 1, confidence: 1, age_us: 0 }] });

test("ghosts lie where the inverse projection puts them, and grow old", () => {
  const lab = new Lab(0, "RUN/a");
  lab.absorb("shared", shared(1), 4_000_000);
  const [fleet] = lab.ghosts, [ghost] = fleet.robots;
  assert.ok(Math.abs(ghost.x - 0.5) < 1e-9 && Math.abs(ghost.y) < 1e-9 && Math.abs(ghost.heading) < 1e-5, JSON.stringify(ghost));
  assert.equal(fleet.age_us, 2_000_000);
  lab.absorb("poses", poses(5_500_000, 0), 5_500_000);
  assert.equal(lab.age_us(fleet), 3_500_000);
  assert.ok(Math.abs(projection(shared(0)).x(0.5, 0)) < 1e-12);
});

test("the parts of a frame make one fleet", () => {
  const lab = new Lab(0, "a");
  lab.absorb("poses", poses(0, 0.1, 0, 2, 1), 0);
  lab.absorb("poses", poses(0, 0.2, 1, 2, 2000), 0);
  assert.deepEqual(lab.robots.map((r) => r.id), [1, 2000]);
  for (const [part, parts] of [[0, 2 ** 31 - 1], [2, 2], [-1, 2], [0, 0]]) assert.throws(() => lab.absorb("poses", poses(0, 0, part, parts), 0), DecodeError);
});

test("a trail tells what came since a time, also when its oldest points are gone", () => {
  const trail = new Trail(4);
  for (let i = 0; i < 6; ++i) trail.add(i * 2 * step_m, 0, i * 1000); // serial numbers 2 to 5 are kept
  assert.deepEqual([0, 2000, 2001, 4500, 5000, 5001].map((t) => trail.since(t)), [2, 2, 3, 5, 5, 6]);
});

test("a trail keeps the newest points, and only steps that can be seen", () => {
  const trail = new Trail(3);
  for (let i = 0; i < 5; ++i) assert.ok(trail.add(i * 2 * step_m, 0, i));
  assert.ok(!trail.add(8 * step_m + step_m / 2, 0, 9));
  assert.equal(trail.first, 2);
  assert.ok(points_each(1000) * 1000 <= 12_000 && points_each(1) === 240);
});

test("what the page cannot read is counted with its reason, and breaks nothing", () => {
  const world = new World(types);
  world.introduce({ version: "", mode: "live", labs: ["a"], control: false, run: "" });
  const frame = (lab, channel, data) => ({ kind: "message", lab, request: 0, t_us: 0, channel, data });
  assert.equal(world.take(frame(3, "poses", good)), false);
  assert.equal(world.take(frame(0, "poses", good.slice(0, 20))), false);
  assert.equal(world.take(frame(0, "unheard", good.slice(0, 20))), false);
  assert.deepEqual([...world.not_understood.values()], [1, 1]);
});

test("what the page cannot read takes no more room the longer it goes on, and every message counts", () => {
  const world = new World(types);
  world.introduce({ version: "", mode: "live", labs: ["a"], control: false, run: "" });
  for (let i = 0; i < 5000; ++i) world.take({ kind: "message", lab: 1 + i, request: 0, t_us: 0, channel: "poses", data: good });
  world.take({ kind: "message", lab: 1, request: 0, t_us: 0, channel: "poses", data: good });
  assert.equal(world.not_understood.size, 101);
  assert.equal(world.not_understood.get("there is no lab 1 among 1"), 2);
  assert.equal(world.not_understood.get("other reasons"), 4900);
});

test("what a robot was told, alone and with all others, the newest first; a former batch has words only", () => {
  const lab = new Lab(0, "a");
  for (const stamp_us of [5, 5, 6]) lab.take_texts({ stamp_us, n_lost: 0, texts: [{ robot: 4, at_us: 1, text: `at ${stamp_us}\n` }] });
  assert.equal(lab.texts.get(4), "at 5\nat 6\n"); // the newest may come twice
  lab.take_told({ stamp_us: 1, messages: [{ robot: 2, slot: 0, kind: 1, value: 70000 }] });
  lab.take_told({ stamp_us: 2, messages: [], whole: [{ robot: -1, slot: 3, type: 9, data: [0, -1, 16, 0, 0, 0, 0, 0, 7] }] });
  lab.take_told({ stamp_us: 3, messages: [{ robot: 5, slot: 0, kind: 0, value: 0 }], whole: [{ robot: 2, slot: 1, type: 0, data: [1, 2, 3, 4, 5, 6, 7, 8, 9] }] });
  assert.deepEqual(lab.told_to(2).map((told) => [told.t_us, told.slot, told.kind, told.value]), [
    [3, 1, "message of type 0", "01 02 03 04 05 06 07 08 09"], [2, 3, "message of type 9", "00 ff 10 00 00 00 00 00 07"], [1, 0, "1", "70000"]]);
  assert.deepEqual(lab.told_to(5).map((told) => told.t_us), [3, 2]);
  assert.deepEqual(lab.told_to(1).map((told) => told.t_us), [2]);
});

test("after a new connection to the same labs robots stay and events are told anew; other labs begin anew", () => {
  const world = new World(types), about = { version: "", mode: "live", labs: ["a"], control: false, run: "" };
  world.introduce(about);
  world.labs[0].absorb("poses", poses(0, 0.1), 0);
  world.tell([{ t_us: 0, lab: 0, kind: "", text: "x" }]);
  world.introduce({ ...about, control: true });
  assert.deepEqual([world.labs[0].robots.length, world.events.length, world.about.control], [1, 0, true]);
  world.introduce({ ...about, labs: ["b"] });
  assert.equal(world.labs[0].robots.length, 0);
});

test("panes: side by side as large as may be, or one", () => {
  const panes = new Panes(), labs = [new Lab(0, "a"), new Lab(1, "b")];
  panes.arrange(labs, "side", 1000, 500, 1);
  assert.deepEqual(panes.list.map((p) => p.rectangle.x), [0, 500]);
  panes.arrange(labs, "side", 400, 900, 1);
  assert.deepEqual(panes.list.map((p) => p.rectangle.y), [0, 450]);
  panes.arrange(labs, "together", 400, 900, 1);
  assert.equal(panes.list.length, 1);
  assert.equal(panes.at(5, 5)?.key, "together");
});

/** A player on a run of which every 100 ms hold one frame; answers at once. */
function played(length_us) {
  const shown = [], sent = [];
  const player = new Player({ send: (m) => Boolean(sent.push(m)), show: (f) => shown.push(f.t_us), jumped: () => shown.push("jump") });
  player.introduce(length_us, false);
  const answer = () => {
    for (const m of sent.splice(0)) {
      const frame = (t_us) => player.take({ kind: "message", lab: 0, request: m.request, t_us, channel: "poses", data: new Uint8Array() });
      if (m.seek) frame(Math.floor(m.seek.t_us / 1e5) * 1e5);
      let last = -1;
      for (let k = 0; k < (m.frames?.count ?? 0); ++k) {
        const t = Math.floor((m.frames.from_us + k * m.frames.step_us) / 1e5) * 1e5;
        if (t > m.frames.from_us - m.frames.step_us && t !== last && t <= length_us) frame((last = t));
      }
      player.done({ request: m.request });
    }
  };
  return { player, shown, sent, answer };
}

test("a recorded run plays at its speed, in order, and stops at its end", () => {
  const { player, shown, answer } = played(3_000_000);
  player.seek(0);
  answer();
  player.set_speed(2);
  player.play(true);
  for (let ms = 16; player.playing && ms < 5000; ms += 16) {
    player.tick(ms);
    answer();
  }
  assert.equal(player.t_us, 3_000_000);
  assert.deepEqual(shown.slice(0, 2), ["jump", 0]);
  const times = shown.slice(2);
  assert.deepEqual(times, Array.from({ length: times.length }, (_, i) => (i + times[0] / 1e5) * 1e5));
  assert.equal(times.at(-1), 3_000_000);
});

test("answers to what was asked before a jump are dropped", () => {
  const { player, shown, sent, answer } = played(60_000_000);
  player.seek(1_000_000);
  const old = sent[0].request;
  player.seek(30_000_000);
  player.take({ kind: "message", lab: 0, request: old, t_us: 1_000_000, channel: "poses", data: new Uint8Array() });
  answer();
  assert.deepEqual(shown, ["jump", "jump", 30_000_000]);
});

test("time waits for what is on its way", () => {
  const { player, answer } = played(60_000_000);
  player.seek(0);
  answer();
  player.play(true);
  for (let ms = 16; ms < 3000; ms += 16) player.tick(ms);
  assert.ok(player.t_us < 1_000_000, `${player.t_us}`);
});

test("at its end a run that grows goes on when more has come", () => {
  const { player, sent, answer } = played(1_000_000);
  player.introduce(1_000_000, true);
  player.seek(900_000);
  answer();
  player.play(true);
  let ms = 16;
  for (; ms < 3000; ms += 16) {
    player.tick(ms);
    const last = sent.at(-1);
    if (last?.seek) player.done({ request: sent.pop().request, length_us: 2_000_000, growing: false });
    answer();
  }
  assert.equal(player.t_us, 2_000_000);
  assert.equal(player.playing, false);
});

test("a count's name gives its unit", () => {
  const words = (name, n) => `${count_name(name).words} ${count_value(name, n)}`;
  assert.equal(words("flying.south_ppm", 975_000), "flying south 97.5 %");
  assert.equal(words("consensus.ms", 58_000), "consensus 58.0 s");
  assert.equal(words("ground.followed_ms", 190_060), "ground followed 190.1 s");
  assert.equal(words("sent_bytes", 1500), "sent 1.5 kB");
  assert.equal(words("harvested.south", 1200), "harvested south 1\u2009200");
  assert.equal(words("ms", 3), "ms 3");
});

test("curves that scenarios name come first, in their order, then none; without any, the first; never more than six", () => {
  const names = (lab, columns, parted) => columns.map((column) => `${lab}${parted}${column}`);
  const columns = Array.from({ length: 17 }, (_, i) => `swarms.c${i}`), tells = (name, ...of) => ({ name, shown: of.map((each) => ({ of: `series.${each}`, curve: true })) });
  const all = [...names("a", columns, "."), ...names("a-b", columns, " ")];
  assert.deepEqual(named_curves(all, [tells("a", "swarms.c9", "swarms.c2"), tells("a-b", "swarms.c9")]), ["a.swarms.c9", "a-b swarms.c9", "a.swarms.c2", "a-b swarms.c2"]);
  assert.deepEqual(named_curves(all, [tells("a", ...columns)]).length, 6);
  assert.deepEqual(named_curves(all, [{ name: "a", shown: [{ of: "series.swarms.c3", curve: false }] }, tells("a-b", "nothing")]), names("a", columns.slice(0, 6), "."));
});

test("a batch's table is a grid of settings by seeds; results are its columns of numbers", () => {
  const columns = ["run", "setting", "scenario.x.reach", "arena.robots", "seed", "state", "why", "final_hash", "trips", "words", "periods"];
  const row = (run, cells) => ({ run, cells });
  const rows = [row(0, ["0", "0", "0.1", "5", "1", "finished", "", "ab", "3", "", "9"]), row(null, ["1", "0", "0.1", "5", "7", "failed", "why", "", "", "", ""]), row(1, ["2", "1", "0.2", "5", "1", "finished", "", "cd", "4", "x", "9"])];
  const { names, seeds, rows: found, results } = grid_of({ name: "b", columns, factors: 2, rows });
  assert.deepEqual([names, seeds, results], [["scenario.x.reach", "arena.robots"], ["1", "7"], ["trips"]]);
  assert.deepEqual(found.map(({ settings, runs }) => [settings, [...runs].map(([seed, { run }]) => [seed, run])]), [[["0.1", "5"], [["1", 0], ["7", null]]], [["0.2", "5"], [["1", 1]]]]);
});

test("a legend has what is drawn, and LEDs that the scenario explains, in its words, else in those of the table", () => {
  const table = { colours: { site_hard: { means: "hard" }, resource: { means: "food" }, note: { means: "notes" }, other: { means: "others" } } };
  const shown = [{ of: "led.4", words: "walks" }, { of: "colour.site_hard", words: "hard 0/1 + 4/2" }, { of: "colour.other", words: "not drawn" }, { of: "series.x", words: "no mark" }];
  const overlay = { rasters: [], polygons: [], circles: [{ colour: "site_hard" }, { colour: "resource" }], lines: [{ colour: "of a newer version" }], texts: [] };
  assert.deepEqual(legend_of([{ shown: [], overlay: null }, { shown, overlay }], table).map(({ of, words }) => `${of}: ${words}`),
    ["led.4: walks", "colour.site_hard: hard 0/1 + 4/2", "colour.resource: food", "colour.note: notes"]);
  assert.deepEqual(legend_of([{ shown: [], overlay: null }], table), []);
});

test("labels that would lie on each other go up, as far as there is room", () => {
  const places = new Places(), y_of = (x, y) => place_label(places, null, { x, y, width: 95, height: 13.2 })?.y;
  assert.equal(y_of(100, 50), 50);
  assert.equal(y_of(166, 50), 50 - 13.2);
  assert.equal(y_of(232, 50), 50);
  assert.equal(y_of(100, 64), 64, "a line lower is room enough");
  assert.deepEqual([2, 3].map(() => y_of(100, 50)), [50 - 2 * 13.2, 50 - 3 * 13.2]);
  assert.equal(y_of(100, 50), undefined, "no room");
  const sites = new Discs([{ x: 400, y: 50, radius: 20 }]);
  const box = (y) => ({ x: 400, y, width: 95, height: 13.2 });
  assert.equal(place_label(places, sites, box(50), box(80)).y, 80, "not on a site");
  const circle = (radius_m, of) => ({ x_m: 0, y_m: 0, radius_m, label: "", dashed: false, ...of }), p = { scale: 1e6, x: (x) => x, y: (x, y) => y };
  const free = (...circles) => sites_of(circles, p).is_free({ x: 0, y: -2e5, width: 95, height: 13.2 });
  assert.equal(free(circle(0.5), circle(0.05, { label: "task" })), true, "what surrounds a labelled circle is none");
  assert.equal(free(circle(0.5, { label: "nest" }), circle(0.05)), false);
  assert.equal(free(circle(0.5, { dashed: true }), circle(0.6, { label: "nest", x_m: 9e6 })), true, "dashed ones without a label are none");
});

test("a robot's label lies beside it, on nothing else, and nowhere when there is no room", () => {
  const places = new Places(), beside = (x, y, more = null) => place_beside(places, more, x, y, 10, 18, 8);
  places.add_disc(100, 100, 10);
  assert.deepEqual(beside(100, 100), { x: 100, y: 85, width: 18, height: 8 });
  assert.deepEqual(beside(100, 100), { x: 100, y: 115, width: 18, height: 8 }, "above it is taken");
  places.add_disc(130, 100, 10);
  assert.deepEqual(beside(100, 100), { x: 80, y: 100, width: 18, height: 8 }, "at its right is another robot");
  const ghosts = new Places();
  ghosts.add_disc(500, 100, 60);
  assert.equal(beside(500, 100, ghosts), null);
  assert.equal(beside(500, 100).y, 85);
  // 50 robots in half a square metre at 600 pixels a metre, by a fixed sequence: no label meets another or a body, and nearly all have one.
  let seed = 1;
  const next = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
  const crowd = new Places(), robots = Array.from({ length: 50 }, () => ({ x: 424 * next(), y: 424 * next() }));
  for (const { x, y } of robots) crowd.add_disc(x, y, 10);
  const boxes = robots.map(({ x, y }) => place_beside(crowd, null, x, y, 10, 13, 8)).filter(Boolean);
  assert.ok(boxes.length >= 45, `${boxes.length}`);
  boxes.forEach((a, i) => {
    for (const b of boxes.slice(i + 1)) assert.ok(Math.abs(a.x - b.x) >= 13 || Math.abs(a.y - b.y) >= 7.5);
    for (const { x, y } of robots) assert.ok(Math.hypot(Math.max(0, Math.abs(a.x - x) - 6.5), Math.max(0, Math.abs(a.y - y) - 4)) >= 10 - 1e-9);
  });
});

test("words and small things", () => {
  assert.deepEqual([0, 0.02, 16, 679.4, 13_612.5].map(rate_words), ["0", "0.02", "16.0", "679", "13\u2009613"]);
  assert.equal(time_words(3_723_450_000), "1:02:03.4");
  assert.equal(time_words(260_400_000), "4:20.4");
  assert.equal(token_of("#token=ab12"), "ab12");
  assert.equal(token_of(""), "");
  const at = (x) => ({ robots: [{ id: 1, x: 0, y: 0 }, { id: 2, x, y: 0 }] });
  assert.match(differences(at(0), at(0.25)), /^1 robot differs in position; largest differences: 2 by 250 mm$/);
  assert.deepEqual(align([{ t_s: [0, 2], y: [1, 2] }, { t_s: [1], y: [5] }]), [[0, 1, 2], [1, null, 2], [null, 5, null]]);
});

/** A status of this version: an experiment that goes on, as far as nothing else is said. */
const status = (more = {}) => (
  { lab: "shark", phase: 2, outcome: 0, state: "running", wanted: 0, kept_still: "", n_not_standing: 0, not_standing: [], stamp_us: 5e6, period: 2, last_period: 9, speed: 1, can_wait: false, n_counters: 0, counters: [], ...more });
const unseen = [{ robot: 3, why: 3 }, { robot: 17, why: 2 }, { robot: 40, why: 3 }];
const paused = (more = {}) => status({ wanted: 1, kept_still: "operator", state: "running, with its robots paused by the operator", ...more });

test("names of phases, outcomes and reasons are those of lcmtypes/", () => {
  const { types: told } = real_types(), constants = { ...told.lab_status_t.constants, ...told.not_standing_t.constants };
  for (const list of Object.values(names)) list.forEach((name, value) => assert.equal(constants[name], value, name));
  assert.equal(Object.values(names).flat().length, Object.keys(constants).length);
});

test("robots are named as the lab names them", () => {
  assert.equal(robots_words([4, 7, 8, 9, 11, 12]), "4, 7-9, 11, 12");
  assert.equal(robots_words(Array.from({ length: 20 }, (_, i) => 2 * i)), `${Array.from({ length: 12 }, (_, i) => 2 * i).join(", ")} and 8 more`);
});

test("whether robots stand is what cameras saw, never what was said", () => {
  assert.equal(standing_words(paused({ not_standing: unseen })), "robots told to stop; not seen standing: 17 (moving), 3, 40 (not in sight)");
  assert.equal(standing_words(paused()), "robots told to stop; all robots were seen standing");
  assert.equal(standing_words(status()), "");
  assert.equal(standing_words(status({ wanted: 2, not_standing: [{ robot: 1, why: 0 }, { robot: 2, why: 1 }] })), "robots told to sleep; not seen standing: 1 (not sent yet), 2 (still watched)");
  assert.match(standing_words(paused({ phase: 4, outcome: 3 })), /unknown after the failure/, "an arena that failed names nobody");
  assert.doesNotMatch(own_words(paused({ not_standing: unseen })), /paused/);
  assert.match(own_words(paused()), /paused by the operator/);
});

test("a banner stands while somebody keeps robots still in an experiment that goes on", () => {
  assert.equal(kept_words("shark", paused({ not_standing: unseen })), "shark: robots are held by the operator; lab time continues; robots told to stop; not seen standing: 17 (moving), 3, 40 (not in sight).");
  assert.match(kept_words("shark", paused({ kept_still: "lost peer", phase: 1 })), /by a lost peer; the lab waits/);
  for (const none of [status(), paused({ kept_still: "not begun" }), paused({ kept_still: "end" }), paused({ phase: 0 }), paused({ phase: 3, outcome: 2 }), null]) assert.equal(kept_words("shark", none), "");
});

test("a command was only said; what comes of it is told from statuses that are newer", () => {
  const lab = new Lab(0, "shark"), order = { name: "pause", refused: undefined, statuses: 0, took: false };
  const hear = (s) => {
    lab.absorb("status", s, 0);
    return order_words(order, lab);
  };
  assert.equal(hear(status()), "pause: sent");
  Object.assign(order, { refused: "", statuses: lab.statuses });
  assert.equal(order_words(order, lab), "pause: accepted");
  assert.equal(hear(status()), "pause: accepted", "it may be from before");
  assert.equal(hear(paused({ not_standing: unseen })), "pause: accepted; robots told to stop; not seen standing: 17 (moving), 3, 40 (not in sight)");
  assert.equal(hear(paused()), "pause: accepted; robots told to stop; all robots were seen standing");
  assert.equal(hear(status()), "pause: accepted; robots have since been told to run");
  const reset = { name: "reset", refused: "", statuses: lab.statuses, took: false };
  lab.absorb("status", paused(), 0);
  assert.equal(order_words(reset, lab), "reset: accepted; robots told to stop", "that they stood may be from before the reset");
  lab.absorb("status", paused(), 0);
  assert.match(order_words(reset, lab), /all robots were seen standing/);
  lab.absorb("status", paused({ phase: 3, outcome: 2, kept_still: "end" }), 0);
  assert.match(order_words({ name: "stop", refused: "", statuses: lab.statuses - 1, took: false }, lab), /all robots were seen standing/);
  const resume = { name: "resume", refused: "", statuses: 0, took: false };
  lab.absorb("status", paused({ kept_still: "safety" }), 0);
  assert.equal(order_words(resume, lab), "resume: accepted; robots are still held by safety");
  lab.absorb("status", status(), 0);
  assert.equal(order_words(resume, lab), "resume: accepted; robots told to run");
  assert.equal(order_words({ name: "arm", refused: "no", statuses: 0, took: false }, lab), "arm was refused: no");
});

test("of a recorded run that has begun the panel does not say that it is starting", () => {
  const lab = new Lab(0, "shark");
  lab.absorb("status", status({ stamp_us: 0, phase: 0, state: "starting", speed: 0 }), 0);
  assert.equal(lab_words(lab, true).says, "at 0:00.0: starting");
  lab.absorb("shared", { ...shared(0), stamp_us: 300_000_000, period: 150 }, 300_000_000);
  assert.deepEqual([lab_words(lab, true).says, lab_words(lab, true).speed], ["", ""]);
});

test("the gate is told from phase and outcome, not from sentences", () => {
  assert.equal(gate_words(status({ phase: 1, state: "waiting for roark: link down" })), "◔ waiting for roark: link down");
  assert.match(gate_words(status({ state: "anything" })), /^▶ running$/);
  assert.match(gate_words(paused({ not_standing: unseen })), /^❚❚ robots told to stop by the operator; lab time continues; .* not seen standing: 17/);
  assert.match(gate_words(paused({ phase: 4, outcome: 2, kept_still: "end" })), /^■ ended: stopped; .*seen standing$/);
});

test("of a recorded run the panel tells the period of the moment that is shown, and when the lab said what it says", () => {
  const lab = new Lab(0, "shark");
  lab.absorb("status", status({ stamp_us: 260_400_000, period: 130, last_period: 300, speed: 87.5 }), 260_400_000);
  lab.absorb("shared", { ...shared(0), stamp_us: 300_000_000, period: 150 }, 300_000_000);
  assert.deepEqual(lab_words(lab, true), { time: "5:00.0", period: "150 of 300", speed: "87.5×", arena: "", says: "", attention: false });
  lab.absorb("status", status({ stamp_us: 260_400_000, period: 130, last_period: 300, speed: 87.5, phase: 1, state: "waiting for roark" }), 260_400_000);
  assert.equal(lab_words(lab, true).says, "at 4:20.4: waiting for roark");
  assert.equal(lab_words(new Lab(0, "shark"), true).says, "");
  lab.absorb("status", status({ stamp_us: 260_400_000, period: 130, last_period: 300, speed: 87.5 }), 260_400_000);
  const live = lab_words(lab, false);
  assert.deepEqual([live.period, live.speed, live.says], ["130 of 300", "87.5×", "▶ running"]);
  assert.deepEqual(values_at([{ name: "shark.a.b", t_s: [0, 10, 20], y: [0, 1, 2] }, { name: "shark.c", t_s: [30], y: [1] }], 19.9, ["roark", "shark"]), [{ lab: "shark", name: "a.b", n: 1 }]);
});

test("a page that hears nothing for 3 s says so, and of labs that have ended their end", () => {
  const world = new World(types), open = { open: true, why: "", heard_ms: 10_000 };
  world.introduce({ version: "", mode: "live", labs: ["shark", "roark"], control: true, run: "runs/a b", folder: "runs/a b" });
  assert.equal(silence_words(world, open, 12_999), "");
  assert.equal(silence_words(world, open, 13_000), "Nothing received from this page's server for 3 s. This view is out of date.");
  world.labs.forEach((lab) => (lab.heard_ms = 8_000));
  assert.match(silence_words(world, open, 12_500), /^Nothing received from shark, roark for 4 s/);
  world.labs[1].heard_ms = 12_000;
  assert.equal(silence_words(world, open, 12_500), "");
  const apart = { open: false, why: "the lab does not answer", heard_ms: 10_000 };
  assert.match(silence_words(world, apart, 10_000), /^Not connected: the lab does not answer. This view is out of date/);
  assert.deepEqual(ended_words(world), []);
  world.labs[0].absorb("status", paused({ phase: 4, outcome: 2, kept_still: "end", not_standing: unseen }), 0);
  assert.deepEqual(ended_words(world), ["shark: stopped; robots told to stop; not seen standing: 17 (moving), 3, 40 (not in sight)"]);
  world.labs[1].absorb("status", paused({ phase: 4, outcome: 2, kept_still: "end" }), 0);
  assert.equal(ended_words(world)[0], "ended; results in runs/a b; replay with arkmesh view 'runs/a b'");
  assert.equal(ended_words(world)[2], "roark: stopped; robots told to stop; all robots were seen standing");
  assert.match(silence_words(world, apart, 20_000), /the run and its program have ended/);
  const lost = "finished; 26 of 684 pairs in reach heard nothing of each other: why; or why";
  world.labs[1].absorb("status", paused({ phase: 4, outcome: 1, state: `${lost}; robots were told to stop; not seen standing: 3 (moving)` }), 0);
  assert.equal(ended_words(world)[2], `roark: ${lost}; robots told to stop; all robots were seen standing`);
  world.labs[1].absorb("status", paused({ phase: 4, outcome: 1, state: "finished" }), 0);
  assert.equal(ended_words(world)[2], "roark: finished; robots told to stop; all robots were seen standing");
});

test("a status of a former version is decoded by its own type and shown; what it does not say is unknown", () => {
  const json = real_types(), now = json.types.lab_status_t;
  const lacks = ["phase", "outcome", "wanted", "kept_still", "n_not_standing", "not_standing", "may_be_missing", "n_obeys", "obeys", "settings"];
  json.types["former.lab_status_t"] = { fingerprint: "00000000000000f1", fields: now.fields.filter((f) => !lacks.includes(f.name)) };
  const text = (s) => [0, 0, 0, s.length + 1, ...Buffer.from(s), 0];
  const bytes = Uint8Array.from([0, 0, 0, 0, 0, 0, 0, 0xf1, ...text("shark"), 0, 0, 0, 0, 0, 0, 0, 9, ...text("running"), 0, 0, 0, 0, 0, 0x4c, 0x4b, 0x40, 0, 0, 0, 2, 0, 0, 0, 9,
    0x3f, 0xf0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0]);
  const world = new World(new Types(json));
  world.introduce({ version: "", mode: "recorded", labs: ["shark"], control: false, run: "" });
  assert.equal(world.take({ kind: "message", lab: 0, request: 1, t_us: 5_000_000, channel: "status", data: bytes }), true, [...world.not_understood.keys()].join());
  const [lab] = world.labs;
  assert.deepEqual([lab.status.lab, lab.status.state, lab.status.period, "phase" in lab.status], ["shark", "running", 2, false]);
  assert.equal(gate_words(lab.status), "running");
  assert.equal(own_words(lab.status), "running");
  assert.deepEqual([standing_words(lab.status), kept_words("shark", lab.status), ended_words(world)], ["", "", []]);
  assert.equal(order_words({ name: "pause", refused: "", statuses: 0, took: false }, lab), "pause: accepted");
  assert.equal(new Types(json).decode(bytes).type, "former.lab_status_t");
});

test("the library is the one whose hashes stand beside it", () => {
  const folder = new URL("../../view/page/vendor/uplot/", import.meta.url);
  const rows = readFileSync(new URL("SHA256SUMS", folder), "utf8").trim().split("\n").map((row) => row.split(/\s+/));
  assert.equal(rows.length, 4);
  for (const [hash, name] of rows) assert.equal(createHash("sha256").update(readFileSync(new URL(name, folder))).digest("hex"), hash, name);
});

test("robots are as large as the arena tells, and Kilobots before it did", () => {
  const lab = new Lab(0, "a");
  assert.equal(lab.body_radius_m(), 0);
  lab.arena = { body_radius_m: 0.02 };
  assert.equal(lab.body_radius_m(), 0.02);
});
