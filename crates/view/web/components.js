// The components of the mesh: listed, seen in the view, hidden and shown; a chosen one or small ones are deleted by a repair that does nothing else.

import { HIDDEN, MARKED } from "../../report/viewer/geometry.js";
import { digits, find, localised, newButton, numberIn } from "../../report/viewer/controls.js";
import { putIcons } from "./icons.js";
import { askArrays } from "./net.js";
import { counts, tr, whole } from "./strings.js";

/** Upper bound of the number of listed components. */
const LISTED_MOST = 500;
/** The steps of a repair, all left out where it only deletes components. */
const REPAIR_STEPS = ["duplicates", "orientation", "non-manifold", "intersections", "holes"];

/** The components of a mesh in falling order of their areas, and the component of each face and hole. */
async function fetched(id) {
  const { arrays } = await askArrays(`components/${id}`), { faces, areas, centres, reaches, of_faces: ofFaces, of_holes: ofHoles } = arrays;
  const all = Array.from(faces, (count, number) => ({ number, faces: count, area: areas[number], centre: [...centres.subarray(3 * number, 3 * number + 3)], reach: reaches[number] }));
  all.sort((a, b) => b.area - a.area || a.number - b.number);
  return { all, ofFaces, ofHoles, hidden: new Set() };
}

export class Components {
  constructor(app) {
    this.app = app;
    this.picked = null;
    const range = find("#debris-range"), field = find("#debris-part");
    range.addEventListener("input", () => {
      field.value = localised(Number((10 ** Number(range.value)).toPrecision(2)));
      this.show();
    });
    field.addEventListener("input", () => {
      const percent = numberIn(field.value), right = percent >= 0 && percent <= 100;
      field.setAttribute("aria-invalid", !right);
      if (!right) return;
      range.value = Math.log10(percent || 1e-9);
      this.show();
    });
    find("#debris-delete").textContent = tr("debris_delete", { components: counts("component", 0) });
    find("#debris-delete").addEventListener("click", () => app.attempt("#components-trouble", () => this.remove()));
    find("#show-all").addEventListener("click", () => this.hide(this.found?.all, false));
  }

  /** The components of the current mesh; null while it is not shown. */
  get found() {
    return this.app.mesh()?.components ?? null;
  }

  /** The fraction of the largest component's area below which components are deleted. */
  get part() {
    return Number((numberIn(find("#debris-part").value) / 100).toPrecision(6)) || 0;
  }

  /** Fetches and lists the components of the current mesh. */
  async open() {
    const mesh = this.app.mesh();
    this.picked = null;
    if (!mesh?.components) this.clear();
    if (!mesh) return find("#components-said").textContent = tr(this.app.steps.previews.length ? "components_wait" : "still_preparing");
    mesh.components ??= await fetched(mesh.id);
    if (mesh !== this.app.mesh()) return undefined;
    find("#component-list").replaceChildren(...mesh.components.all.slice(0, LISTED_MOST).map((own) => this.row(own)));
    return this.show();
  }

  /** Removes what is listed of an earlier mesh. */
  clear() {
    find("#component-list").replaceChildren();
    for (const query of ["#debris", "#show-all"]) find(query).hidden = true;
    find("#components-said").textContent = "…";
  }

  row(own) {
    const item = document.createElement("li"), eye = newButton("", () => this.hide([own], !this.found?.hidden.has(own.number)), { className: "icon-button" });
    const button = newButton("", () => this.pick(own.number, true));
    button.append(...[own.number + 1, counts("face", own.faces), this.app.measure.format(own.area, 2)].map((textContent) => Object.assign(document.createElement("span"), { textContent })));
    eye.dataset.icon = "eye";
    eye.setAttribute("aria-label", tr("component_hide", { number: own.number + 1 }));
    item.dataset.number = own.number;
    item.append(button, eye);
    putIcons(item);
    return item;
  }

  /** The components that would be deleted. */
  debris() {
    const { all } = this.found, least = this.part * all[0]?.area;
    return all.filter((own) => own.area < least);
  }

