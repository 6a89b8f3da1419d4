// Fills holes in, restores, fairs, repairs and checks triangle meshes: the program isomend as WebAssembly, in a worker.

import { fromPly, toPly } from "./ply.js";

/** The address of this module. Bundlers leave it alone, unlike `new URL(NAME, import.meta.url)` with a name that they cannot see. */
const HERE = import.meta.url;
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
  const address = new URL(source, HERE);
  if (isNode && address.protocol === "file:") {
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ "node:fs/promises");
    return WebAssembly.compile(await readFile(address));
  }
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address} cannot be loaded: ${answer.status}`);
  return WebAssembly.compile(await answer.arrayBuffer());
}

async function newWorker() {
  // Bundlers find the worker by this expression.
  if (!isNode) return new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  const { Worker: Thread } = await import(/* webpackIgnore: true */ /* @vite-ignore */ "node:worker_threads");
  const worker = new Thread(new URL("./worker.js", HERE));
  // A worker without work does not keep the process alive.
  worker.unref();
  return Object.assign(worker, { addEventListener: (name, called) => worker.on(name, (value) => called(name === "message" ? { data: value } : value)) });
}

/** Runs one command in a worker; an abort terminates the worker. */
async function inWorker(work, { progress, signal }) {
  signal?.throwIfAborted();
  const worker = idle.pop() ?? await newWorker();
  if (signal?.aborted) {
    idle.push(worker);
    throw signal.reason;
  }
  if (isNode) worker.ref();
  return new Promise((resolve, reject) => {
    const ended = (settle, value) => {
      signal?.removeEventListener("abort", stop);
      worker.called = undefined;
      settle(value);
    };
    const failed = (error) => {
      worker.terminate();
      ended(reject, error);
    };
    const stop = () => failed(signal.reason);
    const listen = !("called" in worker);
    worker.called = ({ share, result, error, lost }) => {
      if (share !== undefined) {
        try {
          progress?.(share);
        } catch (thrown) {
          failed(thrown);
        }
        return;
      }
      if (lost !== undefined) return failed(new Error(`the worker failed: ${lost}`));
      if (error !== undefined) return failed(new Error(error));
      if (isNode) worker.unref();
      idle.push(worker);
      ended(resolve, result);
    };
    if (listen) {
      worker.addEventListener("message", ({ data }) => worker.called?.(data));
      worker.addEventListener("error", (event) => {
        const place = idle.indexOf(worker);
        if (place >= 0) idle.splice(place, 1);
        worker.called?.({ lost: event.message || "its script cannot be loaded" });
      });
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

/** Options of the command line from an object: `{ maxDiameter: 20, strict: true }` gives `--max-diameter 20 --strict`. */
function optionsOf(options) {
  if (options.json !== undefined) throw new TypeError("there is no option json: the report is always returned");
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
async function fileOf(mesh) {
  if (mesh?.positions) return { name: "mesh.ply", data: toPly(mesh), isArrays: true };
  if (mesh instanceof Blob) return { name: mesh.name ?? "mesh", data: new Uint8Array(await mesh.arrayBuffer()) };
  if (mesh?.data !== undefined) return { name: mesh.name ?? "mesh", data: bytesOf(mesh.data) };
  return { name: "mesh", data: bytesOf(mesh) };
}

/** A path as an argument: a leading dash would be an option. */
const argumentOf = (path) => path.startsWith("-") ? `./${path}` : path;

/** Runs a command on a mesh and returns the program's JSON report. Exit code 3 means: done in part, or the answer is no. */
async function command(name, mesh, more, options, { files = {}, progress, signal } = {}) {
  const input = await fileOf(mesh);
  const args = [name, argumentOf(input.name), ...more(input), ...optionsOf(options), "--json=-"];
  const done = await run(args, { files: { ...files, [input.name]: input.data }, progress, signal });
  if (done.code !== 0 && done.code !== 3) throw new IsomendError(done.stderr.trim() || `the program ended with ${done.code}`, done.code);
  return { input, done, report: JSON.parse(done.stdout), complete: done.code === 0, messages: done.stderr };
}

/** A command that writes a mesh: the arrays if arrays were given, else a file in the format of the input or of `options.output`. */
function mending(name) {
  return async (mesh, { output, ...options } = {}, control = {}) => {
    const target = (input) => output ?? `mended${input.name.match(/\.[^./]*$/)?.[0] ?? ".ply"}`;
    const { input, done, report, complete, messages } = await command(name, mesh, (given) => ["-o", argumentOf(target(given))], options, control);
    const written = target(input).split("/").filter((part) => part && part !== ".").join("/");
    const { [written]: data, ...files } = done.files;
    if (!data) throw new IsomendError(`the program did not write ${written}`, done.code);
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
