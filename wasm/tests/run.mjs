// Tests the npm package against the program of this system: node wasm/tests/run.mjs PACKAGE PROGRAM
//
// The same bytes for the meshes of data/; arrays; progress; cancelling; errors.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, program] = process.argv.slice(2).map((path) => resolve(path));
const { IsomendError, check, close, fill, init, inspect, repair, restore, run } = await import(pathToFileURL(join(folder, "index.js")));
const data = resolve(import.meta.dirname, "../../data");
const temporary = mkdtempSync(join(tmpdir(), "isomend-"));
const read = (name) => readFileSync(join(data, name));
let failed = 0;

async function test(name, body) {
  const start = performance.now();
  try {
    await body();
    console.log(`right    ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failed++;
    console.log(`WRONG    ${name}: ${error.stack}`);
  }
}

/** What the program of this system writes. */
function expected(command, name, options, output) {
  const path = join(temporary, output);
  execFileSync(program, [command, join(data, name), "-o", path, ...options], { stdio: "ignore" });
  return readFileSync(path);
}

const meshes = readdirSync(data).filter((name) => /\.(ply|obj)$/.test(name));
for (const name of meshes) {
  await test(`fill of ${name}: the same bytes`, async () => {
    const { data: bytes, complete } = await fill({ name, data: read(name) });
    const other = expected("fill", name, [], `mended${name.slice(-4)}`);
    assert.ok(complete);
    assert.equal(Buffer.compare(Buffer.from(bytes), other), 0, `${bytes.length} and ${other.length} bytes`);
  });
}

await test("repair and restore: the same bytes", async () => {
  const repaired = await repair({ name: "scan.ply", data: read("scan.ply") }, { output: "whole.stl" });
  assert.equal(Buffer.compare(Buffer.from(repaired.data), expected("repair", "scan.ply", [], "whole.stl")), 0);
  const restored = await restore({ name: "painted.ply", data: read("painted.ply") }, { colour: "ff0000", output: "restored.glb" });
  assert.equal(Buffer.compare(Buffer.from(restored.data), expected("restore", "painted.ply", ["--colour", "ff0000"], "restored.glb")), 0);
});

await test("arrays: kept bit for bit, with new vertices and faces after them", async () => {
  // A cube of side 2 without its upper face.
  const positions = new Float64Array([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, Math.fround(1.1)]);
  const faces = new Uint32Array([0, 2, 1, 0, 3, 2, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7]);
  const { mesh, report } = await fill({ positions, faces });
  assert.deepEqual(mesh.positions.subarray(0, positions.length), positions);
  assert.deepEqual(mesh.faces.subarray(0, faces.length), faces);
  assert.ok(mesh.faces.length > faces.length);
  assert.equal(report.format, 3);
  await assert.rejects(fill({ positions, faces: [0, 1, 8] }), RangeError);
  await assert.rejects(fill({ positions: [0, 1], faces }), TypeError);
});

await test("inspect and check: reports", async () => {
  const { report } = await inspect(read("scan.ply"));
  assert.ok(report.holes.length > 0);
  const { complete } = await check(read("scan.ply"));
  assert.equal(complete, false);
});

await test("progress ends near 1, and a run can be cancelled", async () => {
  const shares = [];
  await fill(read("torus.ply"), {}, { progress: (share) => shares.push(share) });
  assert.ok(shares.length > 1 && shares.every((share, i) => share >= (shares[i - 1] ?? 0) && share <= 1), `${shares}`);
  const abort = new AbortController();
  const begun = fill(read("torus.ply"), {}, { progress: () => abort.abort(), signal: abort.signal });
  await assert.rejects(begun, { name: "AbortError" });
  await assert.rejects(fill(read("torus.ply"), {}, { signal: AbortSignal.abort() }), { name: "AbortError" });
});

await test("errors say what is wrong, and leave the next run alone", async () => {
  const refused = (error) => error instanceof IsomendError && error.code === 2;
  await assert.rejects(fill(read("scan.ply"), { noSuchOption: 1 }), refused);
  await assert.rejects(fill(read("scan.ply"), { voxel: "-1" }), (error) => /voxel/.test(error.message));
  await assert.rejects(fill(new Uint8Array([1, 2, 3])), (error) => error instanceof IsomendError && error.code === 1);
  const { code, stdout, files } = await run(["convert", "a.ply", "-o", "b/c.obj"], { files: { "a.ply": read("sphere.ply"), "b/d.txt": "" } });
  assert.equal(code, 0, stdout);
  assert.ok(files["b/c.obj"].length > 0);
});

await test("names and outputs of all kinds", async () => {
  const data = read("slab.ply");
  const same = (name, options) => fill({ name, data }, options);
  const { data: own, name } = await same("mended.ply");
  assert.equal(name, "mended.ply");
  for (const [input, options] of [["-a.ply"], ["dir.v2/mesh"], ["b.ply", { output: "./b.ply" }], ["c.ply", { output: "/d.ply" }]]) {
    assert.equal(Buffer.compare(Buffer.from((await same(input, options)).data), Buffer.from(own)), 0, input);
  }
  const { data: blob } = await fill(new Blob([data]));
  assert.equal(Buffer.compare(Buffer.from(blob), Buffer.from(own)), 0);
  await assert.rejects(same("a.ply", { json: "b" }), TypeError);
  await assert.rejects(run(["check", "a"], { files: { a: data, "a/b": data } }), /a is a file/);
});

await test("several runs at once, of which some are cancelled", async () => {
  const abort = new AbortController();
  const runs = [0, 1, 2, 3].map((i) => fill(read("slab.ply"), {}, i % 2 ? { signal: abort.signal } : {}));
  queueMicrotask(() => abort.abort());
  const [first, second, third, fourth] = await Promise.allSettled(runs);
  assert.deepEqual(first.value.data, third.value.data);
  assert.ok([second, fourth].every(({ reason }) => reason?.name === "AbortError"));
  await assert.rejects(fill(read("torus.ply"), {}, { progress: () => { throw new RangeError("own"); } }), RangeError);
});

await test("files beside the mesh are read and written", async () => {
  const { code, files } = await run(["fill", "sphere.ply", "-o", "out.glb", "--patches", "patches.ply"], { files: { "sphere.ply": read("sphere.ply") } });
  assert.equal(code, 0);
  assert.deepEqual(Object.keys(files).sort(), ["out.glb", "patches.ply"]);
});

await init();
close();
rmSync(temporary, { recursive: true });
console.log(failed ? `${failed} tests failed` : "all tests are right");
process.exitCode = failed ? 1 : 0;
