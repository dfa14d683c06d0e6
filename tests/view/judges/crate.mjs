// Reads a crate with the RO-Crate library: crate.mjs FOLDER. Prints what the library's checks and its own say, a line each; exit code 1 when one fails.
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

// The library fetches the context; here only its address is compared with the standard's, so that no other machine is asked.
const address = "https://w3id.org/ro/crate/1.1/context";
globalThis.fetch = async (asked) => ({ ok: asked === address, json: async () => ({ name: ["RO-Crate JSON-LD Context"], version: "1.1" }) });

const { ROCrate, Checker } = createRequire(join(process.cwd(), "judge.js"))("ro-crate");
const folder = process.argv[2];
const read = () => JSON.parse(readFileSync(join(folder, "ro-crate-metadata.json")));
const checker = new Checker(new ROCrate(read()));
await checker.check();
const checks = checker.checklist.map((item) => [item.status, `${item.name.trim()}: ${item.message}`]);

const root = new ROCrate(read(), { array: true, link: true }).rootDataset;
for (const part of root.hasPart) {
  const there = existsSync(join(folder, decodeURIComponent(part["@id"])));
  if (!there || !part.name?.length || !part.encodingFormat?.length) checks.push([false, `part ${part["@id"]} has no file, name or format`]);
}
for (const run of root.mentions) {
  const linked = (key) => run[key]?.length > 0 && run[key].every((each) => each["@type"]?.length);
  checks.push([["instrument", "object", "result", "agent"].every(linked), `${run.name}: program, inputs, results and agent are entities of the crate`]);
}
for (const [ok, words] of checks) console.log(`${ok ? "yes" : "NO "}  ${words}`);
process.exit(checks.every(([ok]) => ok) && root.mentions.length > 0 && root.hasPart.length > 0 ? 0 : 1);
