// Communication with the program: JSON requests, binary arrays, server-sent events.

import { during } from "../../report/viewer/activity.js";
import { tr } from "./strings.js";

/** The error of a refused request, with the server's message, and the name of a file that was not to be replaced. */
class Refused extends Error {
  constructor(status, text) {
    let words = text, exists;
    try {
      ({ error: words, exists } = JSON.parse(text));
    } catch { /* Not JSON: the text itself. */ }
    super(words || tr("answered_with", { status }));
    this.status = status;
    this.exists = exists;
  }
}

/** Sends a request and returns the response; `sent` becomes a JSON body. */
async function ask(path, sent, more = {}) {
  const options = sent === undefined ? {} : { ...more, method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(sent) };
  let answer;
  try {
    answer = await fetch("api/" + path, options);
  } catch {
    throw new Error(tr("no_answer"));
  }
  if (!answer.ok) throw new Refused(answer.status, await answer.text());
  return answer;
}

/** Requests a file as bytes. */
export async function askBlob(path) {
  return during("request", async () => (await ask(path)).blob());
}

export async function askJson(path, sent, more) {
  const text = await during("request", async () => (await ask(path, sent, more)).text());
  return text ? JSON.parse(text) : {};
}

/** Uploads a file. */
export function sendBytes(path, file) {
  return during("request", () => uploaded(path, file));
}

async function uploaded(path, file) {
  let answer;
  try {
    answer = await fetch("api/" + path, { method: "POST", headers: { "Content-Type": "application/octet-stream" }, body: file });
  } catch {
    throw new Error(tr("no_answer"));
  }
  if (!answer.ok) throw new Refused(answer.status, await answer.text());
  return answer.json();
}

const ARRAYS = { f32: Float32Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array };

/** Decodes a binary response: the length of the header, the header as JSON, then each array at a multiple of 4 bytes. */
function opened(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const round = (x) => Math.ceil(x / 4) * 4;
  let at = round(4 + length);
  const arrays = {};
  for (const { name, type, components = 1, count } of header.arrays) {
    const array = new ARRAYS[type](buffer, at, count * components);
    arrays[name] = array;
    at = round(at + array.byteLength);
  }
  return { header, arrays };
}

export async function askArrays(path) {
  return opened(await during("request", async () => (await ask(path)).arrayBuffer()));
}

/** Listens to the program's events. Calls `called` for each, `lost` when the connection is lost and `back` when it is open. */
export function listen(called, { lost, back }) {
  const source = new EventSource("api/events");
  for (const name of ["progress", "done", "failed", "cancelled", "state"]) {
    source.addEventListener(name, (event) => called(name, JSON.parse(event.data || "{}")));
  }
  source.onerror = lost;
  source.onopen = back;
  return source;
}

/** The indices of the bytes that are 1, as ranges [first, end). */
export function runsOf(bytes) {
  const runs = [];
  for (let i = bytes.indexOf(1); i >= 0; i = bytes.indexOf(1, i)) {
    let end = i + 1;
    while (bytes[end] === 1) end++;
    runs.push([i, end]);
    i = end;
  }
  return runs;
}

/** The new numbers of items after only the items in the ranges were kept; -1 for the others. */
export function numbersAfter(ranges) {
  const numbers = new Int32Array(ranges[ranges.length - 1] || 0).fill(-1);
  for (let i = 0, at = 0; i < ranges.length; i += 2) for (let k = ranges[i]; k < ranges[i + 1]; k++) numbers[k] = at++;
  return numbers;
}
