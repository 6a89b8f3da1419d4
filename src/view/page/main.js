// Ties everything together: the tabs, the masks, the keys, the beginning.

import { dot, frame, HALF_FIELD, minus } from "../../report/viewer/camera.js";
import { Viewer } from "../../report/viewer/viewer.js";
import { Labels } from "../../report/viewer/labels.js";
import { Point } from "../../report/viewer/point.js";
import { all, counted, find, numberIn, useArrows, usePointers, useTheme } from "../../report/viewer/controls.js";
import { askJson, listen } from "./net.js";
import { Model } from "./model.js";
import { facesOf } from "./mask.js";
import { Choices } from "./choices.js";
import { Paint } from "./paint.js";
import { Creases } from "./creases.js";
import { Display } from "./display.js";
import { Holes } from "./holes.js";
import { Steps } from "./steps.js";
import { Save } from "./save.js";

class App {
  constructor() {
    this.model = new Model();
    this.tab = "holes";
    this.seen = null;
  }

  say(text, trouble = false) {
    find("#message").textContent = text;
    find("#message").classList.toggle("trouble", trouble);
  }

  /** Does something; an error is told at a place of the page. */
  async attempt(query, act) {
    const place = find(query);
    if (query !== "#message") place.textContent = "";
    try {
      return await act();
    } catch (error) {
      if (query === "#message") this.say(error.message, true);
      else place.textContent = error.message;
      return undefined;
    }
  }

  /** The mesh that is worked on. */
  mesh() {
    const mesh = this.viewer?.sides.after?.mesh;
    return mesh && mesh.id === this.model.state.current ? mesh : null;
  }

  mask() {
    return this.mesh()?.mask || null;
  }

  /** How many faces of the mesh that is worked on are marked, also while previews are shown in its place. */
  marked() {
    return this.mask()?.count ?? this.choices.count(this.model.state.current);
  }

  /** The marked faces, as ranges. */
  marks() {
    return this.mask()?.runs() ?? this.choices.marks.get(this.model.state.current) ?? [];
  }

  /** Where one looks from first: so near that the mesh just fits. */
  home() {
    const { centre, radius, up, towards } = this.model.state.scene, mesh = this.viewer.sides.after?.mesh;
    const axes = frame(towards, up), { clientWidth, clientHeight: high } = this.viewer.canvas, wide = clientWidth * (this.viewer.options.show === "both" ? 0.5 : 1);
    if (!mesh) return { centre: [0, 0, 0], axes, reach: 1.08 * radius };
    const from = minus(centre, mesh.centre), least = Math.min(wide, high), { positions } = mesh, stride = 3 * Math.max(1, Math.ceil(positions.length / 150_000));
    let reach = 1e-3 * radius;
    for (let i = 0; i < positions.length; i += stride) {
      const d = [positions[i] - from[0], positions[i + 1] - from[1], positions[i + 2] - from[2]];
      // What is nearer to the eye is seen larger.
      const nearer = Math.max(0, dot(d, axes[2])) * Math.tan(HALF_FIELD);
      reach = Math.max(reach, Math.abs(dot(d, axes[0])) * least / wide + nearer, Math.abs(dot(d, axes[1])) * least / high + nearer);
    }
    return { centre: from, axes, reach: 1.06 * reach };
  }

  /** Fetches what there is now and shows it; once for all that ask meanwhile. */
  refresh() {
    this.next ??= (this.last ?? Promise.resolve()).catch(() => null).then(() => {
      this.next = null;
      return this.update();
    });
    return this.last = this.next;
  }

  async update(known = null) {
    const state = known || await this.model.fetchState(), { current } = this.model, fresh = this.seen !== state.current;
    this.seen = state.current;
    find("#title").textContent = state.file.name;
    document.title = `${state.file.name} – isomend view`;
    find("#subtitle").textContent = `${counted(current.faces, "face")}, ${counted(state.holes.length, "hole")} · isomend ${state.program.version}${state.unsaved ? " · not saved" : ""}`;
    if (fresh) this.steps.against = false;
    if (fresh) await this.choices.load(state);
    this.creases.update(state, fresh);
    this.holes.update(state, fresh);
    this.display.offer();
    this.steps.list();
    this.steps.buttons();
    if (state.busy) this.steps.join(state.busy);
    if (this.tab === "save") this.save.recipe();
    this.steps.previews = this.steps.previews.filter((p) => this.model.find(p.id));
    if (this.steps.previews.length) return this.steps.showPreviews();
    find("#previews").hidden = true;
    const before = current.parent === null || current.parent === undefined ? null : Number(find("#against").value);
    await this.display.states(state.current, before);
    this.display.mark(this.mesh());
    this.painted();
  }

