// What is chosen on each mesh: what to do with its holes, and which faces are marked. The program keeps it with the mesh.

/** Milliseconds that a choice waits for others before all are told. */
const GATHER = 200;

class Choices {
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
    // One after the other, but for a page that is left: it waits for nothing.
    const tell = async () => {
      for (const change of all) await askJson("choices", change, leaves ? { keepalive: true } : {});
    };
    const told = leaves ? tell() : this.sent.then(tell);
    this.sent = told.catch(() => null);
    return told;
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
