// The main module of the page: start, the app object that connects the other modules, the active tool and tab.

import { begun } from "../../report/viewer/activity.js";
import { Viewer } from "../../report/viewer/viewer.js";
import { Labels } from "../../report/viewer/labels.js";
import { Point } from "../../report/viewer/point.js";
import { all, find, localised, useArrows, usePointers } from "../../report/viewer/controls.js";
import { listen } from "./net.js";
import { Model } from "./model.js";
import { Aspects } from "./aspects.js";
import { Choices } from "./choices.js";
import { Paint, PAINTS } from "./paint.js";
import { Creases } from "./creases.js";
import { Display } from "./display.js";
import { Holes } from "./holes.js";
import { Defects } from "./defects.js";
import { HoleCard } from "./hole_card.js";
import { recallFields, recallView, recalled, remember } from "./memory.js";
import { Opener, useDrop } from "./opener.js";
import { Result } from "./result.js";
import { Verdict } from "./verdict.js";
import { Smoother } from "./smoother.js";
import { Steps } from "./steps.js";
import { Save } from "./save.js";
import { Deliver } from "./deliver.js";
import { Like } from "./like.js";
import { Plane } from "./plane.js";
import { Masks } from "./masks.js";
import { Measure, MEASURES } from "./measure.js";
import { Tabs } from "./tabs.js";
import { Band } from "./band.js";
import { Bottom } from "./bottom.js";
import { Views } from "./views.js";
import { showIntro, useLayout } from "./layout.js";
import { useCross, useViewKeys } from "./keys.js";
import { counts, tr } from "./strings.js";

/** The panes with a command, and the commands of each. */
const JOBS = { holes: ["fill"], paint: ["restore", "fair"], print: ["repair"] };
/** The tab of a tool; opening another tab deactivates the tool. */
const tabOf = (tool) => PAINTS.includes(tool) ? "paint" : tool in MEASURES ? "measure" : null;

class App {
  constructor() {
    this.model = new Model();
    this.tab = "holes";
    this.tool = "turn";
    this.seen = null;
  }

  say(text, trouble = false) {
    find("#message").textContent = text;
    find("#message").classList.toggle("trouble", trouble);
  }

  /** Runs `act`; an error is shown in the element `query`. */
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

  /** The current mesh or its coarse version; null while neither is shown. */
  shown() {
    const mesh = this.viewer?.sides.after?.mesh;
    return mesh && mesh.id === this.model.state.current ? mesh : null;
  }

  /** The current mesh; null while it is not shown. */
  mesh() {
    const mesh = this.shown();
    return mesh?.coarse ? null : mesh;
  }

  mask() {
    return this.mesh()?.mask || null;
  }

  /** The number of marked faces of the current mesh, also while previews are shown instead. */
  marked() {
    return this.mask()?.count ?? this.choices.count(this.model.state.current);
  }

  /** The marked faces, as ranges. */
  marks() {
    return this.mask()?.runs() ?? this.choices.marks.get(this.model.state.current) ?? [];
  }

  /** The unit of lengths with a leading space, or nothing. */
  unit() {
    return this.measure?.unit ? " " + this.measure.unit : "";
  }

  /** The mean edge length of the mesh, estimated from some of its faces. */
  meanEdge() {
    const { positions: p, faces } = this.mesh() || this.viewer.sides.after.mesh, stride = 3 * Math.max(1, Math.floor(faces.length / 30_000));
    let sum = 0, count = 0;
    for (let f = 0; f < faces.length; f += stride, count++) sum += Math.hypot(...[0, 1, 2].map((k) => p[3 * faces[f] + k] - p[3 * faces[f + 1] + k]));
    return sum / (count || 1);
  }

  home() {
    return this.views.home();
  }

