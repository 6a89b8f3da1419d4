// The program as a WebAssembly instance with files in memory.

import { ConsoleStdout, Directory, File, OpenFile, PreopenDirectory, WASI, WASIProcExit } from "./wasi/index.js";

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** Collects what the program writes to one of its streams. */
class Collected {
  #parts = [];
  #kept = new TextDecoder();
  stream = new ConsoleStdout((bytes) => this.#parts.push(this.#kept.decode(bytes.slice(), { stream: true })));
  text() {
    return this.#parts.join("");
  }
}

/** The folder of a path in a tree of folders, and the name in it; missing folders are made. */
function placeOf(root, path) {
  const names = path.split("/").filter((name) => name && name !== ".");
  const last = names.pop();
  if (!last || names.includes("..") || last === "..") throw new TypeError(`this is no name of a file: ${path}`);
  let folder = root;
  for (const name of names) {
    if (!folder.has(name)) folder.set(name, new Directory(new Map()));
    if (folder.get(name) instanceof File) throw new TypeError(`${name} is a file, not a folder, in ${path}`);
    folder = folder.get(name).contents;
  }
  return [folder, last];
}

/** All files below a folder, as [path, bytes]. */
function* filesIn(folder, before = "") {
  for (const [name, inode] of folder) {
    if (inode instanceof File) yield [before + name, inode.data];
    else yield* filesIn(inode.contents, `${before}${name}/`);
  }
}

/** One instance of the program. Its files are in memory, below "/". */
export class Program {
  #exports;
  #folder;
  #written = [new Collected(), new Collected()];

  /**
   * @param {WebAssembly.Module} module the compiled program
   * @param {Iterable<[string, Uint8Array]>} files its files: paths and bytes
   * @param {{ progress?: (share: number) => void, event?: (page: number, text: string) => void }} receivers
   */
  constructor(module, files, { progress = () => {}, event = () => {} } = {}) {
    this.#folder = new PreopenDirectory("/", new Map());
    for (const [path, data] of files) this.write(path, data);
    const wasi = new WASI(["isomend"], [], [new OpenFile(new File([])), this.#written[0].stream, this.#written[1].stream, this.#folder], { debug: false });
    const own = { progress, event: (page, at, length) => event(page, this.#text(at, length)) };
    const instance = new WebAssembly.Instance(module, { wasi_snapshot_preview1: wasi.wasiImport, isomend: own });
    this.#exports = instance.exports;
    wasi.initialize(instance);
  }

  /** Writes a file, also into folders that do not exist yet. */
  write(path, data) {
    const [folder, name] = placeOf(this.#folder.dir.contents, path);
    folder.set(name, new File(data));
  }

  /** All files. */
  files() {
    return filesIn(this.#folder.dir.contents);
  }

  /** Runs the command line; afterwards the instance cannot be used again. */
  run(args) {
    let code;
    try {
      code = this.#exports.isomend_run(...this.#passed(JSON.stringify(args)));
    } catch (error) {
      if (!(error instanceof WASIProcExit)) throw this.#failed(error);
      code = error.code;
    }
    const [stdout, stderr] = this.#written.map((written) => written.text());
    return { code, stdout, stderr };
  }

  /** Opens a file on a page and returns the page's number. */
  open(path, resume) {
    const page = this.#called(() => this.#exports.isomend_open(...this.#passed(path), Number(resume)));
    if (page < 0) throw new Error(decoder.decode(this.#left(0)));
    return page;
  }

  /** Answers a request to a page; with a media type it is a POST request. */
  answer(page, path, mediaType = "", body = new Uint8Array()) {
    const sent = [path, mediaType, body].flatMap((value) => this.#passed(value));
    const status = this.#called(() => this.#exports.isomend_answer(page, ...sent));
    return { status, body: this.#left(0), mediaType: decoder.decode(this.#left(1)) };
  }

  /** Runs one job that a request has started; false if there is none. */
  work() {
    return this.#called(() => this.#exports.isomend_work()) !== 0;
  }

  #called(call) {
    try {
      return call();
    } catch (error) {
      throw this.#failed(error);
    }
  }

  /** The error of an instance that has stopped, with what the program said last. */
  #failed(error) {
    const said = this.#written[1].text().trim();
    return new Error(`the program stopped: ${said || error.message}`, { cause: error });
  }

  /** Copies text or bytes into a buffer of the program: its address and length. */
  #passed(value) {
    const bytes = typeof value === "string" ? encoder.encode(value) : value;
    const at = this.#exports.isomend_take(bytes.length);
    new Uint8Array(this.#exports.memory.buffer, at, bytes.length).set(bytes);
    return [at, bytes.length];
  }

  #left(which) {
    const at = this.#exports.isomend_left(which);
    return new Uint8Array(this.#exports.memory.buffer, at, this.#exports.isomend_left_length(which)).slice();
  }

  #text(at, length) {
    return decoder.decode(new Uint8Array(this.#exports.memory.buffer, at, length));
  }
}
