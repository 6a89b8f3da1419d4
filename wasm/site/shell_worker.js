// The program with its pages, in a worker: answers requests, and runs a step when no request waits.

import { Program } from "./program.js";

/** Time without requests after which a step begins, in milliseconds: the page first asks for the state that shows the step as running. */
const QUIET = 150;

let program;
let timer;

/** Files that are new or have changed since the last call, and names of those that are gone. */
const known = new Map();
function changes() {
  const now = new Map(program.files());
  const changed = [...now].filter(([path, data]) => known.get(path) !== data);
  const gone = [...known.keys()].filter((path) => !now.has(path));
  changed.forEach(([path, data]) => known.set(path, data));
  gone.forEach((path) => known.delete(path));
  return { changed, gone };
}

/** Runs the steps that have been started, and says when one begins and ends. */
function work() {
  postMessage({ files: changes(), busy: true });
  try {
    while (program.work());
    postMessage({ files: changes(), busy: false });
  } catch (error) {
    postMessage({ stopped: error.message });
  }
}

const requests = {
  start({ module, files }) {
    program = new Program(module, files, { event: (page, text) => postMessage({ page, event: text }) });
    changes();
  },
  write({ path, data }) {
    program.write(path, data);
  },
  open: ({ path, resume }) => program.open(path, resume),
  answer: ({ page, path, mediaType, body }) => program.answer(page, path, mediaType, body),
};

addEventListener("message", ({ data: { id, name, ...given } }) => {
  try {
    const result = requests[name](given);
    postMessage({ id, result, files: changes() });
  } catch (error) {
    // An instance that has stopped cannot be used again.
    if (error.cause) return postMessage({ id, error: error.message, stopped: error.message });
    postMessage({ id, error: error.message });
  }
  clearTimeout(timer);
  if (program) timer = setTimeout(work, QUIET);
});
