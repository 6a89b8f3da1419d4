// The aspects of the check: defects, walls, overhangs, components. Each has its controls, and its map of the mesh.

import { MARKED } from "../../report/viewer/geometry.js";
import { all, digits, find } from "../../report/viewer/controls.js";
import { Components } from "./components.js";
import { Overhangs } from "./overhangs.js";
import { Walls } from "./walls.js";

/** The aspects whose map is a colouring. */
const MAPS = ["walls", "overhangs"];

export class Aspects {
  constructor(app) {
    this.app = app;
    this.chosen = "defects";
    /** The colouring before a map was shown. */
    this.before = "plain";
    /** The current state and its mesh that were shown last; the mesh is null while previews or a coarse version are shown. */
    this.seen = { id: null, mesh: null };
    this.walls = new Walls(app);
    this.overhangs = new Overhangs(app);
    this.components = new Components(app);
    for (const input of all("[name=aspect]")) input.addEventListener("change", () => this.choose(input.value));
    find("#up").addEventListener("change", () => this.isShown("overhangs") && app.display.setColour("overhangs"));
  }

  /** Whether an aspect is open. */
  isShown(aspect) {
    return this.app.tab === "check" && this.chosen === aspect;
  }

  /** Shows an aspect and its map. */
  choose(aspect) {
    const { app } = this;
    this.chosen = aspect;
    find(`[name=aspect][value=${aspect}]`).checked = true;
    for (const part of all("[data-aspect]")) part.hidden = part.dataset.aspect !== aspect;
    if (!MAPS.includes(app.display.colour)) this.before = app.display.colour;
    this.unmark();
    this.renew(MAPS.includes(aspect) ? aspect : MAPS.includes(app.display.colour) ? this.before : null);
  }

  /** Shows the present aspect again if another mesh is shown since the last call. */
  follow() {
    const { id, mesh } = this.seen, now = { id: this.app.model.state.current, mesh: this.app.mesh() };
    this.seen = now;
    if (now.id !== id || now.mesh !== mesh) this.renew();
  }

  /** Shows the present aspect of the current mesh, in the given colouring if there is one: at once, or as soon as the mesh is shown. */
  renew(colour = null) {
    if (this.app.tab !== "check") return;
    this.sizes();
    if (colour) this.app.display.setColour(colour);
    if (this.chosen === "components") this.app.attempt("#components-trouble", () => this.components.open());
    this.walls.progress(null);
  }

  /** Shows all lengths and areas in another unit. */
  changedUnit() {
    this.app.defects.renew();
    this.walls.show();
    this.overhangs.show();
    if (this.isShown("overhangs")) this.overhangs.list();
    if (this.isShown("components")) this.app.attempt("#components-trouble", () => this.components.open());
  }

  /** Takes the map away when another pane is opened. */
  leave() {
    if (MAPS.includes(this.app.display.colour)) this.app.display.setColour(this.before);
    if (this.chosen === "components") this.unmark();
  }

  unmark() {
    const mesh = this.app.mesh();
    if (!mesh) return;
    for (let f = 0; f < mesh.facts.length; f++) mesh.facts[f] &= ~MARKED;
    this.app.viewer.surfaces.get(mesh)?.changed();
    this.app.viewer.refresh();
  }

  /** Colours a side by a map: only the current mesh has one. */
  colour(name, surface, isWanted) {
    if (surface.mesh !== this.app.mesh()) return surface.setColour({ kind: 0 });
    return name === "walls" ? this.walls.colour(surface, isWanted) : this.overhangs.colour(surface);
  }

  /** Shows the extent of the mesh in its unit. */
  sizes() {
    const [low, high] = this.app.model.state.bounds || [];
    find("#check-size").textContent = low ? high.map((x, k) => digits(x - low[k])).join(" × ") : "–";
  }
}

/** Whether a colouring is a map of an aspect. */
export const isMap = (name) => MAPS.includes(name);