  /** Shows what would be deleted, in the list, the view and as a command. */
  show() {
    const { found } = this;
    if (!found) return;
    const debris = new Set(this.debris().map((own) => own.number)), { all, hidden } = found;
    for (const item of find("#component-list").children) {
      const number = Number(item.dataset.number);
      item.classList.toggle("debris", debris.has(number));
      item.classList.toggle("picked", number === this.picked);
      item.classList.toggle("off", hidden.has(number));
      item.lastChild.setAttribute("aria-pressed", hidden.has(number));
    }
    find("#components-said").textContent = [counts("component", all.length), all.length > LISTED_MOST ? tr("components_listed", { count: whole(LISTED_MOST) }) : ""].filter(Boolean).join("; ");
    find("#debris").hidden = all.length < 2;
    find("#show-all").hidden = !hidden.size;
    find("#debris-delete").disabled = (this.picked === null ? !debris.size : all.length < 2) || Boolean(this.app.steps.job);
    find("#debris-delete").textContent = this.picked === null ? tr("debris_delete", { components: counts("component", debris.size) }) : tr("component_delete", { number: this.picked + 1 });
    find("#debris-command").textContent = this.command();
    this.mark(this.picked === null ? debris : new Set([this.picked]));
  }

  /** What is deleted: the chosen component, else all small ones. */
  deleted() {
    return this.picked === null ? { debris: this.part } : { drop: [this.picked + 1] };
  }

  command() {
    const [[option, value]] = Object.entries(this.deleted());
    return ["isomend", "repair", `--${option}`, value, "--skip", REPAIR_STEPS.join()].join(" ");
  }

  /** Marks the faces of components in the view. */
  mark(numbers) {
    const mesh = this.app.mesh(), { ofFaces } = this.found, { facts } = mesh;
    for (let f = 0; f < facts.length; f++) facts[f] = numbers.has(ofFaces[f]) ? facts[f] | MARKED : facts[f] & ~MARKED;
    this.app.viewer.surfaces.get(mesh)?.changed();
    this.app.viewer.moving();
  }

  /** Chooses a component, or none with the chosen one's number, and moves the view there if `goes`. */
  pick(number, goes) {
    // Until the next mesh is shown the rows of the last one remain.
    const own = this.found?.all.find((one) => one.number === number), { viewer } = this.app;
    if (!own) return;
    this.picked = this.picked === number ? null : number;
    this.show();
    if (this.picked === null) return;
    find(`#component-list [data-number="${number}"]`)?.scrollIntoView({ block: "nearest" });
    if (goes) viewer.fly({ centre: own.centre, axes: viewer.camera.axes, reach: Math.max(4 * own.reach, 0.02 * this.app.model.state.scene.radius) });
    this.app.say(tr("component_is", { number: number + 1, faces: counts("face", own.faces), area: this.app.measure.format(own.area, 2), part: digits(Number((100 * own.area / (this.found.all[0].area || 1)).toPrecision(3))) }));
  }

  /** Chooses the component that was clicked in the view. */
  clicked({ face }) {
    const number = face === undefined ? undefined : this.found?.ofFaces[face];
    if (this.found?.all.some((own) => own.number === number)) this.pick(number, false);
  }

  /** Hides or shows components with the rims of their holes. */
  hide(components, isHidden) {
    const { app, found } = this, mesh = app.mesh();
    if (!found) return;
    const { facts } = mesh;
    for (const { number } of components) found.hidden[isHidden ? "add" : "delete"](number);
    for (let f = 0; f < facts.length; f++) facts[f] = found.hidden.has(found.ofFaces[f]) ? facts[f] | HIDDEN : facts[f] & ~HIDDEN;
    mesh.hiddenHoles = new Set(app.model.state.holes.filter((_, i) => found.hidden.has(found.ofHoles[i])).map(({ id }) => id));
    app.viewer.surfaces.get(mesh)?.changed();
    app.display.rims();
    app.display.label();
    this.show();
  }

  /** Deletes the chosen component or the small ones, as a step. */
  async remove() {
    if (this.app.steps.job) throw new Error(tr("is_running"));
    if (!this.found) throw new Error(tr("still_preparing"));
    await this.app.steps.request(this.command(), { kind: "repair", params: { ...this.deleted(), skip: REPAIR_STEPS }, mask: null, no_texture: false, preview: false });
  }
}
