// The map of overhangs: faces that lean over more than a limit that is dragged, for a direction in which the mesh stands.

import { find, digits, numberIn, rising, showScale } from "../../report/viewer/controls.js";
import { measuredFaces, sumOf } from "./faces.js";
import { counts, tr } from "./strings.js";

/** Fraction of the extent: faces this near to the lowest point lie on the plate. */
const ON_PLATE = 1 / 500;
/** Faces on the plate face down within 10 degrees: the sine of the angle against the vertical. */
const FLAT = Math.sin(80 * Math.PI / 180);
const DEGREES = 180 / Math.PI;
const UP_AXES = ["X", "Y", "Z"];

/** The middle height of a face along an axis. */
const heightOf = ({ positions: p, faces }, f, k) => (p[3 * faces[3 * f] + k] + p[3 * faces[3 * f + 1] + k] + p[3 * faces[3 * f + 2] + k]) / 3;

/** Whether a face lies on the plate, if the mesh stands on the side `sign` of the axis `k`. `ends` are its lowest and highest coordinates. */
function isOnPlate(mesh, f, k, sign, down, ends) {
  if (down < FLAT) return false;
  const [low, high] = ends, bottom = sign > 0 ? low[k] : -high[k];
  return sign * heightOf(mesh, f, k) - bottom < ON_PLATE * (high[k] - low[k]);
}

/** For each face its angle against the vertical, in degrees: 90 for a level ceiling; NaN if it does not face down or lies on the plate. */
export function overhangAngles(mesh, up, ends) {
  const { normals } = measuredFaces(mesh), angles = new Float32Array(normals.length / 3), k = up.findIndex((x) => x), sign = up[k];
  for (let f = 0; f < angles.length; f++) {
    const down = -sign * normals[3 * f + k];
    angles[f] = down <= 0 || isOnPlate(mesh, f, k, sign, down, ends) ? NaN : Math.asin(Math.min(1, down)) * DEGREES;
  }
  return angles;
}

/** For each direction that could point up, the area that needs support and the area on the plate. */
export function standings(mesh, degrees, ends) {
  const { normals, areas } = measuredFaces(mesh), least = Math.sin(degrees / DEGREES);
  const found = UP_AXES.flatMap((name, k) => [1, -1].map((sign) => ({ name: (sign > 0 ? "+" : "-") + name, k, sign, support: 0, stands: 0 })));
  for (let f = 0; f < areas.length; f++) {
    for (let k = 0; k < 3; k++) {
      const x = normals[3 * f + k], down = Math.abs(x);
      if (down <= least) continue;
      const way = found[2 * k + (x < 0 ? 0 : 1)];
      if (isOnPlate(mesh, f, k, way.sign, down, ends)) way.stands += areas[f];
      else way.support += areas[f];
    }
  }
  return found;
}

export class Overhangs {
  constructor(app) {
    this.app = app;
    const range = find("#overhang-range"), field = find("#overhang-angle");
    range.addEventListener("input", () => { field.value = range.value; this.show(); });
    range.addEventListener("change", () => this.list());
    field.addEventListener("input", () => {
      const degrees = numberIn(field.value), right = degrees >= 0 && degrees < 90;
      field.setAttribute("aria-invalid", !right);
      if (!right) return;
      range.value = degrees;
      this.show();
      this.list();
    });
  }

  get limit() {
    return Number(find("#overhang-range").value);
  }

  /** The lowest and the highest coordinates of the current mesh, relative to the scene's centre. */
  ends(mesh) {
    return this.app.model.state.bounds.map((corner) => corner.map((x, k) => x - mesh.centre[k]));
  }

  /** Colours a surface. */
  colour(surface) {
    const { mesh } = surface, up = this.app.views.up(), name = up.join();
    if (mesh.overhangs?.name !== name) mesh.overhangs = { name, angles: overhangAngles(mesh, up, this.ends(mesh)) };
    surface.setColour({ kind: 5, values: mesh.overhangs.angles, on: 1, span: [0, 90], limits: [-1, 1] });
    this.show();
    this.list();
  }

  /** Shows the limit: in the colours, the legend, and the count of what overhangs more. */
  show() {
    const { app, limit } = this, mesh = app.mesh(), surface = app.viewer.surfaces.get(mesh);
    if (!mesh?.overhangs || surface?.colour.kind !== 5 || app.display.colour !== "overhangs") return;
    surface.colour.limits = [-1, limit / 90];
    showScale(tr("scale_overhangs"), "0°", "90°", 2);
    const place = 100 * limit / 90, stops = [0, 1 / 3, 2 / 3, 1].map((x) => `${rising(x)} ${place * x}%`);
    find("#scale-bar").style.background = `linear-gradient(90deg, ${stops}, var(--fault) ${place}%)`;
    const { count, area, all } = sumOf(mesh, mesh.overhangs.angles, (angle) => angle > limit);
    find("#overhangs-said").textContent = tr("overhangs_steeper", { faces: counts("face", count), area: app.measure.format(area, 2), share: digits(Number((100 * area / (all || 1)).toPrecision(3))) });
    find("#overhangs-said").dataset.bad = Boolean(count);
    app.viewer.moving();
  }

  /** Lists the standings in which the mesh can stand, the present one marked; a click turns the mesh. */
  list() {
    const mesh = this.app.mesh(), up = this.app.views.up();
    if (!mesh) return;
    const { format } = this.app.measure, write = (area) => format.call(this.app.measure, area, 2);
    find("#stand-list").replaceChildren(...standings(mesh, this.limit, this.ends(mesh)).map(({ name, k, sign, support, stands }) => {
      const item = document.createElement("li"), button = Object.assign(document.createElement("button"), { type: "button" });
      button.append(...[name.replace("-", "−"), write(support), write(stands)].map((textContent) => Object.assign(document.createElement("span"), { textContent })));
      button.setAttribute("aria-pressed", up[k] === sign);
      button.addEventListener("click", () => {
        find("#up").value = name;
        find("#up").dispatchEvent(new Event("change"));
      });
      item.append(button);
      return item;
    }));
  }
}
