// The list of holes and what is to be done with each.

import { cornersOf, MARKED } from "../../report/viewer/geometry.js";
import { cross, frame, minus, plus, times } from "../../report/viewer/camera.js";
import { copy } from "../../report/viewer/point.js";
import { all, counted, digits, directionTo, find, numberIn } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { isInside } from "./paint.js";
import { rimHoles } from "./display.js";

const DOINGS = { fill: "fill", open: "keep open", flat: "close flat" };

export class Holes {
  constructor(app) {
    this.app = app;
    this.list = [];
    this.doings = new Map();
    this.chosen = null;
    for (const query of ["#wider", "#narrower"]) find(query).addEventListener("input", () => this.filter());
    find("#set-all").addEventListener("change", () => {
      this.put(this.listed().map(({ id }) => [id, find("#set-all").value]));
      find("#set-all").value = "";
      this.changed();
    });
    find("#fill-chosen").addEventListener("click", () => app.steps.run("fill", { only: this.chosen }));
    find("#fill-all").addEventListener("click", () => app.steps.run("fill"));
    find("#copy-holes").addEventListener("click", async () => app.say(await copy(this.text()) ? `Copied: ${this.text()}` : "Copy it by hand."));
    find("#defects").addEventListener("toggle", () => find("#defects").open && this.check());
  }

  /** Takes the holes of a state. */
  update({ holes, choices }, fresh) {
    const same = !fresh && holes.length === this.list.length;
    this.list = holes;
    if (same) return;
    if (fresh) this.doings = new Map(holes.map((hole) => [hole.id, choices[hole.id] ?? (this.isBorder(hole) ? "open" : "fill")]));
    if (fresh || !holes.some((hole) => hole.id === this.chosen)) {
      this.chosen = null;
      this.app.viewer.selected = { region: 0, rim: -1 };
    }
    if (fresh) find("#defects").open = false;
    this.filter();
  }

  isBorder(hole) {
    return Boolean(hole.is_border ?? hole.outer_border);
  }

  /** The holes that pass the filter. */
  listed() {
    const bound = (query, none) => {
      const text = find(query).value.trim(), value = numberIn(text), right = !text || Number.isFinite(value) && value >= 0;
      find(query).setAttribute("aria-invalid", !right);
      return text && right ? value : none;
    };
    const low = bound("#wider", 0), high = bound("#narrower", Infinity);
    return this.list.filter((hole) => hole.diameter >= low && hole.diameter <= high);
  }

  filter() {
    const listed = this.listed();
    find("#holes").replaceChildren(...listed.slice(0, 2000).map((hole) => this.row(hole)));
    find("#holes-trouble").textContent = listed.length > 2000 ? `${listed.length} holes are listed; the first 2000 are shown. Filter by size.` : "";
    find("#holes").dataset.none = this.list.length ? "None is of this size." : "There are none.";
    this.changed();
  }

  row(hole) {
    const item = document.createElement("li"), button = document.createElement("button"), select = document.createElement("select");
    const name = `${this.isBorder(hole) ? "Border" : "Hole"} ${hole.id}`;
    const part = (kind, text) => Object.assign(document.createElement("span"), { className: kind, textContent: text });
    button.type = "button";
    button.className = "hole";
    button.dataset.hole = hole.id;
    const size = `${digits(hole.diameter)} across, ${digits(hole.height, hole.diameter)} high, ${counted(hole.edges, "edge")}`;
    button.append(part("name", name), part("outcome", hole.outcome || ""), part("size", size));
    button.setAttribute("aria-pressed", hole.id === this.chosen);
    button.addEventListener("click", () => this.choose(hole.id));
    select.setAttribute("aria-label", `What to do with ${name.toLowerCase()}`);
    select.addEventListener("change", () => this.set(hole.id, select.value));
    item.append(button, select);
    item.dataset.hole = hole.id;
    return item;
  }

  /** The numbers of bridges that there are. */
  bridges() {
    const groups = new Map();
    for (const [id, doing] of this.doings) if (/^bridge/.test(doing)) groups.set(doing, [...(groups.get(doing) || []), id]);
    return groups;
  }

  /** Takes what is to be done with holes, and tells the program. */
  put(doings) {
    for (const [id, doing] of doings) this.doings.set(id, doing);
    this.app.choices.holes(this.app.model.state.current, Object.fromEntries(doings));
  }

