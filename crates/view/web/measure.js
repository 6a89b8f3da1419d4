// Measurements: distances, angles, thickness, sizes of the mesh, outline of the section; with the chosen unit of length.

import { cross, dot, minus, plus, times } from "../../report/viewer/camera.js";
import { cornersOf } from "../../report/viewer/geometry.js";
import { digits, find, newButton } from "../../report/viewer/controls.js";
import { lineSizes, planeAxes, sectionLines, svgOf } from "./outline.js";
import { symbolOf, useUnits } from "./deliver.js";
import { has, tr } from "./strings.js";

/** The measuring tools, with the number of points that each takes. */
export const MEASURES = { distance: 2, angle: 3, thickness: 1 };
/** The program's names for the unit of lengths. */
const LENGTHS = ["length", "in the mesh's units"];
const DRAWN = "http://www.w3.org/2000/svg";

/** Distance along a ray to the next face whose normal points along the ray; null if there is none. */
function nextFace({ positions: p, faces }, from, way, least) {
  let best = Infinity;
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const e = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]], g = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
    const h = cross(way, g), det = dot(e, h);
    // The far side faces along the ray. Faces next to the start face against it and do not count.
    if (!(det < 0)) continue;
    const d = [from[0] - p[a], from[1] - p[a + 1], from[2] - p[a + 2]], u = dot(d, h) / det;
    if (u < 0 || u > 1) continue;
    const q = cross(d, e), v = dot(way, q) / det, t = dot(g, q) / det;
    if (v >= 0 && u + v <= 1 && t > least && t < best) best = t;
  }
  return best < Infinity ? best : null;
}

/** The area of a mesh or of its marked faces, and the volume inside it if it is closed. */
export function sizesOf({ positions: p, faces }, on = null) {
  let area = 0, volume = 0;
  for (let f = 0; f < faces.length; f += 3) {
    if (on && !on[f / 3]) continue;
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ex = p[b] - p[a], ey = p[b + 1] - p[a + 1], ez = p[b + 2] - p[a + 2], gx = p[c] - p[a], gy = p[c + 1] - p[a + 1], gz = p[c + 2] - p[a + 2];
    const nx = ey * gz - ez * gy, ny = ez * gx - ex * gz, nz = ex * gy - ey * gx;
    area += Math.hypot(nx, ny, nz) / 2;
    volume += (nx * p[a] + ny * p[a + 1] + nz * p[a + 2]) / 6;
  }
  return { area, volume };
}

export class Measure {
  constructor(app) {
    this.app = app;
    this.points = [];
    this.items = [];
    this.outline = null;
    useUnits(() => this.changedUnit());
    find("#measure-clear").addEventListener("click", () => this.clear());
    find("#outline").addEventListener("click", () => this.cutOutline());
    this.changedUnit();
  }

  /** The symbol of the chosen unit; without a choice, of the unit of the file, if it has one. */
  get unit() {
    return symbolOf(find("#unit").value || this.app.model.state.file.unit);
  }

  /** A length, area or volume with its unit. */
  format(value, power = 1) {
    return digits(value) + (this.unit ? ` ${this.unit}${["", "", "²", "³"][power]}` : "");
  }

  /** The unit of values after a comma; lengths have the chosen unit, other units are the program's. */
  unitOf(unit) {
    if (!unit) return "";
    if (this.unit && LENGTHS.includes(unit)) return ", " + this.unit;
    if (this.unit && unit === "1/length") return `, 1/${this.unit}`;
    return ", " + (has("unit_" + unit) ? tr("unit_" + unit) : unit);
  }

  changedUnit() {
    document.querySelectorAll(".unit").forEach((element) => { element.textContent = this.unit; });
    find("[data-sort=diameter]").textContent = this.unit ? `⌀ ${this.unit}` : tr("column_diameter");
    this.app.views?.drawn();
    if (this.app.deliver) this.app.holes.filter();
    this.app.deliver?.changed();
    this.app.aspects?.changedUnit();
    this.list();
  }

  /** Handles a click on the surface with a measuring tool. */
  click(tool, { point, face, aim }) {
    if (!point) return this.app.say(tr("no_surface"), true);
    const mesh = this.app.viewer.sides[aim.side].mesh;
    this.points.push(point);
    if (tool === "thickness") this.thickness(mesh, point, face);
    else if (this.points.length === MEASURES[tool]) this.finish(tool, this.points);
    else this.app.say(tr("measure_next", { number: this.points.length + 1, of: MEASURES[tool] }));
    this.draw();
    return undefined;
  }

  thickness(mesh, point, face) {
    const [a, b, c] = cornersOf(mesh, face), normal = cross(minus(b, a), minus(c, a)), inward = times(normal, -1 / (Math.hypot(...normal) || 1));
    const far = nextFace(mesh, point, inward, 1e-6 * this.app.viewer.camera.radius);
    this.points = [];
    if (far === null) return this.app.say(tr("no_other_side"), true);
    return this.finish("thickness", [point, plus(point, times(inward, far))]);
  }

