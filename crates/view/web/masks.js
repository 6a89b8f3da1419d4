// The controls of the mask: brush settings, grow and shrink, files of face numbers, named masks.

import { all, find, localised, newButton, numberIn } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { facesOf } from "./mask.js";
import { holesAt } from "./rims.js";
import { counts, tr, whole } from "./strings.js";

export class Masks {
  constructor(app) {
    this.app = app;
    /** The mask that was hidden last: its mesh and its name; and the one that was then marked again: its name and its faces. */
    this.hidden = this.shown = null;
    const { paint } = app, on = (query, act) => find(query).addEventListener("click", () => app.attempt("#paint-trouble", async () => {
      if (!app.mask()) throw new Error(tr("still_preparing"));
      await act(app.mask());
    }));
    const length = () => {
      const value = numberIn(find("#grow-by").value);
      if (!(value > 0 && Number.isFinite(value))) throw new Error(tr("grow_positive"));
      return value;
    };
    for (const input of all("[name=tool]")) input.addEventListener("change", () => app.setTool(input.value));
    find("#erase").addEventListener("change", () => { paint.erases = find("#erase").checked; });
    find("#facing").addEventListener("change", () => { paint.facing = find("#facing").checked; });
    find("#brush").addEventListener("input", () => find("#brush").setAttribute("aria-invalid", !app.setBrush(numberIn(find("#brush").value))));
    find("#brush-range").addEventListener("input", () => {
      app.setBrush(app.viewer.camera.radius * 10 ** Number(find("#brush-range").value));
      find("#brush").value = localised(Number(paint.radius.toPrecision(3)));
    });
    find("#smooth-angle").addEventListener("input", () => {
      const angle = numberIn(find("#smooth-angle").value), right = angle > 0 && angle < 180;
      find("#smooth-angle").setAttribute("aria-invalid", !right);
      if (right) paint.angle = angle;
    });
    on("#grow", () => paint.grow(length(), false));
    on("#shrink", () => paint.grow(length(), true));
    on("#invert", (mask) => { mask.change((f) => !mask.on[f]); paint.redraw(); });
    on("#clear", (mask) => { mask.change(() => false); paint.redraw(); });
    on("#unstroke", (mask) => { mask.undo(); paint.redraw(); });
    on("#restroke", (mask) => { mask.redo(); paint.redraw(); });
    on("#mask-keep", () => this.keep());
    on("#mask-hide", () => this.toggle());
    on("#mask-load", async () => {
      const { runs, faces } = await askJson("mask/load", { path: find("#mask-path").value.trim() });
      this.take(runs ? facesIn(runs) : faces);
    });
    on("#mask-save", async () => {
      const { path } = await app.save.write("mask", find("#mask-path").value.trim() || "mask.txt", find("#overwrite").checked);
      app.say(tr("mask_saved", { path }));
    });
    find("#mask-file").addEventListener("change", () => find("#mask-file").files[0] && this.takeFile(find("#mask-file").files[0]));
  }

  /** Marks exactly these faces. */
  take(numbers) {
    const { paint } = this.app, wanted = new Set(numbers);
    this.app.mask().change((f) => wanted.has(f));
    paint.redraw();
  }

  /** Loads a file of face numbers from the user's computer. */
  takeFile(file) {
    return this.app.attempt("#paint-trouble", async () => {
      if (!this.app.mask()) throw new Error(tr("still_preparing"));
      this.app.open("paint");
      this.take(facesOf(await file.text(), this.app.mask().on.length));
    });
  }

  /** The masks of the current mesh that have a name: name, number of faces, and number of faces that steps have removed. */
  get named() {
    return this.app.model.state.masks;
  }

  /** A name that no mask has, from a text with a number. */
  freeName(text = "mask_number", values = {}) {
    let number = text === "mask_again" ? 2 : 1;
    while (this.named.some(({ name }) => name === tr(text, { ...values, number }))) number++;
    return tr(text, { ...values, number });
  }

  /** Stores the current mask under a name. The program carries it over to the meshes of later steps. */
  async keep() {
    const mask = this.app.mask(), typed = find("#mask-name").value.trim();
    if (!mask.count) throw new Error(tr("nothing_marked_yet"));
    // The next step would replace a mask of that name by its own region.
    const isTaken = typed === LAST_REGION, name = isTaken ? this.freeName("mask_again", { name: typed }) : typed || this.freeName();
    await askJson("mask/keep", { id: mask.mesh.id, name, mask: mask.runs() });
    find("#mask-name").value = "";
    await this.app.refresh();
    if (isTaken) this.app.say(tr("mask_renamed", { name }));
  }