  /** What the mask is now. */
  painted(words, trouble) {
    const mask = this.mask(), count = this.marked(), all = this.model.current.faces;
    if (mask && mask.told !== mask.changes) {
      mask.told = mask.changes;
      this.choices.mark(mask.mesh.id, mask.runs());
    }
    const marked = count ? `${count.toLocaleString("en")} of ${counted(all, "face")} ${count === 1 ? "is" : "are"} marked.` : "Nothing is marked.";
    const waits = this.steps.previews.length ? "Take or drop the previews to paint." : "The surface is still being prepared for painting.";
    find("#mask-said").textContent = mask ? marked : `${marked} ${waits}`;
    find("#unstroke").disabled = !mask?.done.length;
    find("#restroke").disabled = !mask?.undone.length;
    if (words !== undefined) find("#paint-trouble").textContent = trouble ? words : "";
    if (words !== undefined) this.say(words, trouble);
    this.steps.describe();
  }

  open(tab, focus = false) {
    this.tab = tab;
    for (const button of all("[role=tab]")) {
      const own = button.id === "tab-" + tab;
      button.setAttribute("aria-selected", own);
      button.tabIndex = own ? 0 : -1;
      find("#" + button.getAttribute("aria-controls")).hidden = !own;
      if (own && focus) button.focus();
    }
    if (tab !== "paint") this.setTool("turn");
    if (tab === "save") this.save.recipe();
  }

  setTool(tool) {
    this.paint?.cancel();
    if (this.paint) this.paint.tool = tool;
    find(`[name=tool][value=${tool}]`).checked = true;
    find(".stage").dataset.tool = tool;
  }

  setBrush(radius) {
    if (!(radius > 0 && Number.isFinite(radius))) return false;
    this.paint.radius = radius;
    find("#brush-range").value = Math.log10(radius / this.viewer.camera.radius);
    return true;
  }

  /** A click in the view: where it is, and the hole there. */
  clicked(event, at) {
    const met = this.viewer.pick(...at);
    if (met.point) this.point.choose(met.point, event.altKey || event.ctrlKey || event.metaKey);
    if (this.tab === "paint") return;
    const end = this.creases.at(at);
    if (end !== null) {
      this.open("holes");
      this.creases.choose(end);
      return;
    }
    const id = this.holes.at(met);
    if (id !== null) {
      this.open("holes");
      this.holes.choose(id, false);
    }
  }
}

/** The tabs, by pointer and by keys. */
function useTabs(app) {
  const names = all("[role=tab]").map((tab) => tab.id.slice(4));
  for (const tab of all("[role=tab]")) {
    tab.addEventListener("click", () => app.open(tab.id.slice(4)));
    tab.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key], at = names.indexOf(tab.id.slice(4));
      const to = by ? names[(at + by + names.length) % names.length] : { Home: names[0], End: names[names.length - 1] }[event.key];
      if (!to) return;
      event.preventDefault();
      app.open(to, true);
    });
  }
}

