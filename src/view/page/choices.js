// What is chosen on each mesh: what to do with its holes, which sharp edges are continued, and which faces are marked. The program keeps it with the mesh.

import { askJson } from "./net.js";

/** Bytes that a browser sends for a page that is left. */
const KEPT_ALIVE = 30000;
/** Milliseconds that choices are collected before they are sent. */
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

  /** Takes what is to be done with holes of a mesh. */
  holes(id, doings) {
    const waiting = this.wait(id);
    waiting.holes = { ...waiting.holes, ...doings };
  }

  /** Takes the pairs of crease ends of a mesh between which sharp edges are continued. */
  creases(id, pairs) {
    this.wait(id).creases = pairs;
  }

  /** Takes the marked faces of a mesh. */
  mark(id, runs) {
    this.marks.set(id, runs);
    this.masked ||= runs.length > 0;
    this.wait(id).mask = runs;
  }

  wait(id) {
    if (!this.waiting.has(id)) this.waiting.set(id, { id });
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.flush().catch(() => null), GATHER);
    return this.waiting.get(id);
  }

  /** Tells the program all that was chosen; done once it knows. */
  flush(leaves = false) {
    clearTimeout(this.timer);
    const all = [...this.waiting.values()];
    this.waiting.clear();
    // A page that is left waits for nothing. A browser refuses to send long bodies then: those are sent as usual, and may be cut off.
    const short = (change) => JSON.stringify(change).length < KEPT_ALIVE;
    if (leaves) return Promise.all(all.map((change) => askJson("choices", change, short(change) ? { keepalive: true } : {})));
    // One after the other; what could not be sent waits for the next time.
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
    const sent = this.sent.then(send);
    this.sent = sent.catch(() => null);
    return sent;
  }

  /** Asks which faces of a mesh are marked. */
  async load({ current, marked, masked }) {
    await this.flush();
    this.masked ||= masked;
    this.marks.set(current, marked ? (await askJson(`marks/${current}`)).runs : []);
  }

  /** How many faces of a mesh are marked. */
  count(id) {
    return (this.marks.get(id) || []).reduce((sum, [first, end]) => sum + end - first, 0);
  }
}
