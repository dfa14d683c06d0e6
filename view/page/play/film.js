// Shows a recorded run moment by moment, each drawn before the next is asked for: what films and pictures are made with.
import { grid_m } from "../draw/floor.js";
import { FilmEncoder } from "./film_encoder.js";
import { channels } from "./player.js";
import { time_words } from "../words.js";

/** Milliseconds that pass for drawing from moment to moment, whatever the machine's speed. */
const moment_ms = 500;

export class Film {
  /** @param {import("./player.js").Player} player @param {import("../stage/stage.js").Stage} stage @param {(now_ms: number) => void} draw draws everything at once */
  constructor(player, stage, draw) {
    this.player = player;
    this.stage = stage;
    this.draw = draw;
    this.encoder = new FilmEncoder(stage);
    /** Lab seconds per second of the film, which its caption tells; 0: a picture, without a caption. */
    this.speed = 0;
    /** Moments that were drawn; from the first one on the page draws nothing else. */
    this.moments = 0;
  }

  /** Goes to a time, without trails.
   * @param {number} t_us @param {number} [speed] */
  async begin(t_us, speed = 0) {
    const { player } = this;
    this.speed = speed;
    player.play(false);
    player.set_speed(player.speed); // drops what is under way
    player.out.jumped();
    await this.show({ seek: { t_us: Math.round(t_us) } }, t_us);
  }

  /** The next moment.
   * @param {number} step_us lab time since the last one */
  async next(step_us) {
    const t_us = this.player.t_us + step_us;
    await this.show({ frames: { from_us: Math.round(t_us), step_us: Math.round(step_us), count: 1, channels } }, t_us);
  }

  /** The next moments, encoded; as the encoder's `bytes`.
   * @param {number} step_us @param {number} count @param {boolean} last */
  async encoded(step_us, count, last) {
    for (let i = 0; i < count; ++i) {
      await this.next(step_us);
      await this.encoder.take();
    }
    return this.encoder.bytes(last);
  }

  /** @param {object} what @param {number} t_us */
  async show(what, t_us) {
    const { frames } = await this.player.ask(what);
    for (const frame of frames) this.player.out.show(frame);
    this.player.t_us = t_us;
    // What the page drew while we waited would tell when trails are drawn whole.
    if (this.moments === 0) this.stage.draw_anew();
    this.moments += 1;
    this.stage.caption = this.speed ? `${time_words(t_us)} of ${time_words(this.player.length_us)}, ${this.speed}×, grid ${grid_m} m` : "";
    this.draw(this.moments * moment_ms);
  }
}
