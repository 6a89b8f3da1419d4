// The state of the session and its meshes: each mesh is fetched once, and only the changes if a related mesh is loaded.

import { during } from "../../report/viewer/activity.js";
import { ORIGIN, vertexNormals } from "../../report/viewer/geometry.js";
import { askArrays, askJson, numbersAfter } from "./net.js";
import { tr } from "./strings.js";

/** Number of meshes kept in memory besides the shown ones. */
const KEPT_MESHES = 4;
/** Number of faces from which on a mesh has a coarse version. */
const HUGE = 2_000_000;
/** The lists of the state of which only changes are sent. */
const LISTS = ["states", "holes"];

/** The state that the program sent, completed with the members and rows that it left out, since the page has them in `known`. */
function completed(sent, known) {
  const old = sent.known === undefined ? {} : known, state = { ...old, ...sent };
  const rows = ([first, end, id], list) => list.slice(first, end).map((row, i) => ({ ...row, id: id + i }));
  for (const name of LISTS) if (sent[name]) state[name] = sent[name].flatMap((part) => Array.isArray(part) ? rows(part, old[name]) : [part]);
  return state;
}

/** The number of items in ranges. */
const countOf = (ranges) => ranges.reduce((sum, x, i) => sum + (i % 2 ? x : -x), 0);

/**
 * A simplified version of a mesh after a step: its faces for which the face of the mesh and all corners are kept, and all new faces.
 * `vertex` and `face` have the new numbers.
 */
function levelAfter(old, vertex, face, first, faces) {
  const corners = [], numbers = [];
  for (let i = 0; i < old.numbers.length; i++) {
    const number = face[old.numbers[i]] ?? -1, [a, b, c] = [0, 1, 2].map((k) => vertex[old.faces[3 * i + k]] ?? -1);
    if (number < 0 || a < 0 || b < 0 || c < 0) continue;
    corners.push(a, b, c);
    numbers.push(number);
  }
  for (let f = first; f < faces.length / 3; f++) {
    corners.push(faces[3 * f], faces[3 * f + 1], faces[3 * f + 2]);
    numbers.push(f);
  }
  return { faces: Uint32Array.from(corners), numbers: Uint32Array.from(numbers) };
}

/** The items of an array in the given ranges, followed by `extra`; `parts` numbers an item. */
function gathered(values, parts, ranges, extra) {
  let count = extra.length;
  for (let i = 0; i < ranges.length; i += 2) count += parts * (ranges[i + 1] - ranges[i]);
  const all = new values.constructor(count);
  let at = 0;
  for (let i = 0; i < ranges.length; i += 2) {
    const part = values.subarray(parts * ranges[i], parts * ranges[i + 1]);
    all.set(part, at);
    at += part.length;
  }
  all.set(extra, at);
  return all;
}

/** The packed facts of the faces of a state: origin and region. */
function stateFacts(origin, region, count) {
  const facts = new Uint32Array(count);
  for (let i = 0; i < count; i++) facts[i] = origin[i] << ORIGIN | region[i];
  return facts;
}

/** Decodes runs (first face and value) to one value per face. */
function spread(runs, count) {
  const all = new Uint32Array(count);
  for (let i = 0; i < runs.length; i += 2) all.fill(runs[i + 1], runs[i], runs[i + 2] ?? count);
  return all;
}

/** Faces with the new numbers of their vertices, after only the vertices in the ranges were kept. */
function renumbered(faces, ranges) {
  if (ranges.length <= 2 && !ranges[0]) return faces;
  const shift = new Int32Array(ranges[ranges.length - 1] || 0);
  for (let i = 0, at = 0; i < ranges.length; i += 2) {
    shift.fill(ranges[i] - at, ranges[i], ranges[i + 1]);
    at += ranges[i + 1] - ranges[i];
  }
  return faces.map((v) => v - shift[v]);
}

export class Model {
  constructor() {
    this.meshes = new Map();
    this.rims = new Map();
    this.coarse = new Map();
    /** The large meshes that are here and prepared. */
    this.whole = new Set();
    this.values = new Map();
    this.state = null;
  }

  /** Fetches the state: only the changes if the page has one. Of two answers that cross, the later state counts. */
  async fetchState() {
    const known = this.state, state = completed(await askJson(known ? `state?known=${known.revision}` : "state"), known);
    if (!this.state || state.revision >= this.state.revision) this.state = state;
    return this.state;
  }

  /** The state with the given number. */
  find(id) {
    return this.state.states.find((s) => s.id === id);
  }

  get current() {
    return this.find(this.state.current);
  }

  /** The mesh of a state, with its rims. */
  async mesh(id) {
    if (!this.meshes.has(id)) {
      const made = Promise.all([this.fetchMesh(id), this.rimsOf(id)]).then(([mesh, rims]) => Object.assign(mesh, rims));
      made.catch(() => this.meshes.delete(id));
      this.meshes.set(id, made);
    }
    return this.meshes.get(id);
  }

  /** The number of a mesh on the page that a mesh was made from, or that was made from it. */
  near(id) {
    return [this.find(id)?.parent, ...this.state.states.filter((s) => s.parent === id).map((s) => s.id)].find((other) => this.meshes.has(other));
  }

  /** The mesh of a state to show first: the coarse version if it is large, and neither it nor a related mesh is here. */
  firstMesh(id) {
    const isCoarse = this.find(id).faces >= HUGE && !this.whole.has(id) && this.near(id) === undefined;
    return isCoarse ? this.coarseMesh(id) : this.mesh(id);
  }

