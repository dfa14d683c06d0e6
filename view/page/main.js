// The page: makes its parts and joins them.
import { Address } from "./stage/address.js";
import { Connection } from "./wire/connection.js";
import { BatchGrid } from "./panels/batch_grid.js";
import { CameraPicture } from "./draw/camera_picture.js";
import { ChannelsPanel } from "./panels/channels.js";
import { ClockPanel } from "./panels/clock.js";
import { Colours } from "./draw/colours.js";
import { ControlBar } from "./panels/control_bar.js";
import { CountsPanel } from "./panels/counts.js";
import { EventsPanel } from "./panels/events.js";
import { FaultsPanel } from "./panels/faults.js";
import { Film } from "./play/film.js";
import { Keys } from "./stage/keys.js";
import { LegendPanel } from "./panels/legend.js";
import { LinksPanel } from "./panels/links.js";
import { Notices } from "./panels/notices.js";
import { Options } from "./stage/options.js";
import { Player } from "./play/player.js";
import { Pointer } from "./stage/pointer.js";
import { RobotPanel } from "./panels/robot.js";
import { RunsPanel } from "./panels/runs.js";
import { ScrubBar } from "./play/scrub_bar.js";
import { Stage } from "./stage/stage.js";
import { Types } from "./wire/lcm.js";
import { ViewBar } from "./panels/view_bar.js";
import { World } from "./world/world.js";
import { find } from "./draw/robots.js";
import { counted, time_words } from "./words.js";
import { redeem_token } from "./wire/token.js";

/** Panels are written so often, milliseconds. */
const panels_ms = 250;
/** A press of an arrow key moves the view so far, CSS pixels. */
const pan_px = 60;
/** The arenas alone, for films. */
const bare = new URLSearchParams(location.search).has("bare");
/** Points of the picked robot's path that are kept. */
const path_most = 5000;

/** @param {string} url */
async function fetch_json(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url} was answered with ${answer.status}`);
  return answer.json();
}

/** @param {string} id */
function place(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

await redeem_token();
const [types, colour_table] = await Promise.all([fetch_json("types.json"), fetch_json("page/colours.json")]);
const dark = matchMedia("(prefers-color-scheme: dark)");
const world = new World(new Types(types));
const options = new Options();
const stage = new Stage(place("stage"), world, options, new Colours(colour_table, dark.matches));
dark.addEventListener("change", () => {
  stage.recolour(new Colours(colour_table, dark.matches));
  counts.recolour();
});

const notices = new Notices(place("banner"));
place("banner").after(notices.kept, notices.ended);

/** @type {Connection} */
const connection = new Connection(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`, {
  frame: (frame) => (frame.request ? player.take(frame) : show(frame)),
  text: heard,
  any: () => notices.heard(performance.now()),
  state: connected,
});
/** @type {(message: object) => boolean} */
const send = (message) => connection.send(recorded() ? { run: world.about.number ?? 0, ...message } : message);
/** @type {Player} */
const player = new Player({ send, show, jumped: () => world.labs.forEach((lab) => lab.forget()) });
const control = new ControlBar(world, (message) => player.ask(message));
/** @type {(what: object, words: string) => void} */
const ask = (what, words) => void player.ask(what).then(({ answer }) => control.say(answer.refused ? `${words}: refused: ${answer.refused}` : `${words}${answer.text ? `: ${answer.text}` : ""}`));
const pointer = new Pointer(stage, options, (lab, robot, at) => ask({ move: { lab: lab.index, robot, x_m: at.x, y_m: at.y } }, `robot ${robot} moved`));
const view_bar = new ViewBar(options, pointer, () => keys.help());
const scrub = new ScrubBar(player, world);
const counts = new CountsPanel();
const recorded = () => world.about.mode === "recorded";
/** @type {RunsPanel} */
const runs = new RunsPanel(world, player, (about) => hello(about), () => grid.show());
const grid = new BatchGrid(world, stage, player, (run) => runs.open(run));
const panels = [runs, new ClockPanel(), new LegendPanel(stage), new RobotPanel(options, (lab, robot, line) => ask({ fault: { lab: lab.index, robot, line } }, `robot ${robot}: ${line}`), () => control.may),
  new FaultsPanel((lab, line) => ask({ fault: { lab: lab.index, line } }, line), () => control.may), counts, new LinksPanel(), new ChannelsPanel(),
  new EventsPanel((t_us) => recorded() && player.seek(t_us))];
