// The check: a verdict, three numbers, and a list of defects; a click marks the faces of a defect and moves the view there.

import { cornersOf, MARKED } from "../../report/viewer/geometry.js";
import { cross, minus, plus, times } from "../../report/viewer/camera.js";
import { find, newButton } from "../../report/viewer/controls.js";
import { counts, tr, whole } from "./strings.js";
import { putNumbers } from "./verdict.js";

/** The normal of the face whose centre is nearest to a point; not normalised. */
function normalNear(mesh, point) {
  const { positions: p, faces } = mesh;
  let best = Infinity, face = 0;
  for (let f = 0; f < faces.length; f += 3) {
    let distance = 0;
    for (let k = 0; k < 3; k++) distance += ((p[3 * faces[f] + k] + p[3 * faces[f + 1] + k] + p[3 * faces[f + 2] + k]) / 3 - point[k]) ** 2;
    if (distance < best) [best, face] = [distance, f / 3];
  }
  const [a, b, c] = cornersOf(mesh, face);
  return cross(minus(b, a), minus(c, a));
}

export class Defects {
  constructor(app) {
    this.app = app;
    /** The number of requested checks: only the last one is shown. */
    this.requests = 0;
  }

  /** Checks again if the pane is open; called when the current mesh or the minimum wall changes. */
  renew() {
    if (this.app.tab === "check") this.check();
  }

  /** Requests a check of the current mesh, and lists its defects. */
  async check() {
    const { model } = this.app, id = model.state.current, verdict = find("#verdict"), request = ++this.requests;
    verdict.textContent = tr("checking");
    verdict.dataset.level = "";
    find("#defect-list").replaceChildren();
    find("#defect-list").dataset.none = "";
    try {
      const found = await this.app.verdict.of(id);
      // The current mesh or the minimum wall has changed in the meantime.
      if (model.state.current !== id || request !== this.requests) return;
      const { level, line } = this.app.verdict.judged(found), { walls } = found;
      verdict.textContent = line;
      verdict.dataset.level = level;
      putNumbers(find("#check-numbers"), [[tr(found.closed ? "yes" : "no"), tr("number_closed")], this.app.verdict.wallNumber(walls), [whole(found.components), tr("number_components")]]);
      find("#wall-thinnest").replaceChildren(...this.thinnest(walls));
      const { marks = {}, defects = [] } = found, there = defects.filter((d) => d.count).map((d) => ({ ...d, ...marks[d.kind] }));
      find("#defect-list").replaceChildren(...there.map((defect) => this.defect(defect, id)), ...this.small(found));
      find("#defect-list").dataset.none = tr("no_defects");
    } catch (error) {
      if (model.state.current === id && request === this.requests) verdict.textContent = error.message;
    }
  }

  /** A row for the small components, which are no defects but make a verdict doubtful; it leads to their list. */
  small({ debris }) {
    if (!debris) return [];
    const item = document.createElement("li");
    item.append(newButton(counts("debris", debris), () => this.app.aspects.choose("components")));
    return [item];
  }

  /** A button that moves the view to the thinnest wall, if there is one. */
  thinnest(walls) {
    if (!walls?.at) return [];
    return [newButton(tr("wall_place", { least: this.app.verdict.length(walls.least) }), () => {
      const mesh = this.app.shown(), { radius } = this.app.model.state.scene;
      if (!mesh) return;
      const centre = minus(walls.at, mesh.centre);
      this.app.views.look(centre, normalNear(mesh, centre), Math.min(radius, Math.max(12 * walls.least, 0.03 * radius)));
      this.app.labels.pin(centre);
    })];
  }

  /** A row of the list. Its faces belong to the mesh `id`; if another mesh or a preview is shown, they are neither shown nor marked. */
  defect({ kind, count, faces = [], places = [] }, id) {
    const name = tr(`kind_${kind}`);
    const item = document.createElement("li"), button = document.createElement("button"), select = document.createElement("button");
    let next = 0;
    button.type = select.type = "button";
    button.textContent = this.app.verdict.nameOf(kind, count);
    button.title = tr("defect_title");
    button.addEventListener("click", () => {
      const { viewer } = this.app, mesh = this.app.mesh();
      if (mesh?.id !== id) return this.app.say(tr("defects_of_other"), true);
      for (let f = 0; f < mesh.facts.length; f++) mesh.facts[f] &= ~MARKED;
      for (const f of faces) mesh.facts[f] |= MARKED;
      viewer.surfaces.get(mesh)?.changed();
      // The thin walls that a repair made are counted only.
      if (!faces.length) return kind === "thin_wall" ? find("#wall-thinnest button")?.click() : viewer.refresh();
      const face = faces[next++ % faces.length], [a, b, c] = cornersOf(mesh, face), centre = times(plus(plus(a, b), c), 1 / 3);
      this.app.views.look(centre, cross(minus(b, a), minus(c, a)), Math.max(12 * Math.hypot(...minus(b, a)), 1e-4 * viewer.camera.radius));
      this.app.labels.pin(centre);
      return this.app.say(tr("face_summary", { face, name }) + (places.length ? tr("in_places", { places: counts("place", places.length) }) : ""));
    });
    select.textContent = tr("mark_these");
    select.disabled = !faces.length;
    select.setAttribute("aria-label", `${tr("mark_these")}: ${name}`);
    select.addEventListener("click", () => {
      if (this.app.mesh()?.id !== id) return this.app.say(tr("defects_of_other"), true);
      if (!this.app.mask()) return this.app.say(tr("still_preparing"), true);
      this.app.paint.apply(() => this.app.mask().set(faces, 1));
      return this.app.open("paint");
    });
    item.append(button, select);
    return item;
  }
}