  /** The mesh of a large state, once it has been prepared. */
  async wholeMesh(id) {
    const [mesh, { clusters }] = await Promise.all([this.mesh(id), this.coarseMesh(id)]);
    mesh.levels.clusters = { faces: clusters.faces.map((v) => clusters.vertices[v]), numbers: clusters.numbers };
    await this.prepare(mesh);
    this.whole.add(id);
    this.coarse.delete(id);
    return mesh;
  }

  /** The coarse version of a large mesh, as a mesh of its own. */
  coarseMesh(id) {
    if (!this.coarse.has(id)) {
      const made = Promise.all([askArrays(`coarse/${id}`), this.rimsOf(id)]).then(([{ header, arrays }, rims]) => {
        const { positions, faces, origin, region, numbers, vertices } = arrays, facts = stateFacts(origin, region, faces.length / 3);
        const shape = { positions, faces, facts, normals: vertexNormals(positions, faces), centre: header.centre };
        return { id, coarse: true, levels: {}, ...shape, marks: origin.includes(1) || origin.includes(2), earlier: 0.35, clusters: { faces, numbers, vertices }, ...rims };
      });
      made.catch(() => this.coarse.delete(id));
      this.coarse.set(id, made);
    }
    return this.coarse.get(id);
  }

  async fetchMesh(id) {
    const near = this.near(id), old = near === undefined ? null : await this.meshes.get(near).catch(() => null);
    const { header, arrays } = await askArrays(`mesh/${id}` + (old ? `?from=${near}` : ""));
    let { positions, faces, origin, region } = arrays, parent = null, levels = {};
    if (Number.isInteger(header.from)) {
      const { kept_vertices: vertices, kept_faces: kept } = arrays;
      positions = gathered(old.positions, 3, vertices, positions);
      faces = gathered(renumbered(gathered(old.faces, 3, kept, new Uint32Array()), vertices), 3, [0, countOf(kept)], faces);
      const vertex = numbersAfter(vertices), face = numbersAfter(kept), first = countOf(kept);
      levels = Object.fromEntries(Object.entries(old.levels).map(([name, level]) => [name, levelAfter(level, vertex, face, first, faces)]));
      if (near === this.find(id)?.parent) parent = { mesh: old, kept, replaced: arrays.replaced };
      [origin, region] = [spread(arrays.origin_runs, faces.length / 3), spread(arrays.region_runs, faces.length / 3)];
    }
    const facts = stateFacts(origin, region, faces.length / 3), fresh = origin.includes(1) || origin.includes(2);
    return { id, positions, faces, facts, normals: vertexNormals(positions, faces), marks: fresh, earlier: 0.35, centre: header.centre, parent, levels };
  }

  /** The rims of a mesh. */
  rimsOf(id) {
    if (!this.rims.has(id)) {
      const made = this.fetchRims(id);
      made.catch(() => this.rims.delete(id));
      this.rims.set(id, made);
    }
    return this.rims.get(id);
  }

  async fetchRims(id) {
    const near = this.near(id), old = near === undefined ? null : await this.rimsOf(near).catch(() => null);
    const { arrays: { parts, points, starts } } = await askArrays(`rims/${id}` + (old ? `?from=${near}` : ""));
    const rims = [], rimIds = [];
    for (let i = 0, own = 0; i < parts.length; i += 3) {
      const [first, end, number] = parts.subarray(i, i + 3);
      for (let k = first; k < end; k++) {
        rims.push(old.rims[k]);
        rimIds.push(number + k - first);
      }
      if (end > first) continue;
      rims.push(points.subarray(3 * starts[own], 3 * starts[own + 1]));
      rimIds.push(number);
      own++;
    }
    return { rims, rimIds };
  }

  /** Values to colour a state, with their header. Values measured from a file are not cached, since the file may change. */
  async valuesOf(id, name, more = "") {
    const key = `${id}?name=${encodeURIComponent(name)}${more}`;
    if (/&file=/.test(more)) return askArrays("values/" + key);
    if (!this.values.has(key)) {
      const got = askArrays("values/" + key);
      got.catch(() => this.values.delete(key));
      this.values.set(key, got);
      for (const old of [...this.values.keys()].slice(0, -6)) this.values.delete(old);
    }
    return this.values.get(key);
  }

  /** Drops the oldest unused meshes, except the last [KEPT_MESHES]. */
  forget(used) {
    const gone = [...this.meshes.keys()].filter((id) => !used.includes(id)).slice(0, -KEPT_MESHES);
    for (const id of gone) for (const kept of [this.meshes, this.rims, this.whole]) kept.delete(id);
  }

  /** Lets the worker compute the adjacency of a mesh, the order of its faces and a coarse version. */
  prepare(mesh) {
    return mesh.prepared ??= this.work({ positions: mesh.positions, faces: mesh.faces }).then((found) => {
      mesh.order = found.order;
      if (found.thin) mesh.levels.thin = found.thin;
      return found;
    });
  }

  /** Lets the worker compute the part of the ambient light that reaches each vertex. */
  ambient(mesh) {
    return mesh.ambient ??= this.work({ positions: mesh.positions, faces: mesh.faces, normals: mesh.normals });
  }

  /** Sends a message to a worker of its own, and returns the answer. */
  work(message) {
    return during("worker", () => new Promise((done, failed) => {
      const worker = new Worker("worker.js");
      worker.onmessage = ({ data }) => {
        worker.terminate();
        done(data);
      };
      worker.onerror = (event) => failed(new Error(tr("not_prepared", { error: event.message })));
      worker.postMessage(message);
    }));
  }
}
