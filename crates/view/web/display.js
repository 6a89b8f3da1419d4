// The display of meshes: before and after, colouring, section, screenshot.

import { during } from "../../report/viewer/activity.js";
import { IMAGE } from "../../report/viewer/geometry.js";
import { dot, minus, times } from "../../report/viewer/camera.js";
import { WHOLE } from "../../report/viewer/viewer.js";
import { all, digits, find, showScale } from "../../report/viewer/controls.js";
import { tr } from "./strings.js";
import { askArrays } from "./net.js";
import { Topology } from "./topology.js";
import { Mask } from "./mask.js";
import { foldLines, patchLines } from "./folds.js";
import { BANDED } from "./band.js";
import { isMap } from "./aspects.js";

/** Centre and diameter of each rim, for placing the number of its hole. */
export function rimHoles({ rims, rimIds }, side) {
  return rims.map((rim, i) => {
    const n = rim.length / 3, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], sum = [0, 0, 0];
    for (let k = 0; k < rim.length; k++) {
      low[k % 3] = Math.min(low[k % 3], rim[k]);
      high[k % 3] = Math.max(high[k % 3], rim[k]);
      sum[k % 3] += rim[k] / n;
    }
    return { id: rimIds[i], side, centre: sum, diameter: n ? Math.hypot(...minus(high, low)) : 0, rim };
  });
}

/** Scalars unchanged, vectors replaced by their lengths; the header gets the range of the lengths. */
function lengths(values, header) {
  const parts = header.arrays[0].components || 1;
  if (parts === 1 || values instanceof Uint8Array) return values;
  const all = new Float32Array(values.length / parts);
  let [low, high] = [Infinity, 0];
  for (let i = 0; i < all.length; i++) {
    all[i] = Math.hypot(...values.subarray(parts * i, parts * (i + 1)));
    if (all[i] < low) low = all[i];
    if (all[i] > high) high = all[i];
  }
  Object.assign(header, { low: Math.min(low, high), high });
  return all;
}

/** Arrays of numbers, one after the other. */
function concatenated(arrays) {
  const all = new Float32Array(arrays.reduce((sum, { length }) => sum + length, 0));
  arrays.reduce((at, array) => { all.set(array, at); return at + array.length; }, 0);
  return all;
}

/** The shading by ambient light. */
const AMBIENT = 4;

export class Display {
  constructor(app) {
    this.app = app;
    this.colour = "plain";
    /** The colouring that is shown; another one may be loading. */
    this.coloured = null;
    this.shown = { before: null, after: null };
    this.place = 0;
    for (const input of all(".tools fieldset input")) {
      input.addEventListener("change", () => this.option(input.name, input.type === "radio" ? input.value : input.checked));
    }
    find("#colour").addEventListener("change", () => {
      const name = find("#colour").value;
      if (!isMap(name)) return this.setColour(name);
      app.open("check");
      return app.aspects.choose(name);
    });
    for (const query of ["#section", "#cut", "#flip"]) find(query).addEventListener("input", () => this.cut());
    find("#split").addEventListener("input", () => {
      app.viewer.split = Number(find("#split").value);
      app.viewer.moving();
    });
    find("#shading").addEventListener("change", () => this.option("shading", Number(find("#shading").value)));
    find("#light").addEventListener("input", () => this.option("light", Number(find("#light").value)));
    find("#screenshot").addEventListener("click", () => this.screenshot());
  }

  /** Sets an option of the view, and the controls that show it. */
  option(name, value) {
    for (const input of all(`.tools [name="${name}"]`)) input.checked = input.type === "radio" ? input.value === value : value;
    this.app.viewer.options[name] = value;
    if (name === "folds" || name === "rims") this.rims();
    if (name === "shading") this.ambient();
    this.showSides();
    this.app.viewer.refresh();
  }

  /** Lets the worker compute ambient occlusion for the shown meshes, if their shading needs it. */
  ambient() {
    if (this.app.viewer.options.shading !== AMBIENT) return;
    for (const { mesh, surface } of Object.values(this.app.viewer.sides)) {
      if (surface.ambient) continue;
      this.app.model.ambient(mesh).then((ambient) => {
        if (this.app.viewer.surfaces.get(mesh) !== surface) return;
        surface.setAmbient(ambient);
        this.app.viewer.refresh();
      }).catch((error) => this.app.say(error.message, true));
    }
  }

