// Shows a recorded run moment by moment, each drawn before the next is asked for: what films and pictures are made with.
import { channels } from "./player.js";

export class Film {
  /** @param {import("./player.js").Player} player @param {(now_ms: number) => void} draw draws everything at once */
  constructor(player, draw) {
    this.player = player;
    this.draw = draw;
    /** Moments that were drawn; from the first one on the page draws nothing else. */
    this.moments = 0;
  }

  /**
   * Goes to a time, without trails.
   * @param {number} t_us
   */
  async begin(t_us) {
    const { player } = this;
    player.play(false);
    player.set_speed(player.speed); // drops what is under way
    player.out.jumped();
    await this.show({ seek: { t_us: Math.round(t_us) } }, t_us);
  }

  /**
   * The next moment.
   * @param {number} step_us lab time since the last one
   */
  async next(step_us) {
    const t_us = this.player.t_us + step_us;
    await this.show({ frames: { from_us: Math.round(t_us), step_us: Math.round(step_us), count: 1, channels } }, t_us);
  }

  /** @param {object} what @param {number} t_us */
  async show(what, t_us) {
    const { frames } = await this.player.ask(what);
    for (const frame of frames) this.player.out.show(frame);
    this.player.t_us = t_us;
    this.moments += 1;
    // Trails are drawn whole each time, as if seconds had passed: a film does not depend on the machine's speed.
    this.draw(this.moments * 10_000);
  }
}
