// The map of wall thickness: measured part by part by the program, coloured with a limit that is dragged, and what is thinner than it.

import { begun } from "../../report/viewer/activity.js";
import { digits, find, localised, rising, showScale } from "../../report/viewer/controls.js";
import { askArrays } from "./net.js";
import { sumOf } from "./faces.js";
import { counts, tr } from "./strings.js";

/** Fraction of the faces whose thickness is beyond the scale. */
const BEYOND_SCALE = 0.05;
/** Number of faces, about, that give the range of the scale. */
const SAMPLES = 20_000;
/** Steps of the slider. */
const WALL_STEPS = 1000;

/** The upper end of the scale: a round thickness that most faces do not exceed. */
function highest(values) {
  const stride = Math.max(1, Math.floor(values.length / SAMPLES)), some = [];
  for (let f = 0; f < values.length; f += stride) if (values[f] === values[f]) some.push(Math.abs(values[f]));
  some.sort((a, b) => a - b);
  return Number((some[Math.floor((1 - BEYOND_SCALE) * (some.length - 1))] || 1).toPrecision(2));
}

export class Walls {
  constructor(app) {
    this.app = app;
    /** The measurement that runs; none if it has ended or is cancelled. */
    this.run = null;
    const range = find("#wall-range");
    range.max = WALL_STEPS;
    range.addEventListener("input", () => this.drag(Number(range.value)));
    range.addEventListener("change", () => app.verdict.typed());
    find("#min-wall").addEventListener("input", () => this.show());
    find("#walls-cancel").addEventListener("click", () => (this.run ? this.cancel() : app.display.setColour("walls")));
  }

  /** The thickness at each face of a mesh: negative at wedges, NaN where there is no other side; null if cancelled. */
  async of(mesh) {
    if (mesh.walls) return mesh.walls;
    const run = this.run = {}, end = begun("request"), faces = mesh.faces.length / 3, values = new Float32Array(faces);
    try {
      for (let known = 0; known < faces;) {
        this.progress(known / faces);
        const { arrays } = await askArrays(`walls/${mesh.id}?known=${known}`);
        if (this.run !== run) return null;
        values.set(arrays.values, known);
        known += arrays.values.length;
      }
      return mesh.walls = values;
    } finally {
      if (this.run === run) this.run = null;
      this.progress(null);
      end();
    }
  }

  /** Shows how much is measured; null if nothing is being measured. */
  progress(share) {
    const isRunning = Boolean(this.run), isMissing = !isRunning && !this.app.mesh()?.walls;
    find("#walls-progress").hidden = !isRunning && !isMissing;
    find("#walls-bar").hidden = !isRunning;
    if (share) find("#walls-bar").value = share;
    else find("#walls-bar").removeAttribute("value");
    find("#walls-cancel").textContent = tr(isRunning ? "cancel" : "walls_measure");
    for (const query of ["#wall-range"]) find(query).disabled = isRunning || isMissing;
    if (isRunning) find("#walls-said").textContent = tr("walls_measuring");
  }

  cancel() {
    this.run = null;
    find("#walls-said").textContent = "";
    this.app.display.setColour("plain");
    this.progress(null);
  }

  /** Colours a surface, unless another colouring is chosen before the thickness is measured. */
  async colour(surface, isWanted) {
    const values = await this.of(surface.mesh);
    if (!values || !isWanted()) return;
    this.high = surface.mesh.wallsHigh ??= highest(values);
    surface.setColour({ kind: 5, values, on: 1, span: [0, this.high], limits: [0, Infinity] });
    this.show();
  }

  /** Takes a limit from the slider. */
  drag(step) {
    find("#min-wall").value = step ? localised(Number((this.high * step / WALL_STEPS).toPrecision(3))) : "";
    this.app.verdict.share();
    this.app.steps.describe();
    this.show();
  }

  /** Shows the limit: in the colours, the legend, the slider, and the count of what is thinner. */
  show() {
    const { app } = this, mesh = app.mesh(), surface = app.viewer.surfaces.get(mesh);
    if (!mesh?.walls || surface?.colour.kind !== 5 || app.display.colour !== "walls") return;
    const limit = app.verdict.wall() ?? 0, place = Math.min(1, limit / this.high);
    surface.colour.limits = [limit / this.high, Infinity];
    find("#wall-range").value = Math.round(WALL_STEPS * place);
    showScale(tr("scale_walls") + app.measure.unitOf("length"), "0", `≥ ${digits(this.high)}`, 2);
    const stops = [1, 2 / 3, 1 / 3, 0].map((x, i) => `${rising(x)} ${100 * (place + (1 - place) * i / 3)}%`);
    find("#scale-bar").style.background = `linear-gradient(90deg, var(--fault) ${100 * place}%, ${stops})`;
    const { count, area, all } = sumOf(mesh, mesh.walls, (t) => t >= 0 && t < limit);
    find("#walls-said").textContent = limit
      ? tr("walls_thinner", { faces: counts("face", count), area: app.measure.format(area, 2), share: digits(Number((100 * area / (all || 1)).toPrecision(3))) })
      : tr("walls_drag");
    find("#walls-said").dataset.bad = Boolean(count);
    app.viewer.moving();
  }
}
