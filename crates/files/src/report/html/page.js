// The script of an HTML report: connects the 3D view with the list of holes, the tools and the keys.

import { unpack } from "../viewer/geometry.js";
import { cross, frame, minus } from "../viewer/camera.js";
import { Viewer } from "../viewer/viewer.js";
import { Labels } from "../viewer/labels.js";
import { Point } from "../viewer/point.js";
import { bendsOfBoth } from "../viewer/bends.js";
import { all, digits, directionTo, find, showScale, useArrows, usePointers, useTheme } from "../viewer/controls.js";

const data = JSON.parse(find("#data").textContent);
const message = find("#message");
const holes = new Map(data.holes.map((hole, index) => [hole.id, { ...hole, index }]));
let viewer = null, labels = null, point = null, current = null;

function say(text, trouble = false) {
  message.textContent = text;
  message.classList.toggle("trouble", trouble);
}

// Tools.

/** Colour scales: name, kind of gradient, and the array of values, which are fractions of the largest value times 127. */
const SCALES = {
  curvature: { name: "sum of the principal curvatures, 1/length", kind: 1, values: "curvatures" },
  distance: { name: "distance of new and removed faces from the other mesh", kind: 2, values: "distances", skipKept: true },
  error: { name: "expected error of the patches, in the mesh's units", kind: 2, values: "errors", skipKept: true, gaps: true },
};

function option(name, value) {
  const inputs = all(`[name="${name}"]`);
  for (const input of inputs) input.checked = input.type === "radio" ? input.value === value : value;
  if (!viewer) return;
  viewer.options[name] = value;
  showSides();
  if (name === "colour") showColour();
  viewer.refresh();
}

function showSides() {
  const show = viewer.options.show;
  find(".stage").classList.toggle("both", show === "both");
  find("#left").hidden = data.single;
  find("#left").textContent = show === "after" ? "After" : "Before";
  find("#right").hidden = show !== "both";
}

function showColour() {
  const scale = SCALES[viewer.options.colour], { surface } = viewer.sides.after;
  find("#scale").hidden = !scale;
  if (!scale) return surface.setColour({ kind: 0 });
  const most = data.scene[viewer.options.colour], two = scale.kind === 1;
  const values = Float32Array.from(viewer.mesh[scale.values], (x) => x / 127);
  surface.setColour({ ...scale, values, on: 0, span: [two ? -1 : 0, 1] });
  showScale(scale.name, two ? "−" + digits(most) : "0", digits(most), scale.kind, scale.gaps && viewer.mesh.errors.some((x) => x < 0));
}

// Holes.

function choose(id, scroll = true) {
  const hole = holes.get(id);
  current = hole ? id : null;
  for (const button of all("#holes button")) {
    const pressed = Number(button.dataset.hole) === id;
    button.setAttribute("aria-pressed", pressed);
    if (pressed && scroll) button.scrollIntoView({ block: "nearest" });
  }
  for (const row of all(".table tbody tr")) row.classList.toggle("chosen", Number(row.querySelector("a")?.dataset.hole) === id);
  for (const plots of all(".plots")) {
    const own = hole && Number(plots.dataset.region) === hole.region;
    plots.classList.toggle("chosen", Boolean(own));
    if (own) plots.open = true;
  }
  if (!viewer) return;
  viewer.selected = { region: hole?.region || 0, rim: hole ? hole.index : -1 };
  viewer.refresh();
  if (!hole) return say("");
  const button = find(`#holes button[data-hole="${id}"]`);
  say(`${button.querySelector(".name").textContent}: ${button.querySelector(".outcome").textContent}, ${button.querySelector(".size").textContent}`);
  viewer.fly({
    centre: hole.centre,
    axes: frame(directionTo(hole, viewer.mesh.rims[hole.index], viewer.mesh), data.scene.up),
    reach: Math.max(0.85 * hole.diameter, 1e-4 * data.scene.radius),
  });
  try {
    history.replaceState(null, "", "#hole-" + id);
  } catch { /* Some browsers forbid it for files. */ }
}

// Defects.

/** The next place of each kind of defect. */
const nextPlaces = data.defects.map(() => 0);

/** The outward direction at a point: the area-weighted normal of the faces that are near it. */
function outwardAt(place, radius) {
  const { faces, positions } = viewer.mesh, sum = [0, 0, 0];
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => positions.subarray(3 * faces[f + k], 3 * faces[f + k] + 3));
    if (Math.hypot(...minus(a, place)) > radius) continue;
    const n = cross(minus(b, a), minus(c, a));
    for (let k = 0; k < 3; k++) sum[k] += n[k];
  }
  return Math.hypot(...sum) > 0 ? sum : data.scene.towards;
}

