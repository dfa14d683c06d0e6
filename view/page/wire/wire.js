// The server's binary frames: a head of 16 bytes (little-endian), a channel's name, then data that goes on as it came.

/** @typedef {{kind: "message"|"picture", lab: number, request: number, t_us: number, channel: string, data: Uint8Array}} Frame */

const head_bytes = 16;
const kinds = /** @type {const} */ (["", "message", "picture"]);
const words = new TextDecoder();

const bundle_kind = 3;
const bundle_head_bytes = 4;

/** The frames of a binary message: itself, or those in a bundle. What a bundle's end cuts off comes as it is.
 * @param {ArrayBuffer} buffer @returns {ArrayBuffer[]} */
export function frames_in(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < bundle_head_bytes || view.getUint8(0) !== bundle_kind) return [buffer];
  const frames = [];
  for (let at = bundle_head_bytes; at + 4 <= buffer.byteLength; ) {
    const bytes = view.getUint32(at, true);
    frames.push(buffer.slice(at + 4, at + 4 + bytes));
    at += 4 + bytes;
  }
  return frames;
}

/** Null when the bytes are no frame.
 * @param {ArrayBuffer} buffer @returns {Frame | null} */
export function parse_frame(buffer) {
  if (buffer.byteLength < head_bytes) return null;
  const view = new DataView(buffer);
  const kind = kinds[view.getUint8(0)];
  const channel_bytes = view.getUint8(2);
  if (!kind || buffer.byteLength < head_bytes + channel_bytes) return null;
  return {
    kind,
    lab: view.getUint8(1),
    request: view.getUint32(4, true),
    t_us: Number(view.getBigInt64(8, true)),
    channel: words.decode(new Uint8Array(buffer, head_bytes, channel_bytes)),
    data: new Uint8Array(buffer, head_bytes + channel_bytes),
  };
}
