// The table of a batch as a grid of settings by seeds.

/** Columns of runs.csv that are no results. */
const no_results = new Set(["state", "why", "final_hash", "periods", "duration_s"]);

/** @typedef {{name: string, columns: string[], factors: number, rows: {run: number | null, cells: string[]}[]}} Table */
/** @typedef {{settings: string[], runs: Map<string, {run: number | null, cells: string[]}>}} Row */

/** A batch's table as a grid.
 * @param {Table} table */
export function grid_of({ columns, factors, rows }) {
  const seed = columns.indexOf("seed"), seeds = [...new Set(rows.map((row) => row.cells[seed]))];
  /** @type {Map<string, Row>} */
  const by_settings = new Map();
  for (const row of rows) {
    const settings = row.cells.slice(2, 2 + factors), key = settings.join("\n");
    const found = by_settings.get(key) ?? { settings, runs: new Map() };
    by_settings.set(key, found);
    found.runs.set(row.cells[seed], row);
  }
  const numbers = (/** @type {string} */ name) => rows.some((row) => row.cells[columns.indexOf(name)] !== "" && !Number.isNaN(Number(row.cells[columns.indexOf(name)])));
  return { names: columns.slice(2, 2 + factors), seeds, rows: [...by_settings.values()], results: columns.slice(seed + 1).filter((name) => !no_results.has(name) && numbers(name)) };
}
