// Ties the view to the lists, the tools and the keys.

const find = (query) => document.querySelector(query);
const all = (query) => [...document.querySelectorAll(query)];
const data = JSON.parse(find("#data").textContent);
const message = find("#message");
const holes = new Map(data.holes.map((hole, index) => [hole.id, { ...hole, index }]));
let viewer = null, labels = null, point = null, current = null;

function say(text, trouble = false) {
  message.textContent = text;
  message.classList.toggle("trouble", trouble);
}

/** Four digits that count. */
const digits = (x) => x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(2) : x.toPrecision(3);

// Tools.

function option(name, value) {
  const inputs = all(`[name="${name}"]`);
  for (const input of inputs) input.checked = input.type === "radio" ? input.value === value : value;
  if (!viewer) return;
  viewer.options[name] = value;
  showSides();
  showScale();
  viewer.refresh();
}

function showSides() {
  const show = viewer.options.show;
  find(".stage").classList.toggle("both", show === "both");
  find("#left").hidden = data.single;
  find("#left").textContent = show === "after" ? "After" : "Before";
  find("#right").hidden = show !== "both";
}

function showScale() {
  const { curvature, distance } = data.scene, colour = viewer.options.colour;
  find("#scale").hidden = colour === "plain";
  if (colour === "curvature") {
    find("#scale-name").textContent = "sum of the principal curvatures, 1/length";
    find("#scale-low").textContent = "−" + digits(curvature);
    find("#scale-high").textContent = digits(curvature);
    find("#scale-bar").style.background = "linear-gradient(90deg,#0a3380,#428fd6 25%,#ededeb 50%,#e66b52 75%,#80081a)";
  } else if (colour === "distance") {
    find("#scale-name").textContent = "distance of what is new or gone from the other mesh";
    find("#scale-low").textContent = "0";
    find("#scale-high").textContent = digits(distance);
    find("#scale-bar").style.background = "linear-gradient(90deg,#332b6b,#29758f 33%,#6bba66 67%,#f7e640)";
  }
}

// Holes.

/** The direction from which a hole is seen best. */
function directionTo(hole) {
  const patch = facing(viewer.mesh, hole.region);
  if (hole.region && patch.area > 0 && Math.hypot(...patch.sum) > 0.3 * patch.area) return patch.sum;
  const rim = rimFacing(viewer.mesh.rims[hole.index] || []);
  if (Math.hypot(...rim) > 0.05 * hole.diameter ** 2) return rim;
  return Math.hypot(...hole.centre) > 0 ? hole.centre : viewer.camera.axes[2];
}

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
    axes: frame(directionTo(hole), data.scene.up),
    reach: Math.max(0.85 * hole.diameter, 1e-4 * data.scene.radius),
  });
  try {
    history.replaceState(null, "", "#hole-" + id);
  } catch { /* Some browsers forbid it for files. */ }
}

function step(by) {
  const ids = data.holes.map((hole) => hole.id);
  if (!ids.length) return;
  const at = current === null ? (by > 0 ? -1 : 0) : ids.indexOf(current);
  choose(ids[(at + by + ids.length) % ids.length]);
}

/** Where one looks from first; the perspective needs some more room than the parallel lines that it was fitted to. */
const home = () => ({ centre: data.scene.centre, axes: frame(data.scene.towards, data.scene.up), reach: 1.08 * data.scene.reach });

function reset() {
  choose(null);
  viewer.fly(home());
}

/** The hole of a patch that was met, or a hole whose opening is under the pointer. */
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

// Pointers: one turns or shifts, two zoom and shift.