place("bar").append(control.element, view_bar.element);
const address = new Address(options, player, world);
place("side").append(...panels.map((panel) => panel.element));
place("bottom").append(scrub.element);

/** @type {Keys} */
const keys = new Keys([
  { keys: ["s"], words: "STOP the robots of all labs", act: () => control.stop() },
  { keys: ["p"], words: "pause the robots", act: () => control.command("pause") },
  { keys: ["r"], words: "resume", act: () => control.command("resume") },
  { keys: [" "], words: "play or pause a recorded run", act: () => recorded() && player.play(!player.playing) },
  { keys: ["ArrowLeft"], words: "a frame back; live: move the view left", act: () => (recorded() ? scrub.step(-1) : pointer.pan(-pan_px, 0)) },
  { keys: ["ArrowRight"], words: "a frame forward; live: move the view right", act: () => (recorded() ? scrub.step(1) : pointer.pan(pan_px, 0)) },
  { keys: ["ArrowUp"], words: "move the view up", act: () => pointer.pan(0, -pan_px) },
  { keys: ["ArrowDown"], words: "move the view down", act: () => pointer.pan(0, pan_px) },
  { keys: ["<", ","], words: "slower", act: () => recorded() && scrub.change_speed(-1) },
  { keys: [">", "."], words: "faster", act: () => recorded() && scrub.change_speed(1) },
  { keys: ["]"], words: "pick the next robot", act: () => pointer.next(1) },
  { keys: ["["], words: "pick the previous robot", act: () => pointer.next(-1) },
  { keys: ["f"], words: "follow the picked robot", act: () => options.set({ follow: !options.follow }) },
  { keys: ["t"], words: "labs side by side, or together in the shared frame", act: () => options.set({ mode: options.mode === "side" ? "together" : "side", ruler: null }) },
  { keys: ["l"], words: "a drag moves the view", act: () => options.set({ tool: "look", ruler: null }) },
  { keys: ["m"], words: "a drag measures a distance", act: () => options.set({ tool: "measure" }) },
  { keys: ["h"], words: "a drag moves a robot (emulator)", act: () => options.set({ tool: "hand", ruler: null }) },
  { keys: ["+", "="], words: "closer", act: () => pointer.zoom(1.25) },
  { keys: ["-"], words: "further", act: () => pointer.zoom(0.8) },
  { keys: ["0"], words: "show everything", act: () => pointer.fit() },
  { keys: ["?"], words: "this help", act: () => keys.help() },
]);

/** @param {import("./wire/wire.js").Frame} frame */
function show(frame) {
  const lab = world.labs[frame.lab];
  if (frame.kind === "picture") {
    const picture = lab && stage.pictures.get(lab)?.find((p) => p.camera.name === frame.channel);
    picture?.take(frame.data, frame.t_us).then((used) => used && (stage.pictures_version += 1));
    return;
  }
  const taken = world.take(frame);
  if (lab) lab.heard_ms = performance.now();
  if (!taken) return;
  if (frame.channel === "status") counts.note(world);
  if (frame.channel === "poses" && lab?.own === options.pick?.lab) extend_path(lab);
}

/** Pictures of a lab's cameras.
 * @param {import("./world/lab.js").Lab} lab */
function make_pictures(lab) {
  const key = JSON.stringify(lab.cameras);
  if (lab.cameras_key === key) return;
  lab.cameras_key = key;
  stage.pictures.set(lab, lab.cameras.map((camera) => new CameraPicture(camera)));
}

let path_of = "";
/** @param {import("./world/lab.js").Lab} lab */
function extend_path(lab) {
  const { pick } = options;
  if (!pick) return;
  const key = `${pick.lab}/${pick.id} ${lab.trails_epoch}`;
  if (key !== path_of) {
    path_of = key;
    const trail = lab.trails.get(pick.id);
    stage.path = [];
    for (let i = trail?.first ?? 0; trail && i < trail.count; ++i) stage.path.push({ x: trail.xs[i % trail.points], y: trail.ys[i % trail.points] });
  }
  const at = find(lab, pick);
  if (at) stage.path.push({ x: at.x, y: at.y });
  if (stage.path.length > path_most) stage.path = stage.path.filter((_, i) => i % 2 === 0);
}