  showSides() {
    const { show } = this.app.viewer.options, two = show === "both" || show === "slider";
    find(".stage").classList.toggle("both", show === "both");
    // One picture alone has its name in the control already, unless it is a preview's.
    const named = this.shown.before !== null && (two || Boolean(this.shown.names));
    find("#left").hidden = !named || show === "after";
    find("#right").hidden = !named || show === "before";
    find("#right").classList.toggle("edge", show !== "both");
    find("#left").textContent = this.shown.names?.[0] || tr("before");
    find("#right").textContent = this.shown.names?.[1] || tr("after");
    find("#split").hidden = show !== "slider";
    find("#split").value = this.app.viewer.split;
    return two;
  }

  /** Shows a state and, if `before` is not null, another one to compare with; `names` are the labels of both sides. */
  async states(after, before, names = null) {
    const { model, viewer } = this.app, wanted = this.wanted = {};
    const [mesh, old] = await Promise.all([model.firstMesh(after), before === null ? null : model.firstMesh(before)]);
    if (this.wanted !== wanted) return;
    this.shown = { after, before, names };
    this.side("after", mesh);
    if (old) this.side("before", old);
    else if (viewer.sides.before) delete viewer.sides.before;
    find("fieldset.change").disabled = !old;
    if (!old && viewer.options.show !== "after") this.option("show", "after");
    // Only the marks of the current mesh are drawn.
    for (const shown of [mesh, old]) if (shown?.mask?.show(shown === mesh && after === model.state.current)) viewer.surfaces.get(shown)?.changed();
    viewer.keep();
    model.forget([after, before]);
    this.label();
    this.showSides();
    this.ambient();
    this.app.aspects.follow();
    await this.setColour(this.colour);
    for (const shown of [mesh, old]) if (shown) this.ready(shown);
    // Until a large mesh is prepared its coarse version is shown.
    for (const { id, coarse } of [mesh, old].filter(Boolean)) {
      if (coarse) model.wholeMesh(id).then(() => this.wanted === wanted && this.states(after, before, names)).catch((error) => this.app.say(error.message, true));
    }
  }

  side(name, mesh) {
    const { kinds, colours } = name === "after" ? this.app.holes.rimKinds(mesh) : { kinds: mesh.rims.map(() => 0), colours: ["bad"] };
    const { options } = this.app.viewer, lines = [];
    if (options.folds && mesh.topology) lines.push(mesh.folds ??= foldLines(mesh.topology));
    if (options.rims && !mesh.coarse) lines.push(mesh.patchLines ??= patchLines(mesh));
    const segments = concatenated(lines);
    const hidden = mesh.hiddenHoles, rims = hidden?.size ? mesh.rims.map((rim, i) => (hidden.has(mesh.rimIds[i]) ? rim.subarray(0, 0) : rim)) : mesh.rims;
    this.app.viewer.setSide(name, { mesh, rims, kinds, colours, segments: segments.length ? segments : null });
  }

  /** Draws the rims again after the actions on their holes have changed. */
  rims() {
    for (const [name, { mesh }] of Object.entries(this.app.viewer.sides)) this.side(name, mesh);
  }

  label() {
    const { before, after } = this.app.viewer.sides, items = [];
    for (const [name, side] of [["after", after], ["before", before]]) if (side) items.push(...rimHoles(side.mesh, name).filter(({ id }) => !side.mesh.hiddenHoles?.has(id)));
    items.sort((a, b) => b.diameter - a.diameter);
    this.app.labels.set(items, items.map((item) => item.rim));
    this.app.creases.show();
  }

  /** Lets the worker prepare a mesh for painting, and a coarse version for a moving view. */
  async ready(mesh) {
    const found = await this.app.model.prepare(mesh).catch((error) => this.app.say(error.message, true));
    if (!found) return;
    if (!mesh.coarse) this.paintable(mesh, found);
    const surface = this.app.viewer.surfaces.get(mesh);
    if (surface && found.bends && !surface.bends) {
      surface.setBends(found.bends);
      this.app.viewer.refresh();
    }
    if (!surface || surface.order) return;
    surface.setOrder(found.order);
    if (found.thin) surface.setLevel("thin", found.thin);
    this.app.viewer.costs = {};
  }

  /** Makes a prepared mesh ready for painting. */
  paintable(mesh, found) {
    mesh.topology ??= new Topology(mesh, found);
    const fresh = !mesh.mask;
    mesh.mask ??= new Mask(mesh);
    this.mark(mesh);
    if (fresh && mesh.parent?.mesh.mask) mesh.mask.inherit(mesh.parent.mesh.mask, mesh.parent);
    // Release the mesh before the step.
    mesh.parent = null;
    if (fresh && mesh === this.app.mesh()) this.app.painted();
    if (this.app.viewer.options.folds) this.rims();
  }