function usePointers(canvas) {
  const down = new Map();
  let moved = 0;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (!down.size) moved = 0;
    down.set(event.pointerId, at(event));
    viewer.flight = null;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = at(event), dx = now[0] - before[0], dy = now[1] - before[1];
    const half = viewer.aim(...now).half;
    moved += Math.hypot(dx, dy);
    if (down.size === 2) {
      const [, other] = [...down].find(([id]) => id !== event.pointerId);
      const span = (p) => Math.max(Math.hypot(p[0] - other[0], p[1] - other[1]), 1);
      viewer.camera.zoom(span(before) / span(now));
      viewer.camera.shift(dx / 2 / half, dy / 2 / half);
    } else if (event.shiftKey || event.buttons & 6) {
      viewer.camera.shift(dx / half, dy / half);
    } else {
      viewer.camera.orbit(dx / half * 1.6, dy / half * 1.6);
    }
    down.set(event.pointerId, now);
    viewer.refresh();
  });
  const up = (event) => {
    const was = down.delete(event.pointerId);
    if (!was || down.size || moved > 4 || event.type !== "pointerup" || event.button !== 0) return;
    const met = viewer.pick(...at(event));
    if (met.point) point.choose(met.point, event.altKey || event.ctrlKey || event.metaKey);
    const id = holeAt(met);
    if (id !== null && id !== current) choose(id);
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", (event) => {
    const { point } = viewer.pick(...at(event));
    if (point) viewer.fly({ ...viewer.camera, centre: point, axes: viewer.camera.axes, reach: viewer.camera.reach });
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    viewer.flight = null;
    const aim = viewer.aim(...at(event)), lines = event.deltaMode === 1 ? 18 : 1;
    viewer.camera.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, event.deltaY * lines * 0.0016))), aim.x, aim.y);
    viewer.refresh();
  }, { passive: false });
}

// Keys.

function useKeys(canvas) {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    const arrow = arrows[event.key];
    if (!arrow && !"+=-".includes(event.key)) return;
    event.preventDefault();
    viewer.flight = null;
    if (!arrow) viewer.camera.zoom(event.key === "-" ? 1.15 : 1 / 1.15);
    else if (event.shiftKey) viewer.camera.shift(0.1 * arrow[0], 0.1 * arrow[1]);
    else viewer.camera.orbit(0.12 * arrow[0], 0.12 * arrow[1]);
    viewer.refresh();
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("input[type=text]")) return;
    const options = viewer.options, colours = data.single ? ["plain", "curvature"] : ["plain", "curvature", "distance"];
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

// Dark and light.

function useTheme() {
  const button = find("#theme"), dark = matchMedia("(prefers-color-scheme: dark)");
  const set = (theme) => {
    document.documentElement.dataset.theme = theme;
    button.textContent = theme === "dark" ? "Light" : "Dark";
    viewer?.refresh();
  };
  set(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => set(dark.matches ? "dark" : "light"));
  button.addEventListener("click", () => set(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
}

async function begin() {
  useTheme();
  all("[data-hole]").forEach((item) => item.addEventListener("click", (event) => {
    event.preventDefault();
    choose(Number(item.dataset.hole), false);
    if (item.tagName === "A") find("#look").scrollIntoView();
  }));
  if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the meshes; a newer one can");
  const mesh = await unpack(find("#geometry").textContent, data.scene);
  viewer = new Viewer(find("#view"), mesh, data.holes.map((hole) => hole.open));
  labels = new Labels(viewer, find("#labels"), data.holes);
  point = new Point(data.scene, (at) => labels.pin(at));
  window.isomend = { viewer, choose, labels, point };
  for (const input of all(".tools input")) {
    input.addEventListener("change", () => option(input.name, input.type === "radio" ? input.value : input.checked));
    if (input.type === "checkbox") option(input.name, input.checked);
  }
  option("show", data.single ? (mesh.palette.length ? "after" : "before") : innerWidth < 700 ? "after" : "both");
  find("#reset").addEventListener("click", reset);
  usePointers(viewer.canvas);
  useKeys(viewer.canvas);
  Object.assign(viewer.camera, home());
  say("");
  const linked = /^#hole-(\d+)$/.exec(location.hash);
  if (linked) choose(Number(linked[1]));
  viewer.refresh();
  document.documentElement.dataset.state = "ready";
}

begin().catch((error) => {
  document.documentElement.dataset.state = "failed";
  say("There is no view: " + error.message + ". The tables below are complete.", true);
});