/** @param {string} name @param {any} value */
function heard(name, value) {
  if (name === "hello") void greeted(value);
  else if (name === "rates") {
    value.labs.forEach((/** @type {any} */ lab, /** @type {number} */ i) => (world.rates[i] = lab.channels));
    world.replaced = value.viewer?.replaced ?? 0;
  } else if (name === "cameras") {
    for (const lab of world.labs) {
      lab.cameras = value.filter((/** @type {any} */ c) => c.lab === lab.index);
      make_pictures(lab);
    }
  } else if (name === "events") world.tell(value.lines.map((/** @type {any} */ line) => ({ kind: "", lab: value.lab, ...line })));
  else if (name === "done") player.done(value);
  else if (name === "refused") {
    if (value.request) player.refused(value.request, value.why);
    else control.say(`refused: ${value.why}`);
  }
}

/** A server tells each new connection of the first run of its batch; the page goes on with the one that it showed.
 * @param {any} value */
async function greeted(value) {
  const { runs, number: run = 0 } = world.about;
  if (run > 0 && value.runs?.[run] === runs?.[run]) {
    const { answer } = await player.ask({ open: { run } });
    if (!answer.refused) return hello({ ...answer.about, token_ok: value.token_ok });
    if (connection.socket?.readyState !== WebSocket.OPEN) return; // the next connection is greeted, too
  }
  hello(value);
}

/** @param {any} value */
function hello(value) {
  world.introduce(value.about ?? value);
  document.title = `arkmesh: ${world.about.labs.join(", ")}`;
  document.body.classList.toggle("bare", bare);
  place("title").textContent = [world.about.run || world.about.labs.join(" + "), world.about.version].filter(Boolean).join(" · ");
  document.body.classList.remove("waiting");
  panels_due = 0;
  if (value.token_ok !== undefined) control.allow(Boolean(value.token_ok) && world.about.control);
  scrub.element.hidden = !recorded();
  player.introduce(recorded() ? (value.length_us ?? 0) : 0, Boolean(value.growing));
  player.reconnect();
  address.restore();
  counts.set([], recorded());
  player.ask({ series: {} }).then(({ answer }) => answer.series && counts.set(answer.series, recorded()));
  if (!recorded()) return;
  player.ask({ events: {} }).then(({ answer }) => {
    world.events = [];
    world.tell(answer.events ?? []);
  });
}

/** @param {boolean} open @param {string} why */
function connected(open, why) {
  notices.connected(open, why, performance.now());
  notices.update(world, performance.now());
  if (!open) player.lost();
}

/** Writes all panels. */
function write_panels() {
  for (const panel of panels) panel.update(world);
  notices.update(world, performance.now());
  control.update();
  view_bar.update(world.labs, control.may && Boolean(world.about.emulator?.some(Boolean)));
  if (recorded()) scrub.update();
  place("now").textContent = recorded() || !world.labs.length ? "" : time_words(world.t_us);
  address.save();
  const unread = [...world.not_understood.values()].reduce((a, b) => a + b, 0) + connection.refused;
  place("unread").textContent = (unread ? `${counted(unread, "message")} not understood. ` : "") + (world.replaced ? `${world.replaced} skipped for this viewer.` : "");
  place("unread").title = [...world.not_understood].map(([why, n]) => `${n}: ${why}`).join("\n");
}

const film = new Film(player, stage, (now_ms) => {
  stage.draw(now_ms);
  if (!bare) write_panels();
});
let panels_due = 0;
/** @param {number} now_ms */
function frame(now_ms) {
  requestAnimationFrame(frame); // first: what fails once does not end it
  player.tick(now_ms);
  if (film.moments) return; // it draws by itself
  stage.draw(now_ms);
  if (now_ms >= panels_due) {
    panels_due = now_ms + panels_ms;
    write_panels();
  }
}
requestAnimationFrame(frame);

/** For tests, and for whoever looks at it from the browser's console. */
Object.assign(window, { arkmesh: { world, stage, options, player, connection, control, counts, pointer, film } });
