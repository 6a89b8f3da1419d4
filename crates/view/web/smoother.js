// The smoothing brush: a stroke marks faces beside the mask, and at its end a step fairs just these faces.

import { STROKE } from "../../report/viewer/geometry.js";
import { find, numberIn } from "../../report/viewer/controls.js";
import { runsOf } from "./net.js";
import { holesAt } from "./rims.js";
import { tr } from "./strings.js";

/** Upper bound of the strength, in mean edges. */
const MAX_EDGES = 100;

export class Smoother {
  constructor(app) {
    this.app = app;
    /** Strength: features narrower than this disappear. In mean edges of the mesh. */
    this.edges = numberIn(find("#smoother-edges").value);
    /** The mesh and the faces of the stroke that is drawn, or whose step runs. */
    this.mesh = null;
    this.faces = [];
    find("#smoother-edges").addEventListener("input", () => {
      const edges = numberIn(find("#smoother-edges").value), right = edges > 0 && edges <= MAX_EDGES;
      find("#smoother-edges").setAttribute("aria-invalid", !right);
      if (right) this.edges = edges;
    });
  }

  /** What a stroke of the brush does; refused while a step runs. */
  ink({ mesh }) {
    if (this.app.steps.job) {
      this.app.painted(tr("smoother_waits"), true);
      return null;
    }
    this.clear();
    this.mesh = mesh;
    return { put: (faces) => this.add(faces), end: (broken) => broken ? this.clear() : this.run() };
  }

  /** Marks the faces of the stroke, but for those at rims, with which the holes would be closed; returns the range of changed faces, or null. */
  add(faces) {
    const { facts } = this.mesh;
    let first = Infinity, end = 0;
    for (const face of faces) {
      if (facts[face] & STROKE || holesAt(this.mesh, face).length) continue;
      facts[face] |= STROKE;
      this.faces.push(face);
      first = Math.min(first, face);
      end = Math.max(end, face + 1);
    }
    return first < end ? [first, end] : null;
  }

  /** Fairs the faces of the stroke; the marked faces stay as they are. */
  run() {
    const { app, mesh, faces } = this;
    if (!faces.length) return undefined;
    const on = new Uint8Array(mesh.faces.length / 3), strength = Number((this.edges * app.meanEdge()).toPrecision(3));
    for (const face of faces) on[face] = 1;
    const params = { ...app.model.state.defaults.fair, extent: { strength } };
    const label = ["isomend", "fair", "--faces mask.txt", "--strength", strength].join(" ");
    return app.attempt("#paint-trouble", () => app.steps.request(label, { kind: "fair", params, mask: runsOf(on), keep_marks: true }));
  }

  /** Clears the faces of the stroke. */
  clear() {
    const { mesh, faces } = this, surface = mesh && this.app.viewer.surfaces.get(mesh);
    for (const face of faces) mesh.facts[face] &= ~STROKE;
    if (faces.length) surface?.changed();
    if (faces.length) this.app.viewer.refresh();
    this.mesh = null;
    this.faces = [];
  }
}
