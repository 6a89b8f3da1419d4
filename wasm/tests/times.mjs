// Times fills by the npm package and by the program on one thread: node wasm/tests/times.mjs PACKAGE PROGRAM. Prints medians of three runs.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, program] = process.argv.slice(2).map((path) => resolve(path));
const { close, fill, init } = await import(pathToFileURL(join(folder, "index.js")));
const data = resolve(import.meta.dirname, "../../data");
const temporary = mkdtempSync(join(tmpdir(), "isomend-"));

async function median(work) {
  const seconds = [];
  for (let i = 0; i < 3; i++) {
    const start = performance.now();
    await work();
    seconds.push((performance.now() - start) / 1000);
  }
  return seconds.sort((a, b) => a - b)[1].toFixed(2);
}

await init();
for (const name of ["scan.ply", "sphere.ply", "torus.ply", "slab.ply"]) {
  const [path, bytes] = [join(data, name), readFileSync(join(data, name))];
  const module = await median(() => fill({ name, data: bytes }));
  const own = await median(() => execFileSync(program, ["fill", path, "-o", join(temporary, name), "--threads", "1"], { stdio: "ignore" }));
  console.log(`${name}: ${module} s by the module, ${own} s by the program`);
}
close();
rmSync(temporary, { recursive: true });