/** The controls of the mask. */
function useMask(app) {
  const { paint } = app, on = (query, act) => find(query).addEventListener("click", () => app.attempt("#paint-trouble", async () => {
    if (!app.mask()) throw new Error("the surface is still being prepared for painting");
    await act(app.mask());
  }));
  const length = () => {
    const value = numberIn(find("#grow-by").value);
    if (!(value > 0 && Number.isFinite(value))) throw new Error("the length to grow or shrink by must be positive");
    return value;
  };
  const take = (mask, numbers) => {
    const wanted = new Set(numbers);
    mask.change((f) => wanted.has(f));
    paint.redraw();
  };
  for (const input of all("[name=tool]")) input.addEventListener("change", () => app.setTool(input.value));
  find("#erase").addEventListener("change", () => { paint.erases = find("#erase").checked; });
  find("#facing").addEventListener("change", () => { paint.facing = find("#facing").checked; });
  find("#brush").addEventListener("input", () => find("#brush").setAttribute("aria-invalid", !app.setBrush(numberIn(find("#brush").value))));
  find("#brush-range").addEventListener("input", () => {
    app.setBrush(app.viewer.camera.radius * 10 ** Number(find("#brush-range").value));
    find("#brush").value = Number(paint.radius.toPrecision(3));
  });
  on("#grow", () => paint.grow(length(), false));
  on("#shrink", () => paint.grow(length(), true));
  on("#invert", (mask) => { mask.change((f) => !mask.on[f]); paint.redraw(); });
  on("#clear", (mask) => { mask.change(() => false); paint.redraw(); });
  on("#unstroke", (mask) => { mask.undo(); paint.redraw(); });
  on("#restroke", (mask) => { mask.redo(); paint.redraw(); });
  on("#mask-load", async (mask) => {
    const { runs, faces } = await askJson("mask/load", { path: find("#mask-path").value.trim() });
    take(mask, runs ? runs.flatMap(([a, b]) => Array.from({ length: b - a }, (_, i) => a + i)) : faces);
  });
  on("#mask-save", async () => {
    const { path } = await app.save.write("mask", find("#mask-path").value.trim() || "mask.txt", find("#overwrite").checked);
    app.say(`The mask is saved as ${path}.`);
  });
  find("#mask-file").addEventListener("change", () => app.attempt("#paint-trouble", async () => {
    const [file] = find("#mask-file").files;
    if (file) take(app.mask(), facesOf(await file.text(), app.mask().on.length));
  }));
  for (const kind of ["restore", "fair"]) find("#to-" + kind).addEventListener("click", () => { app.steps.show(kind); app.open("mend", true); });
}

/** Moves the cross by keys; Enter uses it. */
function useCross(app) {
  const { canvas } = app.viewer, cross = find("#cross"), place = [0.5, 0.5];
  const at = () => [place[0] * canvas.clientWidth, place[1] * canvas.clientHeight];
  const draw = () => {
    [cross.style.left, cross.style.top] = at().map((x) => x + "px");
  };
  canvas.addEventListener("focus", () => { cross.hidden = !canvas.matches(":focus-visible"); draw(); });
  canvas.addEventListener("blur", () => { cross.hidden = true; });
  canvas.addEventListener("pointerdown", () => { cross.hidden = true; });
  canvas.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (by && event.altKey) {
      event.preventDefault();
      event.stopImmediatePropagation();
      for (const k of [0, 1]) place[k] = Math.min(1, Math.max(0, place[k] + 0.02 * by[k]));
      cross.hidden = false;
      draw();
    }
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    cross.hidden = false;
    draw();
    if (!app.paint.key(at(), event.shiftKey || app.paint.erases)) app.clicked(event, at());
  }, true);
}

/** The keys of the page. */
function useViewKeys(app) {
  const { display, holes, steps, viewer, paint } = app;
  const option = (name) => display.option(name, !viewer.options[name]);
  const show = (name) => find("fieldset.change").disabled || display.option("show", name);
  const press = (query) => find(query).disabled || find(query).click();
  const doing = (what) => holes.chosen !== null && holes.set(holes.chosen, what);
  const tool = (name) => { app.open("paint"); app.setTool(name); };
  const brush = (factor) => { app.setBrush(paint.radius * factor); find("#brush").value = Number(paint.radius.toPrecision(3)); };
  const next = (query) => {
    const select = find(query);
    select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
    select.dispatchEvent(new Event("change"));
  };
  const actions = {
    0: () => viewer.fly(app.home()), 1: () => show("before"), 2: () => show("after"), 3: () => show("both"), 4: () => show("slider"),
    n: () => holes.step(1), p: () => holes.step(-1), i: () => doing("fill"), k: () => doing("open"), l: () => doing("flat"),
    j: () => holes.chosen !== null && holes.bridge(holes.chosen),
    w: () => option("wire"), f: () => option("flat"), r: () => option("rims"), c: () => next("#colour"),
    x: () => { find("#section").value = find("#section").value ? "" : "x"; display.cut(); },
    t: () => tool("turn"), b: () => tool("brush"), o: () => tool("box"), s: () => tool("lasso"), m: () => tool("component"),
    e: () => { app.open("paint"); find("#erase").click(); }, g: () => press("#grow"), d: () => press("#shrink"), v: () => press("#invert"),
    "[": () => brush(0.8), "]": () => brush(1.25),
  };
  document.addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase(), typing = event.target.matches?.("input:not([type=checkbox]):not([type=radio]):not([type=range]), select, textarea");
    if ((event.ctrlKey || event.metaKey) && !typing && (key === "z" || key === "y")) {
      event.preventDefault();
      const redoes = key === "y" || event.shiftKey, painting = app.tab === "paint" && (app.mask()?.done.length || app.mask()?.undone.length);
      return press(painting ? (redoes ? "#restroke" : "#unstroke") : redoes ? "#redo" : "#undo");
    }
    if (event.key === "Escape") return paint.started ? paint.cancel() : steps.job ? steps.cancel() : app.setTool("turn");
    if (!event.ctrlKey && !event.metaKey && !event.altKey && !typing) actions[key]?.();
    return undefined;
  });
}