  set(id, doing) {
    this.put([[id, doing]]);
    this.changed();
    if (id === this.chosen) this.tell(this.list.find((hole) => hole.id === id));
  }

  /** Says what a hole is, and what is to be done with it. */
  tell({ id, diameter, height }) {
    const doing = this.doings.get(id);
    this.app.say(`Hole ${id}: ${digits(diameter)} across, ${digits(height, diameter)} high, to ${DOINGS[doing] || "be in " + doing}`);
  }

  /** Puts a hole into the last bridge, or the first one. */
  bridge(id) {
    this.set(id, [...this.bridges().keys()].pop() || "bridge 1");
  }

  /** Shows what is to be done, in rows, rims and words. */
  changed() {
    const next = this.bridges().size + 1, names = Array.from({ length: next }, (_, i) => `bridge ${i + 1}`);
    const offered = [...Object.entries(DOINGS), ...names.map((n) => [n, n])];
    for (const item of all("#holes li")) {
      const doing = this.doings.get(Number(item.dataset.hole)), select = item.querySelector("select");
      if (select.options.length !== offered.length) select.replaceChildren(...offered.map(([value, text]) => new Option(text, value)));
      select.value = doing;
      item.dataset.doing = doing.split(" ")[0];
    }
    find("#holes-text").textContent = this.text();
    find("#copy-holes").hidden = !find("#holes-text").textContent.startsWith("--");
    find("#fill-chosen").disabled = this.chosen === null;
    find("#fill-chosen").textContent = this.chosen === null ? "Fill only this hole" : `Fill only hole ${this.chosen}`;
    this.app.display.rims();
    this.app.steps.describe();
  }

  /** For each rim of a mesh the place of its colour. */
  rimKinds(mesh) {
    const own = mesh.id === this.app.model.state.current, order = ["fill", "open", "flat", "bridge"];
    const kinds = mesh.rimIds.map((id) => own ? Math.max(0, order.indexOf((this.doings.get(id) || "fill").split(" ")[0])) : 0);
    return { kinds, colours: ["bad", "soft", "fair", "second"] };
  }

  /** The parts of a fill's parameters that say which holes; an error where that makes no sense. */
  params(only) {
    if (only) return { holes: [only], keep_open: [], flat: this.doings.get(only) === "flat" ? [only] : [], bridge: [], crease: this.app.creases.params(only) };
    const ids = (doing) => [...this.doings].filter(([, d]) => d === doing).map(([id]) => id), open = ids("open");
    const border = new Set(this.list.filter((h) => this.isBorder(h)).map((h) => h.id));
    const filled = [...this.doings].filter(([, d]) => d !== "open").map(([id]) => id);
    const alone = [...this.bridges()].find(([, group]) => group.length < 2);
    if (alone) throw new Error(`${alone[0]} has one hole only, ${alone[1][0]}: a bridge joins two or more`);
    if (!this.list.length) throw new Error("there are no holes to fill");
    if (!filled.length) throw new Error("every hole is to stay open: choose one to fill");
    // A border is filled only where it is named, and may be filled where it is not: every row is told.
    const named = filled.some((id) => border.has(id)) || filled.length <= open.length;
    return { holes: named ? filled : null, keep_open: named ? [] : open, flat: ids("flat"), bridge: [...this.bridges().values()], crease: this.app.creases.params() };
  }

  /** The same as options. */
  text(only) {
    let params;
    try {
      params = this.params(only);
    } catch (error) {
      return error.message;
    }
    const listed = (flag, ids) => ids.length ? ` ${flag} ${ids.join(",")}` : "";
    const { holes, keep_open: open, flat, bridge, crease } = params, groups = (flag, all) => all.map((ids) => ` ${flag} ${ids.join("+")}`).join("");
    return `--holes ${holes ? holes.join(",") : "all"}${listed("--keep-open", open)}${listed("--flat", flat)}${groups("--bridge", bridge)}${groups("--crease", crease)}`;
  }

