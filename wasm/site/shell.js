// The program in the browser: opens files, keeps the worker, and answers the requests of the page in the frame.

const find = (selector) => document.querySelector(selector);
const frame = find("#page");
const say = (text) => { find("#message").textContent = text; };

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
    if (stopped !== undefined) this.#again(stopped);
    if (id === undefined) return;
    const { resolve, reject } = this.#waiting.get(id);
    this.#waiting.delete(id);
    if (error === undefined) resolve(result);
    else reject(new Error(error));
  }

  #keep({ changed, gone }) {
    changed.forEach(([path, data]) => this.#files.set(path, data));
    gone.forEach((path) => this.#files.delete(path));
    showFiles(this.#files);
  }

  #lost(message) {
    this.#again(message);
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
    // The meshes have new numbers.
    frame.contentWindow.location.reload();
  }

  async write(path, data) {
    if (!this.#worker) await this.#start();
    this.#files.set(path, data);
    await this.#ask("write", { path, data });
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

const MESHES = /\.(obj|ply|stl|gltf|glb|vtk|vtp|off|3mf)$/i;

/** Takes files in, and opens the first mesh among them. */
async function take(files) {
  try {
    say("Loading …");
    for (const file of files) {
      given.add(file.name);
      await host.write(file.name, new Uint8Array(await file.arrayBuffer()));
    }
    const mesh = files.find((file) => MESHES.test(file.name));
    if (!mesh) throw new Error("there is no mesh among these files");
    const page = await host.open(mesh.name);
    frame.src = `page.html?page=${page}`;
    frame.hidden = false;
    find("#start").hidden = true;
  } catch (error) {
    say(error.message);
    find("#start").hidden = false;
  }
}

find("#choose").addEventListener("change", ({ target }) => take([...target.files]));
find("#example").addEventListener("click", async () => {
  const answer = await fetch("scan.ply");
  await take([new File([await answer.blob()], "scan.ply")]);
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
