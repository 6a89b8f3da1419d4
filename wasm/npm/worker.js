// Runs the command line in a worker, so that the page stays responsive: one command after the other.

import { Program } from "./program.js";

/** Sends a message to the caller. */
let send;
/** Shortest time between two messages about progress, in milliseconds. */
const BETWEEN = 50;

function run({ module, args, files }) {
  let last = 0;
  const progress = (share) => {
    const now = Date.now();
    if (now - last < BETWEEN) return;
    last = now;
    send({ share });
  };
  const program = new Program(module, files, { progress });
  const before = new Map(program.files());
  const result = program.run(args);
  const written = [...program.files()].filter(([path, data]) => before.get(path) !== data);
  return { ...result, files: written };
}

const answer = (message) => {
  try {
    send({ result: run(message) });
  } catch (error) {
    send({ error: error.message });
  }
};

if (typeof globalThis.postMessage === "function") {
  send = (message) => globalThis.postMessage(message);
  globalThis.addEventListener("message", ({ data }) => answer(data));
} else {
  import(/* webpackIgnore: true */ /* @vite-ignore */ "node:worker_threads").then(({ parentPort }) => {
    send = (message) => parentPort.postMessage(message);
    parentPort.on("message", answer);
  });
}
