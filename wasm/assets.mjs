// Writes the files of the page into the folder of the site: node wasm/assets.mjs DIR. The program gives them, as its server would.

import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Program } = await import(pathToFileURL(`${folder}/program.js`));
const program = new Program(new WebAssembly.Module(readFileSync(`${folder}/isomend.wasm`)), [["scan.ply", readFileSync(`${folder}/scan.ply`)]]);
const page = program.open("scan.ply", false);

for (const [path, file] of [["", "page.html"], ["page.css"], ["page.js"], ["worker.js"]]) {
  const { status, body } = program.answer(page, path);
  if (status !== 200) throw new Error(`the page has no ${path || "start"}: ${status}`);
  let text = new TextDecoder().decode(body);
  if (path === "") {
    const script = '<script type="module" src="page.js"></script>';
    if (!text.includes(script)) throw new Error("the page does not load its script as expected");
    text = text.replace(script, `<script type="module" src="transport.js"></script>\n${script}`);
  }
  writeFileSync(`${folder}/${file ?? path}`, text);
}