/** Moves the view to the next place of a kind of defect. */
function showDefect(kind) {
  const places = data.defects[kind];
  if (!viewer || !places.length) return;
  const at = nextPlaces[kind]++ % places.length, reach = 0.06 * data.scene.radius;
  for (const button of all("#faults button")) button.setAttribute("aria-pressed", Number(button.dataset.defect) === kind);
  say(`${find(`#faults button[data-defect="${kind}"] .name`).textContent}: place ${at + 1} of ${places.length}`);
  labels.pin(places[at]);
  viewer.fly({ centre: places[at], axes: frame(outwardAt(places[at], reach), data.scene.up), reach });
}

function step(by) {
  const ids = data.holes.map((hole) => hole.id);
  if (!ids.length) return;
  const at = current === null ? (by > 0 ? -1 : 0) : ids.indexOf(current);
  choose(ids[(at + by + ids.length) % ids.length]);
}

/** The first camera. A perspective view needs more room than the parallel projection that the camera was fitted for. */
const home = () => ({ centre: data.scene.centre, axes: frame(data.scene.towards, data.scene.up), reach: 1.08 * data.scene.reach });

function reset() {
  choose(null);
  viewer.fly(home());
}

/** The hole of the patch under the pointer, else an open hole under the pointer. */
function holeAt({ aim, region, point }) {
  const own = data.holes.filter((hole) => region && hole.region === region);
  if (own.length) {
    const far = (hole) => Math.hypot(...minus(hole.centre, point));
    return own.reduce((best, hole) => far(hole) < far(best) ? hole : best).id;
  }
  const depth = point ? viewer.place(point).depth : Infinity;
  let best = null;
  for (const hole of data.holes) {
    const p = viewer.place(hole.centre), off = Math.hypot(p.x - aim.x, p.y - aim.y) * p.unit;
    const seen = p.depth > 0 && p.depth < depth + 0.25 * hole.diameter;
    if (seen && off < 0.5 * hole.diameter && (aim.side === "before" || hole.open) && (!best || p.depth < best.depth)) best = { id: hole.id, depth: p.depth };
  }
  return best?.id ?? null;
}

/** A click shows the coordinates of the point and selects the hole there. */
function clicked(event, at) {
  const met = viewer.pick(...at);
  if (met.point) point.choose(met.point, event.altKey || event.ctrlKey || event.metaKey);
  const id = holeAt(met);
  if (id !== null && id !== current) choose(id);
}

// Keys.

function useKeys() {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("input[type=text]")) return;
    const options = viewer.options, colours = ["plain", "curvature", ...data.single ? [] : ["distance"], ...data.scene.error > 0 ? ["error"] : []];
    const actions = {
      0: reset,
      1: () => option("show", "before"),
      2: () => data.single || option("show", "after"),
      3: () => data.single || option("show", "both"),
      n: () => step(1),
      p: () => step(-1),
      w: () => option("wire", !options.wire),
      f: () => option("flat", !options.flat),
      r: () => option("rims", !options.rims),
      c: () => option("colour", colours[(colours.indexOf(options.colour) + 1) % colours.length]),
    };
    actions[event.key.toLowerCase()]?.();
  });
}

async function begin() {
  useTheme(() => viewer?.refresh());
  all("[data-hole]").forEach((item) => item.addEventListener("click", (event) => {
    event.preventDefault();
    choose(Number(item.dataset.hole), false);
    if (item.tagName === "A") find("#look").scrollIntoView();
  }));
  all("[data-defect]").forEach((item) => item.addEventListener("click", () => showDefect(Number(item.dataset.defect))));
  if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the meshes; a newer one can");
  const mesh = await unpack(find("#geometry").textContent, data.scene);
  viewer = new Viewer(find("#view"), { radius: mesh.radius, faces: mesh.faces.length / 3 });
  viewer.mesh = mesh;
  const open = data.holes.map((hole) => hole.open ? 1 : 0), { rims } = mesh;
  viewer.setSide("before", { mesh, ranges: [mesh.parts.kept, mesh.parts.gone], rims, kinds: open, colours: ["bad"] });
  viewer.setSide("after", { mesh, ranges: [mesh.parts.kept, mesh.parts.new], rims, kinds: open, strength: 0.55 });
  viewer.surfaces.get(mesh).setBends(bendsOfBoth(mesh));
  labels = new Labels(viewer, find("#labels"), data.holes, rims);
  labels.setPoints(data.ends.map((at, i) => ({ id: i + 1, at })));
  point = new Point(data.scene, (at) => labels.pin(at));
  window.isomend = { viewer, choose, labels, point };
  for (const input of all(".tools input")) {
    input.addEventListener("change", () => option(input.name, input.type === "radio" ? input.value : input.checked));
    if (input.type === "checkbox") option(input.name, input.checked);
  }
  find("#errors").hidden = !(data.scene.error > 0);
  option("show", data.single ? (mesh.palette.length ? "after" : "before") : innerWidth < 700 ? "after" : "both");
  find("#reset").addEventListener("click", reset);
  usePointers(viewer, { click: clicked });
  useArrows(viewer);
  useKeys();
  Object.assign(viewer.camera, home());
  say("");
  const linked = /^#hole-(\d+)$/.exec(location.hash);
  if (linked) choose(Number(linked[1]));
  viewer.refresh();
  document.documentElement.dataset.state = "ready";
}

begin().catch((error) => {
  document.documentElement.dataset.state = "failed";
  say("The view cannot be shown: " + error.message + ". The tables below are complete.", true);
});