  finish(kind, points) {
    const [a, b, c] = points;
    let value = Math.hypot(...minus(a, b));
    if (kind === "angle") {
      const d = minus(a, b), e = minus(c, b);
      value = Math.acos(Math.min(1, Math.max(-1, dot(d, e) / (Math.hypot(...d) * Math.hypot(...e) || 1)))) * 180 / Math.PI;
    }
    this.points = [];
    this.items.push({ kind, points, value });
    this.list();
    this.app.say(`${tr("tool_" + kind)}: ${this.valueOf({ kind, value })}`);
  }

  valueOf({ kind, value }) {
    return kind === "angle" ? digits(value) + "°" : this.format(value);
  }

  /** Deletes all measurements. */
  clear() {
    this.items = [];
    this.clearOutline();
    this.cancel();
  }

  cancel() {
    this.points = [];
    this.list();
    this.draw();
  }

  list() {
    find("#measures").replaceChildren(...this.items.map((item, i) => {
      const row = document.createElement("li"), drop = newButton("×", () => { this.items.splice(i, 1); this.list(); this.draw(); });
      drop.setAttribute("aria-label", tr("measure_drop", { number: i + 1 }));
      row.append(`${i + 1} ${tr("tool_" + item.kind)}`, Object.assign(document.createElement("b"), { textContent: this.valueOf(item) }), drop);
      return row;
    }));
    if (this.app.tab === "measure") this.sizes();
  }

  /** Lists extent, area and volume of the current mesh. */
  sizes() {
    const mesh = this.app.mesh(), list = find("#sizes"), rows = [];
    if (!mesh) return;
    const row = (name, value) => rows.push(Object.assign(document.createElement("dt"), { textContent: tr(name) }), Object.assign(document.createElement("dd"), { textContent: value }));
    const { area, volume } = mesh.sizes ??= sizesOf(mesh), [low, high] = this.app.model.state.bounds || [];
    if (low) row("size_box", high.map((x, k) => digits(x - low[k])).join(" × ") + (this.unit ? " " + this.unit : ""));
    row("size_area", this.format(area, 2));
    row("size_volume", mesh.rims.length ? tr("size_open") : this.format(Math.abs(volume), 3));
    if (mesh.mask?.count) row("size_marked", this.format(sizesOf(mesh, mesh.mask.on).area, 2));
    list.replaceChildren(...rows);
  }

  /** Draws all measurements over the view. */
  draw() {
    const { viewer } = this.app, pane = viewer.panes().find((p) => p.side === "after") || viewer.panes()[0], layer = find("#measure-marks"), parts = [];
    const part = (name, values, text) => {
      const made = document.createElementNS(DRAWN, name);
      for (const [key, value] of Object.entries(values)) made.setAttribute(key, value);
      if (text) made.textContent = text;
      parts.push(made);
    };
    const pending = this.points.length ? [{ points: this.points, value: null }] : [];
    for (const item of [...this.items, ...pending]) {
      const places = item.points.map((p) => viewer.onPage(p, pane));
      if (places.includes(null)) continue;
      part("polyline", { class: "measure-line", points: places.map((p) => p.map((x) => x.toFixed(1)).join(",")).join(" ") });
      for (const [cx, cy] of places) part("circle", { class: "measure-dot", cx: cx.toFixed(1), cy: cy.toFixed(1), r: 4 });
      const [from, to] = item.kind === "angle" ? [places[1], places[1]] : places, last = to || from;
      if (item.value !== null) part("text", { x: ((from[0] + last[0]) / 2).toFixed(1), y: ((from[1] + last[1]) / 2 - 8).toFixed(1) }, this.valueOf(item));
    }
    layer.replaceChildren(...parts);
    this.drawOutline(pane);
  }

  /** Computes the outline of the section: draws it, measures it, and saves it as SVG. */
  cutOutline() {
    const mesh = this.app.mesh(), { viewer } = this.app, normal = viewer.section.slice(0, 3);
    if (!mesh?.topology || !Math.hypot(...normal)) return this.app.say(tr("still_preparing"), true);
    const lines = sectionLines(mesh.topology, viewer.section), axes = planeAxes(normal);
    if (!lines.length) return this.app.say(tr("section_empty"), true);
    const { length, area } = lineSizes(lines, axes), svg = svgOf(lines, axes, this.unit);
    this.outline = lines;
    this.lastSvg = svg;
    this.draw();
    this.app.save.hand(new Blob([svg], { type: "image/svg+xml" }), "_section.svg");
    return this.app.say(tr("section_summary", { length: this.format(length), area: this.format(area, 2), open: lines.filter((line) => !line.closed).length }));
  }

  clearOutline() {
    this.outline = null;
    find("#section-outline").setAttribute("d", "");
  }

  drawOutline(pane) {
    if (!this.outline) return;
    const { viewer } = this.app, d = this.outline.map(({ points, closed }) => {
      const places = points.map((p) => viewer.onPage(p, pane)).filter(Boolean);
      return places.length > 1 ? "M" + places.map((p) => p.map((x) => x.toFixed(1)).join(",")).join("L") + (closed ? "Z" : "") : "";
    });
    find("#section-outline").setAttribute("d", d.join(""));
  }
}