  /** Fetches the state and shows it; calls in the meantime share one refresh. */
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
    find("#title").textContent = find("#title").title = state.file.name;
    document.title = `${state.unsaved ? "● " : ""}${state.file.name} – isomend view`;
    document.documentElement.toggleAttribute("data-unsaved", Boolean(state.unsaved));
    find("#subtitle").textContent = `${counts("face", current.faces)}, ${counts("hole", state.holes.length)}${state.unsaved ? ` · ${tr("not_saved")}` : ""} · isomend ${state.program.version}`;
    if (fresh) this.steps.against = false;
    if (fresh) await this.choices.load(state);
    if (fresh) this.defects.renew();
    if (fresh) this.band.take(null);
    this.creases.update(state, fresh);
    this.deliver.update(fresh);
    this.holes.update(state, fresh);
    this.display.offer();
    this.steps.list();
    this.steps.buttons();
    if (state.busy) this.steps.join(state.busy);
    else showIntro(this);
    if (this.tab === "save") this.save.recipe();
    if (fresh) this.card.hide();
    this.steps.previews = this.steps.previews.filter((p) => this.model.find(p.id));
    this.like.update();
    this.result.update();
    if (this.steps.previews.length) return this.steps.showPreviews();
    find("#previews").hidden = true;
    const before = current.parent === null || current.parent === undefined ? null : Number(find("#against").value);
    await this.display.states(state.current, before);
    this.display.mark(this.mesh());
    if (fresh) this.measure.clear();
    this.masks?.list();
    this.painted();
  }

  /** Sends and shows the current mask, with an optional message. */
  painted(words, trouble) {
    const mask = this.mask(), count = this.marked(), faces = this.model.current.faces;
    if (mask && mask.sent !== mask.changes) {
      mask.sent = mask.changes;
      this.choices.mark(mask.mesh.id, mask.runs());
      find("#mend-trouble").textContent = "";
    }
    const marked = count ? tr("marked", { count: counts("face", count), all: counts("face", faces) }) : tr("none_marked");
    const waits = tr(this.steps.previews.length ? "drop_previews" : "still_preparing_mask");
    find("#mask-said").textContent = [marked, ...mask ? this.masks?.reachedWords() ?? [] : [waits]].join(" ");
    find("#mask-hide").disabled = !mask || !count && !this.masks?.isHidden;
    find("#mask-hide").textContent = tr(this.masks?.isHidden ? "mask_unhide" : "mask_hide");
    find("#unstroke").disabled = !mask?.done.length;
    find("#restroke").disabled = !mask?.undone.length;
    if (words !== undefined) find("#paint-trouble").textContent = trouble ? words : "";
    if (words !== undefined) this.say(words, trouble);
    this.steps.describe();
  }

  /** Opens a pane: a job, the measurements, the history, or saving. Painting begins with the brush. */
  open(tab, focus = false) {
    const isTab = find("#tab-" + tab).getAttribute("role") === "tab", from = this.tab;
    this.tab = tab;
    for (const button of all("[data-pane]")) {
      const own = button.dataset.pane === tab, is = button.getAttribute("role") === "tab";
      button.setAttribute(is ? "aria-selected" : "aria-pressed", own);
      if (is && (own || isTab)) button.tabIndex = own ? 0 : -1;
      find("#pane-" + button.dataset.pane).hidden = !own;
      if (own && focus) button.focus();
    }
    this.showJob();
    if (tabOf(this.tool) !== tab) this.setTool(tab === "paint" && this.paint ? "brush" : "turn");
    if (tab === "check" && from !== "check") {
      this.defects?.check();
      this.aspects?.choose(this.aspects.chosen);
    } else if (from === "check" && tab !== "check") this.aspects?.leave();
    // Before the page is ready there is nothing to list.
    if (tab === "save") this.save?.recipe();
    if (tab === "save" || tab === "measure" || tab === "paint") this.save?.folder.list().catch(() => null);
    if (tab === "measure") this.measure?.list();
    this.plane?.show();
  }

  /** Whether the open pane has a command. */
  showsJob() {
    return this.tab in JOBS;
  }

  /** Shows the command of the open pane, if it has one. */
  showJob() {
    const own = JOBS[this.tab], { steps } = this;
    find("#mender").hidden = !own;
    find("#mender").dataset.job = this.tab;
    if (own && steps?.forms.fill && !own.includes(steps.kind)) steps.show(own[0]);
  }

  /** Activates a tool, shows its options, and opens its tab. */
  setTool(tool) {
    this.paint?.cancel();
    this.measure?.cancel();
    this.tool = tool;
    if (this.paint) this.paint.tool = tool;
    find(`[name=tool][value=${tool}]`).checked = true;
    find(".stage").dataset.tool = tool;
    for (const row of all("[data-for]")) row.hidden = !row.dataset.for.split(" ").includes(tool);
    if (tabOf(tool) && tabOf(tool) !== this.tab) this.open(tabOf(tool));
  }

  setBrush(radius) {
    if (!(radius > 0 && Number.isFinite(radius))) return false;
    this.paint.radius = radius;
    find("#brush-range").value = Math.log10(radius / this.viewer.camera.radius);
    return true;
  }

  /** Handles a click in the view: shows the point, and chooses the hole or crease end there, or measures. */
  clicked(event, at) {
    const joins = this.card.joins, met = this.viewer.pick(...at), { coarse } = this.viewer.sides[met.aim.side]?.mesh ?? {};
    if (this.tool in MEASURES && coarse) return this.say(tr("still_preparing"), true);
    if (met.point && !coarse) this.point.choose(met.point, event.altKey);
    if (this.tool in MEASURES) return this.measure.click(this.tool, met);
    if (this.tab === "paint") return undefined;
    if (this.aspects.isShown("components")) return this.aspects.components.clicked(met);
    const end = this.creases.at(at);
    if (end !== null) {
      this.open("holes");
      return this.creases.choose(end);
    }
    const id = this.holes.at(met);
    this.card.hide();
    if (id === null) return undefined;
    this.card.joins = joins;
    return this.showHole(id, event);
  }

  /** Chooses a hole that was clicked in the view, and shows its card, unless it is added to others. */
  showHole(id, event) {
    const adds = event.ctrlKey || event.metaKey || event.shiftKey;
    this.open("holes");
    this.holes.choose(id, false, { adds });
    if (!adds && event.clientX !== undefined) this.card.show(id, event.clientX, event.clientY);
  }

  /** Handles a pointer that moves over the view: shows the brush, or highlights the hole under it. */
  moved(event) {
    const at = event && event.pointerType !== "touch" ? [event.offsetX, event.offsetY] : null;
    this.paint.ring(at);
    if (event?.buttons) return;
    cancelAnimationFrame(this.hovering);
    this.endHovering ??= begun("frame");
    this.hovering = requestAnimationFrame(() => {
      this.holes.hover(at && this.tool === "turn" ? this.holes.hoveredAt(at) : null);
      this.endHovering();
      this.endHovering = null;
    });
  }
}