  /** Marks the faces of the current mesh that the program has as marked. */
  mark(mesh) {
    if (!mesh?.mask || mesh.id !== this.app.model.state.current) return;
    if (mesh.mask.sent !== mesh.mask.changes || !mesh.mask.take(this.app.choices.marks.get(mesh.id) || [])) return;
    this.app.viewer.surfaces.get(mesh)?.changed();
    this.app.viewer.refresh();
  }

  /** Updates the list of available colourings. */
  offer() {
    const { state } = this.app.model, select = find("#colour"), had = this.colour;
    const list = [["plain", tr("colour_plain")], ["curvature", tr("colour_curvature")], ["walls", tr("colour_walls")], ["overhangs", tr("colour_overhangs")]];
    if (this.app.model.current?.parent !== null && this.app.model.current) list.push(["distance", tr("colour_distance")]);
    if (this.app.model.current?.parent !== null || this.app.band.reference) list.push(["deviation", tr("colour_deviation")]);
    if (state.errors) list.push(["sigma", tr("colour_sigma")]);
    if (state.texture) list.push(["texture", tr("colour_texture")]);
    for (const { name } of state.attributes || []) list.push(["attribute:" + name, name]);
    select.replaceChildren(...list.map(([value, text]) => new Option(text, value)));
    this.colour = select.value = list.some(([value]) => value === had) ? had : "plain";
  }

  /** Colours both sides; values that arrive for an earlier choice are dropped. */
  async setColour(name) {
    const { viewer } = this.app, colouring = this.colouring = {};
    this.colour = find("#colour").value = name;
    find("#scale").dataset.colour = name;
    find("#scale").hidden = true;
    this.app.band.take(null);
    try {
      await Promise.all(Object.entries(viewer.sides).map(([side, { surface }]) => this.colourSide(name, side, surface, colouring)));
    } catch (error) {
      if (this.colouring !== colouring) return;
      this.app.say(error.message, true);
      for (const { surface } of Object.values(viewer.sides)) surface.setColour({ kind: 0 });
      this.colour = find("#colour").value = "plain";
    }
    if (this.colouring !== colouring) return;
    this.coloured = name;
    viewer.refresh();
  }

  /** Colours one side, unless another colouring is chosen before the values arrive. */
  async colourSide(name, side, surface, colouring) {
    const id = this.shown[side], isAfter = side === "after";
    if (name === "plain" || surface.mesh.coarse) return surface.setColour({ kind: 0 });
    // Measuring thickness takes seconds: nothing waits for it.
    if (isMap(name)) {
      this.app.attempt("#message", () => this.app.aspects.colour(name, surface, () => this.colouring === colouring));
      return undefined;
    }
    if (name === "texture") return this.texture(id, surface, colouring);
    const other = this.shown[isAfter ? "before" : "after"], { reference } = this.app.band;
    if (name === "deviation" && !isAfter) return surface.setColour({ kind: 0 });
    const from = name === "deviation" && reference ? `&file=${encodeURIComponent(reference)}` : "", to = from || (BANDED.includes(name) && other !== null ? `&to=${other}` : "");
    const found = await this.app.model.valuesOf(id, name, to).catch((error) => {
      // The mesh to compare with may lack these values.
      if (isAfter) throw error;
      return null;
    });
    if (this.colouring !== colouring) return undefined;
    if (!found) return surface.setColour({ kind: 0 });
    const { header, arrays } = found, errors = name === "sigma";
    let values = lengths(arrays.values || arrays.colours, header);
    const on = { vertex: 0, face: 1, corner: 2 }[header.on || "vertex"];
    if (values instanceof Uint8Array) return surface.setColour({ kind: 3, values, on });
    const kind = name === "curvature" || name === "deviation" ? 1 : 2, most = Math.max(Math.abs(header.low), Math.abs(header.high)) || 1;
    if (BANDED.includes(name) && isAfter) this.app.band.take(values);
    if (BANDED.includes(name) && this.app.band.limits()) return this.banded(surface, values, on, isAfter);
    const span = kind === 1 ? [-most, most] : [header.low, header.high > header.low ? header.high : header.low + 1];
    const gaps = errors && values.some(Number.isNaN);
    // Values below the scale represent unknown ones.
    if (gaps) values = values.map((x) => Number.isNaN(x) ? -span[1] : x);
    surface.setColour({ kind, values, on, span, skipKept: errors, gaps });
    if (!isAfter) return undefined;
    // The scale of expected errors leaves out the largest ones.
    const more = errors && values.some((x) => x > span[1]) ? "≥ " : "";
    const words = { curvature: tr("scale_curvature"), distance: tr("scale_distance"), deviation: tr("scale_deviation"), sigma: tr("scale_sigma") }[name] || name.replace("attribute:", "");
    return showScale(words + this.app.measure.unitOf(header.unit), (span[0] < 0 ? "−" : "") + digits(Math.abs(span[0])), more + digits(span[1]), kind, gaps);
  }

