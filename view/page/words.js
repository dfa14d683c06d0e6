// Numbers as people read them.

/** @param {number} t_us */
export function time_words(t_us) {
  const tenths = Math.floor(t_us / 1e5), whole = Math.floor(tenths / 10);
  const minutes = Math.floor(whole / 60) % 60, hours = Math.floor(whole / 3600);
  const two = (/** @type {number} */ n) => String(n).padStart(2, "0");
  return `${hours ? `${hours}:${two(minutes)}` : minutes}:${two(whole % 60)}.${tenths - 10 * whole}`;
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

/** With thin spaces between thousands.
 * @param {number | bigint} n */
export function number_words(n) {
  return String(n).replace(/\B(?=(\d{3})+(?!\d))/g, "\u2009");
}

/** How many of something: "1 robot", "2 robots".
 * @param {number} n @param {string} one its name; for several it gets an s, or is `many` @param {string} [many] */
export function counted(n, one, many = `${one}s`) {
  return `${number_words(n)} ${n === 1 ? one : many}`;
}

/** Units that a count's name may end with, as in app/count_words.cpp: what is shown, and how many of the count's own make one.
 * @type {Record<string, {unit: string, per: number}>} */
const count_units = { ppm: { unit: "%", per: 1e4 }, us: { unit: "s", per: 1e6 }, ms: { unit: "s", per: 1e3 }, s: { unit: "s", per: 1 }, bytes: { unit: "kB", per: 1e3 } };

/** A count's name for people, and its unit: "flying south" and "%" of flying.south_ppm.
 * @param {string} name */
export function count_name(name) {
  const at = Math.max(name.lastIndexOf("."), name.lastIndexOf("_"));
  const unit = at > 0 ? count_units[name.slice(at + 1)] : undefined;
  return { words: (unit ? name.slice(0, at) : name).replace(/[._]/g, " "), unit: unit?.unit ?? "", per: unit?.per ?? 1 };
}

/** @param {string} name of a count @param {number} n */
export function count_value(name, n) {
  const { unit, per } = count_name(name);
  return unit ? `${(n / per).toFixed(1)} ${unit}` : number_words(n);
}

/** How many in a second, or how many times faster: three digits at least, and no powers of ten.
 * @param {number} n */
export function rate_words(n) {
  return n >= 99.95 ? number_words(Math.round(n)) : n === 0 ? "0" : n.toFixed(n < 1 ? 2 : 1);
}
