// The hole in the bottom of what stands, such as a vase: "Make printable" closes it flat, so that the print stands.

import { find } from "../../report/viewer/controls.js";
import { dot } from "../../report/viewer/camera.js";
import { rimFacing } from "../../report/viewer/geometry.js";
import { tr } from "./strings.js";

/** Fraction of the height: the rim of a hole in the bottom is at most this far above the lowest point. */
const BOTTOM_HEIGHT = 0.05;
/** Least diameter of such a hole, as a fraction of the extent across. */
const BOTTOM_WIDTH = 0.2;
/** Cosine of the largest angle between its direction and straight down (26°). */
const BOTTOM_DOWN = 0.9;

export class Bottom {
  constructor(app) {
    this.app = app;
    this.wanted = true;
    find("#bottom-words").textContent = tr("flat_bottom", { id: "–" });
    find("#flat-bottom").addEventListener("change", () => this.set(find("#flat-bottom").checked));
  }

  /** The number of the hole in the bottom of the current mesh, or null. */
  get hole() {
    const { app } = this, mesh = app.mesh(), up = app.views.up(), name = up.join();
    if (!mesh) return null;
    if (mesh.bottom?.name !== name) mesh.bottom = { name, id: this.search(mesh, up) };
    return mesh.bottom.id;
  }

  search(mesh, up) {
    const [low, high] = this.app.model.state.bounds, k = up.findIndex((x) => x), size = high.map((x, i) => x - low[i]);
    const lowest = up[k] > 0 ? low[k] - mesh.centre[k] : mesh.centre[k] - high[k], across = Math.max(...size.filter((_, i) => i !== k));
    const isBottom = ({ id, diameter }) => {
      const rim = mesh.rims[mesh.rimIds.indexOf(id)], towards = rim ? rimFacing(rim) : [0, 0, 0];
      if (!rim || diameter < BOTTOM_WIDTH * across || -dot(towards, up) < BOTTOM_DOWN * Math.hypot(...towards)) return false;
      for (let i = k; i < rim.length; i += 3) if (up[k] * rim[i] - lowest > BOTTOM_HEIGHT * size[k]) return false;
      return true;
    };
    return this.app.holes.list.find(isBottom)?.id ?? null;
  }

  /** Chooses whether a repair closes the hole in the bottom flat; to fill holes, it stays as it is set there. */
  set(isFlat) {
    const { hole, app } = this;
    this.wanted = isFlat;
    if (!isFlat && app.holes.doings.get(hole) === "flat") app.holes.put([[hole, "fill"]]);
    app.holes.changed();
  }

  /** The hole in the bottom, if a repair is to close it flat although nothing is set for it, in a list. */
  caps() {
    const { hole } = this;
    return this.wanted && hole !== null && this.app.holes.doings.get(hole) === "fill" ? [hole] : [];
  }

  /** Shows whether it is closed flat. */
  show() {
    const { hole } = this;
    find("#bottom-row").hidden = hole === null;
    if (hole === null) return;
    find("#flat-bottom").checked = this.caps().length > 0 || this.app.holes.doings.get(hole) === "flat";
    find("#bottom-words").textContent = tr("flat_bottom", { id: hole });
  }
}
