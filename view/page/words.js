// Numbers as people read them.

/** @param {number} t_us */
export function time_words(t_us) {
  const s = t_us / 1e6, whole = Math.floor(s);
  const minutes = Math.floor(whole / 60) % 60, hours = Math.floor(whole / 3600);
  const two = (/** @type {number} */ n) => String(n).padStart(2, "0");
  return `${hours ? `${hours}:${two(minutes)}` : minutes}:${two(whole % 60)}.${Math.floor((s - whole) * 10)}`;
}

/** @param {number} metres */
export function distance_words(metres) {
  return metres >= 1 ? `${metres.toFixed(3)} m` : `${(metres * 1000).toFixed(metres < 0.1 ? 1 : 0)} mm`;
}

/** @param {number} bytes */
export function bytes_words(bytes) {
  return bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : bytes >= 1e3 ? `${(bytes / 1e3).toFixed(1)} kB` : `${Math.round(bytes)} B`;
}

/** @param {number} us */
export function duration_words(us) {
  return us < 1e3 ? `${us} µs` : us < 1e6 ? `${(us / 1e3).toFixed(us < 1e4 ? 1 : 0)} ms` : us < 120e6 ? `${(us / 1e6).toFixed(1)} s` : `${(us / 60e6).toFixed(1)} min`;
}

/**
 * With thin spaces between thousands.
 * @param {number | bigint} n
 */
export function number_words(n) {
  return String(n).replace(/\B(?=(\d{3})+(?!\d))/g, "\u2009");
}