  /** The name of the mask that is marked again if none is: of this mesh the one that was hidden last, else the region of the last step. */
  get hiddenName() {
    const own = this.hidden?.mesh === this.app.model.state.current ? this.hidden.name : null;
    return [own, LAST_REGION, this.hidden?.name].find((name) => this.named.some((mask) => mask.name === name && mask.count));
  }

  /** Whether a mask is hidden, or the region of a step, and no face is marked: it can be marked again. */
  get isHidden() {
    return !this.app.marked() && this.hiddenName !== undefined;
  }

  /**
   * Hides the mask, so that the next stroke begins a new one; or marks the hidden one again. A hidden mask is stored under a name of its own,
   * unless it was hidden before and has not been changed.
   */
  async toggle() {
    const { app } = this, mask = app.mask(), { id } = mask.mesh;
    if (this.isHidden) {
      const name = this.hiddenName;
      this.take(await this.facesOf(name));
      this.shown = { mesh: id, name, faces: JSON.stringify(mask.runs()) };
      return undefined;
    }
    if (!mask.count) throw new Error(tr("nothing_marked_yet"));
    const faces = mask.runs(), isSame = this.shown?.mesh === id && this.shown.faces === JSON.stringify(faces);
    const isStored = isSame && this.named.some(({ name, count }) => name === this.shown.name && count === mask.count);
    const name = isStored ? this.shown.name : this.freeName("mask_hidden");
    if (!isStored) await askJson("mask/keep", { id, name, mask: faces });
    this.hidden = { mesh: id, name };
    mask.change(() => false);
    app.paint.redraw();
    return app.refresh();
  }

  /** The faces of a named mask of the current mesh. */
  async facesOf(name) {
    const mask = this.app.mask();
    if (!mask) throw new Error(tr("still_preparing"));
    return facesIn((await askJson(`masks/${mask.mesh.id}?name=${encodeURIComponent(name)}`)).runs);
  }

  /** The numbers of the holes that marked faces touch: a restoration closes them with the region. */
  reached() {
    const { mesh, on, count } = this.app.mask(), reached = new Set();
    for (let f = 0; count && f < on.length; f++) if (on[f]) for (const id of holesAt(mesh, f)) reached.add(id);
    return reached;
  }

  /** Sentences on the holes and borders that marked faces touch. */
  reachedWords() {
    const { holes } = this.app, reached = this.reached(), rows = holes.list.filter(({ id }) => reached.has(id));
    const sentence = (text, found) => found.length ? [tr(text, { holes: namesOf(found.map((hole) => holes.nameOf(hole))) })] : [];
    const isBorder = (hole) => holes.isBorder(hole);
    return [...sentence("marked_reaches", rows.filter((hole) => !isBorder(hole))), ...sentence("marked_border", rows.filter(isBorder))];
  }

  /** Lists the named masks of the current mesh. */
  list() {
    const focused = all("#masks button").indexOf(document.activeElement);
    find("#masks").replaceChildren(...this.named.map((mask) => this.row(mask)));
    all("#masks button")[focused]?.focus();
  }

  row({ name, count, gone }) {
    const shown = name === LAST_REGION ? tr("last_region") : name, item = document.createElement("li"), text = document.createElement("span"), { app } = this, { paint } = app;
    const button = (words, act) => {
      const made = newButton(tr(words), () => app.attempt("#paint-trouble", act));
      made.setAttribute("aria-label", `${tr(words)}: ${shown}`);
      return made;
    };
    text.textContent = `${shown} (${counts("face", count)}${gone ? tr("mask_gone", { gone: whole(gone) }) : ""})`;
    text.title = gone ? tr("mask_gone_title", { count: counts("face", gone) }) : shown;
    const faces = () => this.facesOf(name);
    const again = button("mask_show", async () => this.take(await faces())), add = button("mask_add", async () => {
      const marked = await faces();
      paint.apply(() => app.mask().set(marked, 1));
    });
    again.disabled = add.disabled = !count;
    item.append(text, again, add, button("mask_drop", async () => {
      await askJson("mask/drop", { name });
      await app.refresh();
    }));
    return item;
  }
}

/** The name under which the program stores the region of the last step. */
const LAST_REGION = "last region";

/** Most names in a sentence. */
const MOST_NAMES = 5;

/** Names with commas; of many only the first. */
const namesOf = (names) => names.slice(0, MOST_NAMES).join(", ") + (names.length > MOST_NAMES ? ", …" : "");

/** The face numbers of ranges. */
function facesIn(runs) {
  return runs.flatMap(([a, b]) => Array.from({ length: b - a }, (_, i) => a + i));
}
