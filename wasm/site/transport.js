// Lets the page speak with the program in the worker instead of a server: requests below "api/" and the stream of events.

const host = window.parent.isomendHost;
const page = Number(new URLSearchParams(location.search).get("page"));
const network = window.fetch.bind(window);

/** The path of a request to the program; none for other addresses. */
function pathOf(address) {
  const url = new URL(address, location.href);
  const folder = new URL("api/", location.href);
  return url.href.startsWith(folder.href) ? `api/${url.href.slice(folder.href.length)}` : null;
}

window.fetch = async (address, options = {}) => {
  const path = pathOf(address);
  if (path === null) return network(address, options);
  const isPost = options.method === "POST";
  const mediaType = isPost ? (options.headers?.["Content-Type"] ?? "application/json") : "";
  const body = isPost ? new Uint8Array(await new Response(options.body ?? "").arrayBuffer()) : new Uint8Array();
  const answer = await host.answer(page, path, mediaType, body);
  const isEmpty = answer.status === 204 || answer.body.length === 0;
  return new Response(isEmpty ? null : answer.body, { status: answer.status, headers: answer.mediaType ? { "Content-Type": answer.mediaType } : {} });
};

/** Receives events as the stream of a server would bring them. */
window.EventSource = class extends EventTarget {
  constructor() {
    super();
    host.listen(page, (text) => {
      const [, name, data] = text.match(/^event: (.*)\ndata: (.*)\n/) ?? [];
      if (name) this.dispatchEvent(new MessageEvent(name, { data }));
    });
    setTimeout(() => {
      this.onopen?.();
      this.dispatchEvent(new MessageEvent("state", { data: "{}" }));
    });
  }

  close() {
    host.listen(page, () => {});
  }
};

// A mesh is dropped with its textures: the shell takes all files. One file with face numbers is left to the page.
window.addEventListener("drop", (event) => {
  const files = [...(event.dataTransfer?.files ?? [])];
  if (files.length === 0 || (files.length === 1 && /\.(txt|json|faces)$/i.test(files[0].name))) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  document.querySelector("#drop").hidden = true;
  window.parent.isomendTake(files);
}, true);

// Links to what the program makes, such as a report, lead to a copy of it.
document.addEventListener("click", async (event) => {
  const link = event.target.closest?.("a[href]");
  if (!link || pathOf(link.href) === null) return;
  event.preventDefault();
  const answer = await fetch(link.href);
  window.open(URL.createObjectURL(await answer.blob()), "_blank");
}, true);