/** Makes a right click on a hole show its card; dragged, the right button shifts the view. */
function useRightClick(app) {
  const { canvas } = app.viewer;
  let down = null;
  canvas.addEventListener("pointerdown", (event) => { down = event.button === 2 ? [event.clientX, event.clientY] : null; });
  canvas.addEventListener("pointerup", (event) => {
    const isClick = down && event.button === 2 && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4;
    down = null;
    if (!isClick || app.tool !== "turn") return;
    const id = app.holes.at(app.viewer.pick(event.offsetX, event.offsetY));
    if (id !== null) app.showHole(id, event);
  });
}

/** Makes the list of files open by its button, and takes dropped files: face numbers become the mask, any other file is opened. */
function useOpener(app) {
  const dialog = find("#opener"), show = () => {
    if (!dialog.open) dialog.showModal();
    app.opener.update().catch((error) => app.say(error.message, true));
  };
  find("#open-button").addEventListener("click", show);
  find("#opener-close").addEventListener("click", () => dialog.close());
  useDrop((files) => {
    if (files.length === 1 && /\.(txt|json|faces)$/i.test(files[0].name)) {
      dialog.close();
      return app.masks.takeFile(files[0]);
    }
    show();
    return app.opener.send(files);
  });
}

async function begin() {
  const app = window.isomend = new App();
  useLayout(app);
  const started = performance.now();
  const state = await app.model.fetchState(), { states, current, scene, parameters, defaults, file, formats } = state;
  // Load the mesh while the graphics card is initialised.
  app.model.firstMesh(current).catch(() => null);
  app.viewer = new Viewer(find("#view"), { radius: scene.radius, faces: states.find((s) => s.id === current).faces, parts: true });
  app.viewer.options.show = "after";
  const { viewer } = app;
  app.choices = new Choices();
  app.labels = new Labels(viewer, find("#labels"), [], []);
  app.views = new Views(app);
  app.measure = new Measure(app);
  app.band = new Band(app);
  app.creases = new Creases(app);
  app.display = new Display(app);
  app.holes = new Holes(app);
  app.defects = new Defects(app);
  app.aspects = new Aspects(app);
  app.like = new Like(app);
  app.plane = new Plane(app);
  app.steps = new Steps(app);
  app.verdict = new Verdict(app);
  app.result = new Result(app);
  app.card = new HoleCard(app);
  app.bottom = new Bottom(app);
  app.save = new Save(app);
  app.deliver = new Deliver(app);
  app.deliver.start(state);
  app.smoother = new Smoother(app);
  app.paint = new Paint(viewer, find("#overlay"), () => {
    const mesh = app.mesh();
    return mesh?.topology ? { mesh, mask: mesh.mask, topology: mesh.topology } : null;
  }, (words = "", trouble = false) => app.painted(words, trouble), app.smoother);
  app.masks = new Masks(app);
  app.tabs = new Tabs(app);
  app.steps.start(parameters, defaults);
  app.like.start(parameters);
  app.measure.changedUnit();
  app.save.start({ file, formats });
  app.verdict.start();
  app.opener = new Opener(find("#opener-box"), {
    leave: () => app.choices.flush(),
    opened: (name) => { find("#opener").close(); app.say(tr("is_open", { name })); },
  });
  useOpener(app);
  const before = recalled();
  if (before) recallFields(app, before);
  Object.assign(viewer.camera, app.home());
  app.setBrush(scene.radius / 15);
  find("#brush").value = find("#grow-by").value = localised(Number(app.paint.radius.toPrecision(3)));
  const place = viewer.drawn;
  viewer.drawn = (part) => {
    place(part);
    if (part) return;
    app.views.drawn();
    app.measure.draw();
    app.plane.drawn();
    app.holes.drawOver();
  };
  useCross(app);
  usePointers(viewer, { click: (event, at) => app.clicked(event, at), begin: (event, at) => app.paint.begin(event, at), turns: () => PAINTS.includes(app.tool) });
  viewer.canvas.addEventListener("pointermove", (event) => app.moved(event));
  viewer.canvas.addEventListener("pointerleave", () => app.moved(null));
  useRightClick(app);
  useArrows(viewer);
  useViewKeys(app);
  // Draw only once, when everything is loaded.
  viewer.waiting = true;
  await app.update(state);
  viewer.waiting = false;
  Object.assign(viewer.camera, app.home());
  const { centre } = viewer.sides.after.mesh;
  const words = { wrong: tr("radius_positive"), copied: tr("copied", { text: "TEXT" }), byHand: tr("copy_by_hand") + " TEXT" };
  app.point = new Point({ radius: scene.radius, origin: centre }, (at) => app.labels.pin(at), words);
  find("#point-at").textContent = tr("click_surface");
  app.say("");
  viewer.draw();
  viewer.gl.readPixels(0, 0, 1, 1, viewer.gl.RGBA, viewer.gl.UNSIGNED_BYTE, new Uint8Array(4));
  app.times = { opened: performance.now() - started, first: performance.now() };
  listen((name, data) => app.steps.hear(name, data).catch((error) => app.say(error.message, true)), {
    lost: () => app.steps.lose(),
    back: () => app.steps.again().catch((error) => app.say(error.message, true)),
  });
  app.steps.presets.enable();
  app.open(app.tab);
  if (before) await recallView(app, before);
  addEventListener("pagehide", () => remember(app));
  document.documentElement.dataset.state = "ready";
  if (state.earlier) app.say(tr("earlier_session", { path: state.earlier }));
  await app.display.ready(viewer.sides.after.mesh);
  app.painted();
}

begin().catch((error) => {
  document.documentElement.dataset.state = "failed";
  find("#message").textContent = tr("cannot_show", { error: error.message });
  find("#message").classList.add("trouble");
});
