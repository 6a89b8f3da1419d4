// The state of the session and its meshes: each mesh is fetched once, and only the changes if a related mesh is loaded.

import { ORIGIN, vertexNormals } from "../../report/viewer/geometry.js";
import { askArrays, askJson } from "./net.js";
import { tr } from "./strings.js";

/** Number of meshes kept in memory besides the shown ones. */
const KEPT_MESHES = 4;

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
    this.values = new Map();
    this.state = null;
  }

  async fetchState() {
    return this.state = await askJson("state");
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
      const made = Promise.all([this.fetchMesh(id), this.fetchRims(id)]).then(([mesh, rims]) => Object.assign(mesh, rims));
      made.catch(() => this.meshes.delete(id));
      this.meshes.set(id, made);
    }
    return this.meshes.get(id);
  }

  async fetchMesh(id) {
    const near = [this.find(id)?.parent, ...this.state.states.filter((s) => s.parent === id).map((s) => s.id)].find((other) => this.meshes.has(other));
    const old = near === undefined ? null : await this.meshes.get(near).catch(() => null);
    const { header, arrays } = await askArrays(`mesh/${id}` + (old ? `?from=${near}` : ""));
    let { positions, faces, origin, region } = arrays, parent = null;
    if (Number.isInteger(header.from)) {
      const { kept_vertices: vertices, kept_faces: kept } = arrays;
      positions = gathered(old.positions, 3, vertices, positions);
      faces = gathered(renumbered(gathered(old.faces, 3, kept, new Uint32Array()), vertices), 3, [0, kept.reduce((n, x, i) => n + (i % 2 ? x : -x), 0)], faces);
      if (near === this.find(id)?.parent) parent = { mesh: old, kept, replaced: arrays.replaced };
      [origin, region] = [spread(arrays.origin_runs, faces.length / 3), spread(arrays.region_runs, faces.length / 3)];
    }
    const facts = stateFacts(origin, region, faces.length / 3), fresh = origin.includes(1) || origin.includes(2);
    return { id, positions, faces, facts, normals: vertexNormals(positions, faces), marks: fresh, earlier: 0.35, centre: header.centre, parent };
  }

  async fetchRims(id) {
    const { arrays: { points, starts, ids } } = await askArrays(`rims/${id}`);
    const rims = [], numbers = [...(ids || [])];
    for (let i = 0; i + 1 < starts.length; i++) rims.push(points.subarray(3 * starts[i], 3 * starts[i + 1]));
    return { rims, rimIds: numbers };
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
    for (const id of gone) this.meshes.delete(id);
  }

  /** Lets the worker compute the adjacency of a mesh, the order of its faces and a coarse version. */
  prepare(mesh) {
    return mesh.prepared ??= this.work({ positions: mesh.positions, faces: mesh.faces });
  }

  /** Lets the worker compute the part of the ambient light that reaches each vertex. */
  ambient(mesh) {
    return mesh.ambient ??= this.work({ positions: mesh.positions, faces: mesh.faces, normals: mesh.normals });
  }

  /** Sends a message to a worker of its own, and returns the answer. */
  work(message) {
    return new Promise((done, failed) => {
      const worker = new Worker("worker.js");
      worker.onmessage = ({ data }) => {
        worker.terminate();
        done(data);
      };
      worker.onerror = (event) => failed(new Error(tr("not_prepared", { error: event.message })));
      worker.postMessage(message);
    });
  }
}
