// Runs the command line in a worker, so that the page stays responsive: one command after the other.

import { Program } from "./program.js";

const port = typeof globalThis.postMessage === "function" ? globalThis : (await import("node:worker_threads")).parentPort;
/** Shortest time between two messages about progress, in milliseconds. */
const BETWEEN = 50;

function run({ module, args, files }) {
  let last = 0;
  const progress = (share) => {
    const now = Date.now();
    if (now - last < BETWEEN) return;
    last = now;
    port.postMessage({ share });
  };
  const program = new Program(module, files, { progress });
  const before = new Map(program.files());
  const result = program.run(args);
  const written = [...program.files()].filter(([path, data]) => before.get(path) !== data);
  return { ...result, files: written };
}

const answer = (message) => {
  try {
    port.postMessage({ result: run(message) });
  } catch (error) {
    port.postMessage({ error: error.message });
  }
};

if (port === globalThis) port.addEventListener("message", ({ data }) => answer(data));
else port.on("message", answer);
