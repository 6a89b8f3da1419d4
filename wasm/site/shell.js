// The program in the browser: opens files, keeps the worker, and answers the requests of the page in the frame.

const find = (selector) => document.querySelector(selector);
const frame = find("#page");

/** Shows a message on the start page, or above a mesh that is open. */
function say(text) {
  const place = frame.hidden ? find("#message") : find("#notice");
  for (const other of [find("#message"), find("#notice")]) other.textContent = other === place ? text : "";
}

/** The worker with the program. It is ended and started again to cancel a step, or when the program stops. */
class Host {
  #worker;
  #waiting = new Map();
  #last = 0;
  /** The files as the worker has them. */
  #files = new Map();
  /** The files of the pages, in order. */
  #pages = [];
  #receivers = new Map();
  #busy = false;

  async #compiled() {
    this.compiled ??= WebAssembly.compileStreaming(fetch("isomend.wasm"));
    return this.compiled;
  }

  async #start() {
    this.#worker = new Worker("shell_worker.js", { type: "module" });
    this.#worker.addEventListener("message", ({ data }) => this.#told(data));
    this.#worker.addEventListener("error", (event) => this.#lost(event.message));
    await this.#ask("start", { module: await this.#compiled(), files: [...this.#files] });
  }

  #ask(name, given) {
    const id = ++this.#last;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, name, ...given });
    });
  }

  #told({ id, result, error, files, page, event, busy, stopped }) {
    if (files) this.#keep(files);
    if (busy !== undefined) this.#busy = busy;
    if (event !== undefined) this.#receivers.get(page)?.(event);
    if (stopped !== undefined) this.#again(stopped).catch((failed) => say(failed.message));
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    this.#waiting.delete(id);
    if (error === undefined) waiting.resolve(result);
    else waiting.reject(new Error(error));
  }

  #keep({ changed, gone }) {
    changed.forEach(([path, data]) => this.#files.set(path, data));
    gone.forEach((path) => this.#files.delete(path));
    showFiles(this.#files);
  }

  #lost(message) {
    this.#again(message).catch((failed) => say(failed.message));
  }

  /** Ends the worker and starts it again with the same files; the pages repeat their steps. */
  async #again(reason) {
    this.#worker.terminate();
    this.#busy = false;
    for (const { reject } of this.#waiting.values()) reject(new Error(reason));
    this.#waiting.clear();
    await this.#start();
    for (const path of this.#pages) await this.#ask("open", { path, resume: true });
    this.#receivers.clear();
    // The page keeps meshes by their numbers, and these begin again.
    frame.contentWindow.location.reload();
  }

  /** Writes a file. If another one has its name, it gets a number: the other may be open. Returns the name. */
  async write(name, data) {
    if (!this.#worker) await this.#start();
    const [, stem, ending] = name.match(/^(.*?)(\.[^.]*)?$/);
    let path = name;
    for (let i = 2; this.#files.has(path) && !same(this.#files.get(path), data); i++) path = `${stem} (${i})${ending ?? ""}`;
    await this.#ask("write", { path, data });
    return path;
  }

  /** Opens a file and returns the number of its page. */
  async open(path) {
    const page = await this.#ask("open", { path, resume: false });
    this.#pages[page] = path;
    return page;
  }

  /** Receives the events of a page. */
  listen(page, receive) {
    this.#receivers.set(page, receive);
  }

  /** Answers a request of a page. */
  async answer(page, path, mediaType, body) {
    if (path === "api/cancel" && this.#busy) {
      await this.#again("cancelled");
      return { status: 202, mediaType: "", body: new Uint8Array() };
    }
    const answer = await this.#ask("answer", { page, path, mediaType, body });
    if (path === "api/open" && answer.status === 200) {
      const { page: address } = JSON.parse(new TextDecoder().decode(answer.body));
      this.#pages[Number(new URL(address, location).searchParams.get("page"))] = JSON.parse(new TextDecoder().decode(body)).path;
    }
    return answer;
  }
}

const host = new Host();
// The page in the frame finds it here.
window.isomendHost = host;

/** Whether two files have the same bytes. */
const same = (a, b) => a.length === b.length && a.every((byte, i) => byte === b[i]);

/** Lets the user download a file. */
function download(name, data) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([data])), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Files that the user has opened. */
const given = new Set();

/** Shows the files that the program has written, to download. */
function showFiles(files) {
  const written = [...files].filter(([path]) => !given.has(path) && !path.split("/").some((name) => name.startsWith(".")));
  const list = find("#files");
  list.hidden = written.length === 0;
  list.replaceChildren("Written:", ...written.map(([path, data]) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: path });
    button.addEventListener("click", () => download(path.split("/").at(-1), data));
    return button;
  }));
}

const MESHES = /\.(obj|ply|stl|gltf|glb|vtk|vtp|off|3mf|usd|usda|usdc|usdz)$/i;

/** Takes files in, and opens the first mesh among them. */
async function take(files) {
  try {
    say("Loading …");
    const names = [];
    for (const file of files) {
      given.add(file.name);
      names.push(await host.write(file.name, new Uint8Array(await file.arrayBuffer())));
      given.add(names.at(-1));
    }
    const mesh = names.find((name) => MESHES.test(name));
    if (!mesh) throw new Error("there is no mesh among these files");
    const page = await host.open(mesh);
    say("");
    frame.src = `page.html?page=${page}`;
    frame.hidden = false;
    find("#start").hidden = true;
  } catch (error) {
    say(error.message.replace(/^\//, ""));
  }
}
// The page in the frame passes on what is dropped there.
window.isomendTake = take;

find("#choose").addEventListener("change", ({ target }) => take([...target.files]));
find("#example").addEventListener("click", async () => {
  const answer = await fetch("scan.ply");
  await take([new File([await answer.blob()], "scan.ply")]);
});
addEventListener("beforeunload", (event) => {
  if (!frame.hidden) event.preventDefault();
});
addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dropping");
});
addEventListener("dragleave", () => document.body.classList.remove("dropping"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("dropping");
  take([...event.dataTransfer.files]);
});
