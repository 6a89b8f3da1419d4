// The marked faces of a mesh, and what was marked when.

import { MASKED } from "../../report/viewer/geometry.js";
import { runsOf } from "./net.js";
import { tr } from "./strings.js";

/** Strokes that can be taken back. */
const MOST_STROKES = 200;

export class Mask {
  constructor(mesh) {
    this.mesh = mesh;
    this.on = new Uint8Array(mesh.faces.length / 3);
    this.count = 0;
    /** How often marks were changed here, and how often when that was told last. */
    this.changes = this.told = 0;
    this.done = [];
    this.undone = [];
    this.stroke = null;
  }

  /** Marks faces, or takes their marks; the range of those that changed. */
  set(faces, value) {
    const { facts } = this.mesh;
    let first = Infinity, end = 0;
    for (const face of faces) {
      if (this.on[face] === value) continue;
      this.on[face] = value;
      facts[face] = value ? facts[face] | MASKED : facts[face] & ~MASKED;
      this.count += value ? 1 : -1;
      this.stroke?.push(face);
      first = Math.min(first, face);
      end = Math.max(end, face + 1);
    }
    if (first < end) this.changes++;
    return first < end ? [first, end] : null;
  }

  begin() {
    this.stroke = [];
  }

  /** Ends a stroke: it can be taken back as one. Whether it changed anything. */
  end() {
    const { stroke } = this;
    this.stroke = null;
    if (!stroke?.length) return false;
    this.done.push(Uint32Array.from(stroke));
    this.undone = [];
    if (this.done.length > MOST_STROKES) this.done.shift();
    return true;
  }

  /** Marks what a function tells of each face: one stroke. */
  change(wanted) {
    const marked = [], cleared = [];
    for (let f = 0; f < this.on.length; f++) {
      const want = wanted(f) ? 1 : 0;
      if (want !== this.on[f]) (want ? marked : cleared).push(f);
    }
    this.begin();
    this.set(marked, 1);
    this.set(cleared, 0);
    this.end();
    return marked.length + cleared.length;
  }

  /** Takes the last stroke back, or does it once more. */
  turn(from, to) {
    const stroke = from.pop();
    if (!stroke) return false;
    const marked = stroke.filter((f) => this.on[f]), rest = stroke.filter((f) => !this.on[f]);
    this.set(marked, 0);
    this.set(rest, 1);
    to.push(stroke);
    return true;
  }

  undo() {
    return this.turn(this.done, this.undone);
  }

  redo() {
    return this.turn(this.undone, this.done);
  }

  runs() {
    return runsOf(this.on);
  }

  /** Takes marks that are known already; whether they are others. */
  take(runs) {
    const wanted = new Uint8Array(this.on.length), marked = [], cleared = [];
    for (const [first, end] of runs) wanted.fill(1, first, end);
    for (let f = 0; f < wanted.length; f++) if (wanted[f] !== this.on[f]) (wanted[f] ? marked : cleared).push(f);
    this.set(marked, 1);
    this.set(cleared, 0);
    this.told = this.changes;
    if (marked.length || cleared.length) {
      this.done = [];
      this.undone = [];
    }
    return marked.length + cleared.length > 0;
  }
}

/** Face numbers from the text of a `--faces` file: one a line, or a JSON array. */
export function facesOf(text, count) {
  const trimmed = text.trim();
  const numbers = trimmed.startsWith("[") ? JSON.parse(trimmed) : trimmed.split(/\s+/).filter(Boolean).map(Number);
  const wrong = Array.isArray(numbers) ? numbers.find((n) => !Number.isInteger(n) || n < 0 || n >= count) : trimmed.slice(0, 20);
  if (wrong !== undefined) throw new Error(tr("no_face_number", { wrong, last: count - 1 }));
  return numbers;
}
