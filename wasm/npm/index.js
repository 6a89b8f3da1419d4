// Fills holes in, restores, fairs, repairs and checks triangle meshes: the program isomend as WebAssembly, in a worker.

import { fromPly, toPly } from "./ply.js";

const isNode = typeof process !== "undefined" && Boolean(process.versions?.node);
/** The compiled program, once it is asked for. */
let compiled;
/** Workers without work. */
const idle = [];

/** Compiles the program, which the first run does otherwise. `source`: the module, its bytes, or its address. */
export function init(source = new URL("./isomend.wasm", import.meta.url)) {
  compiled ??= compile(source).catch((error) => {
    compiled = undefined;
    throw error;
  });
  return compiled.then(() => {});
}

async function compile(source) {
  if (source instanceof WebAssembly.Module) return source;
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(source);
  const address = new URL(source, import.meta.url);
  if (isNode && address.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return WebAssembly.compile(await readFile(address));
  }
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address} cannot be loaded: ${answer.status}`);
  return WebAssembly.compile(await answer.arrayBuffer());
}

async function newWorker() {
  const address = new URL("./worker.js", import.meta.url);
  if (!isNode) return new Worker(address, { type: "module" });
  const { Worker: Thread } = await import("node:worker_threads");
  const worker = new Thread(address);
  // A worker without work does not keep the process alive.
  worker.unref();
  return Object.assign(worker, { addEventListener: (name, called) => worker.on(name, (value) => called(name === "message" ? { data: value } : value)) });
}

/** Runs work in a worker of its own, which is ended when the signal says so. */
async function inWorker(work, { progress, signal }) {
  signal?.throwIfAborted();
  const worker = idle.pop() ?? await newWorker();
  if (isNode) worker.ref();
  return new Promise((resolve, reject) => {
    const stop = () => {
      worker.terminate();
      worker.called = undefined;
      reject(signal.reason);
    };
    const ended = (settle, value) => {
      signal?.removeEventListener("abort", stop);
      worker.called = undefined;
      settle(value);
    };
    const listen = !("called" in worker);
    worker.called = ({ share, result, error, lost }) => {
      if (share !== undefined) return progress?.(share);
      if (lost) return ended(reject, new Error(`the worker failed: ${lost}`));
      // After an error the worker is not used again.
      if (error !== undefined) {
        worker.terminate();
        return ended(reject, new Error(error));
      }
      if (isNode) worker.unref();
      idle.push(worker);
      return ended(resolve, result);
    };
    if (listen) {
      worker.addEventListener("message", ({ data }) => worker.called?.(data));
      worker.addEventListener("error", (event) => worker.called?.({ lost: event.message }));
    }
    signal?.addEventListener("abort", stop);
    worker.postMessage(work);
  });
}

/**
 * Runs a command line. Its files are in memory: `files` are what it may read; the result has those that it wrote.
 */
export async function run(args, { files = {}, progress, signal } = {}) {
  await init();
  const work = { module: await compiled, args: args.map(String), files: Object.entries(files).map(([name, data]) => [name, bytesOf(data)]) };
  const result = await inWorker(work, { progress, signal });
  return { ...result, files: Object.fromEntries(result.files) };
}

/** Ends the workers that have no work. */
export function close() {
  for (const worker of idle.splice(0)) worker.terminate();
}

/** The program refused or failed; `code` is its exit code. */
export class IsomendError extends Error {
  constructor(message, code) {
    super(message);
    this.name = "IsomendError";
    this.code = code;
  }
}

/** Options of the command line from an object: `{ maxHole: 20, flat: true }` gives `--max-hole 20 --flat`. */
function optionsOf(options) {
  return Object.entries(options).flatMap(([name, value]) => {
    const option = `--${name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)}`;
    if (value === false || value === undefined || value === null) return [];
    if (value === true) return [option];
    return [`${option}=${Array.isArray(value) ? value.join(",") : value}`];
  });
}

function bytesOf(data) {
  if (data instanceof Uint8Array) return data;
  if (data instanceof ArrayBuffer) return new Uint8Array(data);
  if (typeof data === "string") return new TextEncoder().encode(data);
  throw new TypeError("a file is a Uint8Array, an ArrayBuffer or a string");
}

/** The file of a mesh: its name and bytes, and whether it was made from arrays. */
function fileOf(mesh) {
  if (mesh?.positions) return { name: "mesh.ply", data: toPly(mesh), isArrays: true };
  if (mesh?.data) return { name: mesh.name ?? "mesh", data: bytesOf(mesh.data) };
  return { name: "mesh", data: bytesOf(mesh) };
}

/** Runs a command on a mesh and returns the program's JSON report. Exit code 3 means: done in part, or the answer is no. */
async function command(name, mesh, more, options, { files = {}, progress, signal } = {}) {
  const input = fileOf(mesh);
  const args = [name, input.name, ...more(input), ...optionsOf(options), "--json=-"];
  const done = await run(args, { files: { ...files, [input.name]: input.data }, progress, signal });
  if (done.code !== 0 && done.code !== 3) throw new IsomendError(done.stderr.trim() || `the program ended with ${done.code}`, done.code);
  return { input, done, report: JSON.parse(done.stdout), complete: done.code === 0, messages: done.stderr };
}

/** A command that writes a mesh: the arrays if arrays were given, else a file in the format of the input or of `options.output`. */
function mending(name) {
  return async (mesh, { output, ...options } = {}, control = {}) => {
    const target = (input) => output ?? (input.name.includes(".") ? input.name.replace(/^.*(\.[^.]*)$/, "mended$1") : "mended.ply");
    const { input, done, report, complete, messages } = await command(name, mesh, (given) => ["-o", target(given)], options, control);
    const written = target(input);
    const { [written]: data, ...files } = done.files;
    return { data, name: written, mesh: input.isArrays && written.endsWith(".ply") ? fromPly(data) : undefined, report, complete, messages, files };
  };
}

export const fill = mending("fill");
export const restore = mending("restore");
export const fair = mending("fair");
export const repair = mending("repair");

function asking(name) {
  return async (mesh, options = {}, control = {}) => {
    const { report, complete, messages } = await command(name, mesh, () => [], options, control);
    return { report, complete, messages };
  };
}

export const inspect = asking("inspect");
export const check = asking("check");