async function begin() {
  const app = window.isomend = new App();
  useTheme(() => app.viewer?.refresh());
  const started = performance.now();
  const state = await app.model.fetchState(), { states, current, scene, parameters, defaults, file, formats } = state;
  // The mesh comes while the graphics card gets ready.
  app.model.mesh(current).catch(() => null);
  app.viewer = new Viewer(find("#view"), { radius: scene.radius, faces: states.find((s) => s.id === current).faces, parts: true });
  app.viewer.options.show = "after";
  const { viewer } = app;
  app.choices = new Choices();
  app.labels = new Labels(viewer, find("#labels"), [], []);
  app.creases = new Creases(app);
  app.display = new Display(app);
  app.holes = new Holes(app);
  app.steps = new Steps(app);
  app.save = new Save(app);
  app.paint = new Paint(viewer, find("#overlay"), () => {
    const mesh = app.mesh();
    return mesh?.topology ? { mesh, mask: mesh.mask, topology: mesh.topology } : null;
  }, (words = "", trouble = false) => app.painted(words, trouble));
  app.steps.start(parameters, defaults);
  app.save.start({ file, formats });
  Object.assign(viewer.camera, app.home());
  app.setBrush(scene.radius / 15);
  find("#brush").value = find("#grow-by").value = Number(app.paint.radius.toPrecision(3));
  useTabs(app);
  useMask(app);
  useCross(app);
  usePointers(viewer, { click: (event, at) => app.clicked(event, at), begin: (event, at) => app.paint.begin(event, at), turns: () => app.paint.tool !== "turn" });
  viewer.canvas.addEventListener("pointermove", (event) => app.paint.ring(event.pointerType === "touch" ? null : [event.offsetX, event.offsetY]));
  viewer.canvas.addEventListener("pointerleave", () => app.paint.ring(null));
  useArrows(viewer);
  useViewKeys(app);
  find("#reset").addEventListener("click", () => viewer.fly(app.home()));
  find("#help").addEventListener("click", () => {
    find("#keys").hidden = !find("#keys").hidden;
    find("#help").setAttribute("aria-expanded", !find("#keys").hidden);
  });
  // One picture, once all is there.
  viewer.waiting = true;
  await app.update(state);
  viewer.waiting = false;
  Object.assign(viewer.camera, app.home());
  const { centre } = viewer.sides.after.mesh;
  app.point = new Point({ radius: scene.radius, origin: centre }, (at) => app.labels.pin(at));
  app.say("");
  viewer.draw();
  viewer.gl.readPixels(0, 0, 1, 1, viewer.gl.RGBA, viewer.gl.UNSIGNED_BYTE, new Uint8Array(4));
  app.times = { opened: performance.now() - started, first: performance.now() };
  listen((name, told) => app.steps.hear(name, told).catch((error) => app.say(error.message, true)), {
    lost: () => app.steps.lose(),
    back: () => app.steps.again().catch((error) => app.say(error.message, true)),
  });
  document.documentElement.dataset.state = "ready";
  if (state.earlier) app.say(`An earlier session of this file was not saved. ${state.earlier} keeps its steps: isomend view --resume makes them again.`);
  await app.display.ready(viewer.sides.after.mesh);
  app.painted();
}

begin().catch((error) => {
  document.documentElement.dataset.state = "failed";
  find("#message").textContent = "The page cannot be shown: " + error.message;
  find("#message").classList.add("trouble");
});
