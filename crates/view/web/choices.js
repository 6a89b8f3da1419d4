// The user's choices on each mesh: actions on holes, continued sharp edges, marked faces. The program stores them with the mesh.

import { begun } from "../../report/viewer/activity.js";
import { askJson } from "./net.js";

/** Upper bound of the length of a request that a browser finishes after the page is left, in characters of JSON. */
const KEPT_ALIVE = 30000;
/** Time for which choices are collected before they are sent, in milliseconds. */
const GATHER = 200;

export class Choices {
  constructor() {
    /** The marked faces of meshes, as ranges. */
    this.marks = new Map();
    this.waiting = new Map();
    this.sent = Promise.resolve();
    this.masked = false;
    addEventListener("pagehide", () => this.flush(true).catch(() => null));
  }

  /** Changes the actions on holes of a mesh. */
  holes(id, doings) {
    const waiting = this.wait(id);
    waiting.holes = { ...waiting.holes, ...doings };
  }

  /** Changes the pairs of crease ends of a mesh between which sharp edges are continued. */
  creases(id, pairs) {
    this.wait(id).creases = pairs;
  }

  /** Changes the marked faces of a mesh. */
  mark(id, runs) {
    this.marks.set(id, runs);
    this.masked ||= runs.length > 0;
    this.wait(id).mask = runs;
  }

  wait(id) {
    if (!this.waiting.has(id)) this.waiting.set(id, { id });
    clearTimeout(this.timer);
    this.end ??= begun("request");
    this.timer = setTimeout(() => this.flush().catch(() => null), GATHER);
    return this.waiting.get(id);
  }

  /** Sends all collected choices to the program; resolves when they have arrived. `leaves` says that the page is being left. */
  flush(leaves = false) {
    clearTimeout(this.timer);
    const all = [...this.waiting.values()];
    this.waiting.clear();
    // A page that is being left cannot wait. Browsers limit the length of `keepalive` requests: longer ones are sent as usual and may be
    // cut off.
    const short = (change) => JSON.stringify(change).length < KEPT_ALIVE;
    if (leaves) return Promise.all(all.map((change) => askJson("choices", change, short(change) ? { keepalive: true } : {})));
    // One request after the other; choices that could not be sent wait for the next time.
    const send = async () => {
      for (let change = all.shift(); change; change = all.shift()) {
        try {
          await askJson("choices", change);
        } catch (error) {
          for (const { id, ...rest } of [change, ...all]) this.waiting.set(id, { id, ...rest, ...this.waiting.get(id) });
          throw error;
        }
      }
    };
    const { end } = this;
    this.end = null;
    const sent = this.sent.then(send).finally(() => end?.());
    this.sent = sent.catch(() => null);
    return sent;
  }

  /** Fetches the marked faces of the current mesh. */
  async load({ current, marked, masked }) {
    await this.flush();
    this.masked ||= masked;
    this.marks.set(current, marked ? (await askJson(`marks/${current}`)).runs : []);
  }

  /** The number of marked faces of a mesh. */
  count(id) {
    return (this.marks.get(id) || []).reduce((sum, [first, end]) => sum + end - first, 0);
  }
}
