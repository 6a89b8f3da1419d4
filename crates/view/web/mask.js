// The marked faces of a mesh, with undo and redo of strokes; face numbers from text.

import { MASKED } from "../../report/viewer/geometry.js";
import { numbersAfter, runsOf } from "./net.js";
import { tr } from "./strings.js";

/** Upper bound of the number of strokes that can be undone. */
const MOST_STROKES = 200;

export class Mask {
  constructor(mesh) {
    this.mesh = mesh;
    this.on = new Uint8Array(mesh.faces.length / 3);
    this.count = 0;
    /** Number of changes of marks: until now, and until they were last sent to the program. */
    this.changes = this.sent = 0;
    this.done = [];
    this.undone = [];
    this.stroke = null;
    /** Whether the marks are drawn. */
    this.isShown = true;
  }

  /** Draws the marks, or hides them on a mesh that the current one is compared with; returns whether the picture changes. */
  show(isShown) {
    const { facts } = this.mesh, differs = this.isShown !== isShown;
    this.isShown = isShown;
    if (differs) for (let f = 0; f < this.on.length; f++) if (this.on[f]) facts[f] = isShown ? facts[f] | MASKED : facts[f] & ~MASKED;
    return differs && this.count > 0;
  }

  /** Marks or unmarks faces; returns the range of changed faces, or null. */
  set(faces, value) {
    const { facts } = this.mesh;
    let first = Infinity, end = 0;
    for (const face of faces) {
      if (this.on[face] === value) continue;
      this.on[face] = value;
      facts[face] = value && this.isShown ? facts[face] | MASKED : facts[face] & ~MASKED;
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

  /** Ends a stroke, which can be undone as a whole; returns whether it changed anything. */
  end() {
    const { stroke } = this;
    this.stroke = null;
    if (!stroke?.length) return false;
    this.done.push(Uint32Array.from(stroke));
    this.undone = [];
    if (this.done.length > MOST_STROKES) this.done.shift();
    return true;
  }

  /** Marks exactly the faces for which `wanted` is true, as one stroke; returns the number of changes. */
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

  /** Reverses the last stroke of one list and moves it to the other: undo and redo. */
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

  /**
   * Takes over the strokes of the mesh before a step: on its `kept` faces (ranges), and on faces that replace others (pairs of an old and
   * a new face). Only if both meshes have the same marks, since strokes reverse marks.
   */
  inherit(before, { kept, replaced }) {
    if (!before.done.length && !before.undone.length) return;
    const numbers = numbersAfter(kept), others = new Map();
    for (let i = 0; i < replaced.length; i += 2) others.set(replaced[i], [...others.get(replaced[i]) || [], replaced[i + 1]]);
    const places = (face) => [...numbers[face] >= 0 ? [numbers[face]] : [], ...others.get(face) || []];
    const on = new Uint8Array(this.on.length);
    for (let old = 0; old < before.on.length; old++) if (before.on[old]) for (const face of places(old)) on[face] = 1;
    if (on.some((mark, face) => mark !== this.on[face])) return;
    const moved = (strokes) => strokes.map((stroke) => Uint32Array.from([...stroke].flatMap(places))).filter((stroke) => stroke.length);
    this.done = moved(before.done);
    this.undone = moved(before.undone);
  }

  /** Sets the marks that the program has; returns whether they differ from the present ones. */
  take(runs) {
    const wanted = new Uint8Array(this.on.length), marked = [], cleared = [];
    for (const [first, end] of runs) wanted.fill(1, first, end);
    for (let f = 0; f < wanted.length; f++) if (wanted[f] !== this.on[f]) (wanted[f] ? marked : cleared).push(f);
    this.set(marked, 1);
    this.set(cleared, 0);
    this.sent = this.changes;
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
  const isArray = trimmed.startsWith("["), words = isArray ? JSON.parse(trimmed) : trimmed.split(/\s+/).filter(Boolean), numbers = isArray ? words : words.map(Number);
  const wrong = numbers.findIndex((n) => !Number.isInteger(n) || n < 0 || n >= count);
  if (wrong >= 0) throw new Error(tr("no_face_number", { wrong: String(words[wrong]).slice(0, 20), last: count - 1 }));
  return numbers;
}