  /** Chooses a hole and goes there. */
  choose(id, flies = true) {
    const hole = this.list.find((h) => h.id === id), { viewer } = this.app, mesh = viewer.sides.after?.mesh;
    this.chosen = hole ? id : null;
    for (const button of all("#holes .hole")) {
      const pressed = Number(button.dataset.hole) === id;
      button.setAttribute("aria-pressed", pressed);
      if (pressed) button.scrollIntoView({ block: "nearest" });
    }
    const rim = hole && mesh ? mesh.rimIds.indexOf(id) : -1;
    viewer.selected = { region: 0, rim, mesh };
    this.changed();
    viewer.refresh();
    if (!hole) return;
    this.tell(hole);
    if (!flies || rim < 0) return;
    const centre = hole.centre.map((x, k) => x - mesh.centre[k]), { up } = this.app.model.state.scene;
    const towards = directionTo({ centre, diameter: hole.diameter }, mesh.rims[rim]);
    viewer.fly({ centre, axes: frame(towards, up), reach: Math.max(0.85 * hole.diameter, 1e-4 * viewer.camera.radius) });
  }

  step(by) {
    const ids = this.listed().map((hole) => hole.id), at = ids.indexOf(this.chosen);
    if (ids.length) this.choose(ids[at < 0 ? (by > 0 ? 0 : ids.length - 1) : (at + by + ids.length) % ids.length]);
  }

  /** The hole whose rim or opening is under a point of the view. */
  at({ aim, point }) {
    const { viewer } = this.app, mesh = viewer.sides[aim.side]?.mesh;
    if (!mesh || mesh.id !== this.app.model.state.current) return null;
    const depth = point ? viewer.place(point).depth : Infinity, near = 7 / aim.half;
    let best = null;
    for (const { id, centre, diameter, rim } of rimHoles(mesh, aim.side)) {
      const p = viewer.place(centre), wide = 0.5 * diameter / p.unit;
      if (p.depth <= 0 || Math.hypot(p.x - aim.x, p.y - aim.y) > wide + near) continue;
      const seen = [];
      for (let k = 0; k < rim.length; k += 3) seen.push(viewer.place(rim.subarray(k, k + 3)));
      const polygon = seen.map((q) => [q.x, q.y]), onRim = seen.some((q) => Math.hypot(q.x - aim.x, q.y - aim.y) < near && q.depth < depth + 0.02 * diameter);
      const open = isInside(polygon, aim.x, aim.y) && p.depth < depth + 0.25 * diameter && !(point && p.depth > depth + 0.05 * diameter);
      if ((onRim || open) && (!best || p.depth < best.depth)) best = { id, depth: p.depth };
    }
    return best?.id ?? null;
  }

  /** Has the state checked, and lists what is wrong with it. */
  async check() {
    const { model, viewer } = this.app, id = model.state.current, verdict = find("#verdict");
    verdict.textContent = "Checking…";
    find("#defect-list").replaceChildren();
    try {
      const found = await askJson(`check/${id}`);
      const { walls } = found, sound = found.sound ? "It is sound: closed, manifold, oriented and free of crossings." : (found.reasons || []).join("; ") + ".";
      verdict.textContent = sound + (walls ? ` Walls: ${digits(walls.least)} thick at least, ${digits(walls.mean)} in the mean.` : "");
      const { marks = {}, defects = [] } = found, there = defects.filter((d) => d.count).map((d) => ({ ...d, ...marks[d.kind] }));
      find("#defect-list").replaceChildren(...there.map((defect) => this.defect(defect, viewer.sides.after.mesh)));
    } catch (error) {
      verdict.textContent = error.message;
    }
  }

  defect({ kind, count, faces = [], places = [] }, mesh) {
    const name = kind.replaceAll("_", " ");
    const item = document.createElement("li"), button = document.createElement("button");
    let next = 0;
    button.type = "button";
    button.textContent = `${name}: ${count.toLocaleString("en")}`;
    button.title = "Mark them, and go to the next one";
    button.addEventListener("click", () => {
      const { viewer } = this.app;
      for (let f = 0; f < mesh.facts.length; f++) mesh.facts[f] &= ~MARKED;
      for (const f of faces) mesh.facts[f] |= MARKED;
      viewer.surfaces.get(mesh)?.changed();
      if (!faces.length) return viewer.refresh();
      const face = faces[next++ % faces.length], [a, b, c] = cornersOf(mesh, face), centre = times(plus(plus(a, b), c), 1 / 3);
      const normal = cross(minus(b, a), minus(c, a)), reach = Math.max(12 * Math.hypot(...minus(b, a)), 1e-4 * viewer.camera.radius);
      viewer.fly({ centre, axes: Math.hypot(...normal) ? frame(normal, this.app.model.state.scene.up) : viewer.camera.axes, reach });
      this.app.say(`Face ${face}: ${name}${places.length ? `, in one of ${counted(places.length, "place")}` : ""}`);
    });
    item.append(button);
    return item;
  }
}