  /** Colours by a tolerance band. */
  banded(surface, values, on, isAfter) {
    surface.setColour({ kind: 3, values: this.app.band.colours(values), on });
    if (!isAfter) return;
    const [low, high] = this.app.band.limits().map((x) => Number.isFinite(x) ? digits(x) : "");
    showScale(tr("scale_band") + this.app.measure.unitOf("length"), low, high, 2);
    find("#scale-bar").style.background = "linear-gradient(90deg,#2b6cb0 25%,#4ca060 25% 75%,#c02f2f 75%)";
  }

  /** The texture images, all scaled to the size of the largest one, at most 4096 pixels. */
  async images({ url, count = 1 }) {
    const blobs = await Promise.all(Array.from({ length: count }, async (_, i) => (await fetch(url.replace(/\d+$/, i))).blob()));
    const options = { premultiplyAlpha: "none", colorSpaceConversion: "none" }, first = await Promise.all(blobs.map((blob) => createImageBitmap(blob, options)));
    const [resizeWidth, resizeHeight] = ["width", "height"].map((side) => Math.min(4096, Math.max(...first.map((image) => image[side]))));
    const fits = (image) => image.width === resizeWidth && image.height === resizeHeight;
    return Promise.all(first.map((image) => fits(image) ? image : createImageBitmap(image, { resizeWidth, resizeHeight })));
  }

  async texture(id, surface, colouring) {
    const { facts } = surface.mesh, images = await (this.textures ??= during("request", () => this.images(this.app.model.state.texture)));
    const { header, arrays: { uv, texture } } = await askArrays(`uv/${id}`);
    if (this.colouring !== colouring) return;
    const values = header.v_up ? uv.map((x, i) => i % 2 ? 1 - x : x) : uv;
    for (let f = 0; f < facts.length; f++) facts[f] = facts[f] & ~(255 << IMAGE) | texture[f] << IMAGE;
    surface.changed();
    surface.setColour({ kind: 4, values, on: 2, images });
  }

  /** Applies the section of the controls. */
  cut() {
    const { viewer } = this.app, axis = find("#section").value, sign = find("#flip").checked ? -1 : 1;
    for (const query of ["#cut-at", "#cut-side"]) find(query).hidden = !axis;
    this.app.measure.clearOutline();
    const normal = axis === "view" ? (this.axis ??= viewer.camera.axes[2]) : [axis === "x" ? 1 : 0, axis === "y" ? 1 : 0, axis === "z" ? 1 : 0];
    if (axis !== "view") this.axis = null;
    const { centre } = this.app.home(), at = dot(normal, centre) + Number(find("#cut").value) * viewer.camera.radius;
    viewer.section = axis ? [...times(normal, sign), sign * at] : WHOLE;
    viewer.moving();
  }

  /** Saves a picture of the view with the numbers of holes as a download. */
  screenshot() {
    const { viewer } = this.app, { canvas } = viewer, copy = document.createElement("canvas");
    viewer.draw();
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const to = copy.getContext("2d"), ratio = canvas.width / canvas.clientWidth, style = getComputedStyle(canvas);
    to.drawImage(canvas, 0, 0);
    to.font = `bold ${13 * ratio}px system-ui, sans-serif`;
    to.textAlign = "center";
    to.textBaseline = "middle";
    for (const label of all("#labels :is(.label, .end):not([hidden])")) {
      const text = label.textContent || label.dataset.end, wide = to.measureText(text).width + 8 * ratio;
      const x = parseFloat(label.style.left) * ratio, y = parseFloat(label.style.top) * ratio;
      to.fillStyle = style.getPropertyValue("--sky");
      to.fillRect(x - wide / 2, y - 9 * ratio, wide, 18 * ratio);
      to.fillStyle = style.getPropertyValue("--mark");
      to.fillText(text, x, y);
    }
    copy.toBlob((blob) => this.app.say(tr("picture_saved", { name: this.app.save.hand(blob, ".png") })));
  }
}
