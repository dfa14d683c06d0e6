// Makes H.264 of what the stage shows with the browser's own encoder: only compressed moments leave the page, which is several times faster than
// pictures of them. Not every browser has this encoder; `begin` says so.

/** High profile, level 5.1: up to 4096 x 2304 pixels. */
const codec = "avc1.640033";
/** So much keeps the lines of trails and grids of a film of 1280 x 720 pixels: 4 Mbit/s at 25 moments a second. */
const bits_per_pixel = 0.174;
/** Seconds of the film between two moments that a player can jump to. */
const key_s = 10;
/** Moments that may wait for the encoder. */
const queue_most = 4;

export class FilmEncoder {
  /** @param {import("../stage/stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    this.c = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(1, 1).getContext("2d"));
    this.per_s = 1;
    this.taken = 0;
    /** @type {Uint8Array[]} what was encoded and not handed out yet */
    this.made = [];
    /** @type {VideoEncoder | null} */
    this.encoder = null;
    /** @type {DOMException | null} */
    this.failed = null;
  }

  /** False: this browser cannot.
   * @param {number} per_s moments per second of the film */
  async begin(per_s) {
    this.stage.resize();
    const [{ canvas }] = this.stage.contexts;
    // its pixels share their colours by four
    const width = canvas.width - (canvas.width % 2), height = canvas.height - (canvas.height % 2);
    const config = { codec, width, height, framerate: per_s, bitrate: Math.round(bits_per_pixel * width * height * per_s), latencyMode: "quality", avc: { format: "annexb" } };
    if (!window.VideoEncoder || !(await VideoEncoder.isConfigSupported(config)).supported) return false;
    Object.assign(this.c.canvas, { width, height });
    this.per_s = per_s;
    this.encoder = new VideoEncoder({
      output: (chunk) => {
        const bytes = new Uint8Array(chunk.byteLength);
        chunk.copyTo(bytes);
        this.made.push(bytes);
      },
      error: (why) => (this.failed = why),
    });
    this.encoder.configure(config);
    return true;
  }

  /** Takes what the stage shows now. */
  async take() {
    const { c, encoder, stage } = this;
    if (!encoder) throw new Error("no film was begun");
    if (this.failed) throw this.failed;
    c.fillStyle = getComputedStyle(document.body).backgroundColor;
    c.fillRect(0, 0, c.canvas.width, c.canvas.height);
    for (const { canvas } of stage.contexts) c.drawImage(canvas, 0, 0);
    const frame = new VideoFrame(c.canvas, { timestamp: Math.round((this.taken / this.per_s) * 1e6) });
    encoder.encode(frame, { keyFrame: this.taken % Math.round(key_s * this.per_s) === 0 });
    frame.close();
    this.taken += 1;
    while (encoder.encodeQueueSize > queue_most && !this.failed) await new Promise((done) => setTimeout(done, 1));
  }

  /** What was encoded since the last call, as a data: URL.
   * @param {boolean} last nothing comes any more
   * @returns {Promise<string>} */
  async bytes(last) {
    if (last) await this.encoder?.flush();
    if (this.failed) throw this.failed;
    const blob = new Blob(this.made.splice(0));
    return new Promise((done) => {
      const reader = new FileReader();
      reader.onload = () => done(String(reader.result));
      reader.readAsDataURL(blob);
    });
  }
}
