// Controls shared by all pages with a 3D view: pointers, arrow keys, dark and light theme, the colour scale, and formatting of numbers.

import { facing, rimFacing } from "./geometry.js";

export const find = (query) => document.querySelector(query);
export const all = (query) => [...document.querySelectorAll(query)];

/** Lengths below this fraction of the object's size are rounding errors. */
const NOTHING = 1e-9;

/** The formats of numbers, by language and options: making one takes time. */
const formats = new Map();

/** A number in the page's language. German groups digits by narrow spaces, since a point could be taken for a decimal mark. */
export function number(x, options = {}) {
  const language = document.documentElement.lang || "en", key = language + JSON.stringify(options);
  if (!formats.has(key)) formats.set(key, new Intl.NumberFormat(language, options));
  return formats.get(key).formatToParts(x).map(({ type, value }) => type === "group" && language === "de" ? "\u202f" : value).join("");
}

/** The digits of a number, ungrouped. */
export const localised = (x) => number(x, { maximumSignificantDigits: 6, useGrouping: false });

/** A number with four significant digits; 0 if it is only a rounding error for an object of this size. */
export function digits(x, size = 0) {
  if (x === 0 || Math.abs(x) <= NOTHING * Math.abs(size)) return "0";
  const isPlain = Math.abs(x) >= 1e-5 && Math.abs(x) < 1e9;
  return number(x, { maximumSignificantDigits: 4, useGrouping: false, ...isPlain ? {} : { notation: "scientific" } });
}

/** A button that does not send a form. */
export function newButton(words, act, properties = {}) {
  const button = Object.assign(document.createElement("button"), { type: "button", textContent: words, ...properties });
  button.addEventListener("click", act);
  return button;
}

/** Parses a number with a decimal point or comma; NaN if the text is not a number. */
export const numberIn = (text) => text.trim() ? Number(text.trim().replace(",", ".")) : NaN;

/** The colours of the rising scale, at equal distances, as in the shader: red, green and blue. */
const RISING = [[51, 43, 107], [41, 117, 143], [107, 186, 102], [247, 230, 64]];
const GRADIENTS = {
  1: "linear-gradient(90deg,#0a3380,#428fd6 25%,#ededeb 50%,#e66b52 75%,#80081a)",
  2: `linear-gradient(90deg,${RISING.map((rgb) => `rgb(${rgb})`)})`,
};

/** The colour of the rising scale at a place from 0 to 1. */
export function rising(place) {
  const at = Math.min(1, Math.max(0, place)) * (RISING.length - 1), i = Math.min(RISING.length - 2, Math.floor(at));
  return `rgb(${RISING[i].map((x, k) => Math.round(x + (at - i) * (RISING[i + 1][k] - x)))})`;
}

/** Shows the colour scale: diverging (1) or rising (2); with `gaps`, also the stripes for unknown values. */
export function showScale(name, low, high, kind, gaps = false) {
  find("#scale").hidden = false;
  find("#scale-name").textContent = name;
  find("#scale-low").textContent = low;
  find("#scale-high").textContent = high;
  find("#scale-gaps").hidden = !gaps;
  find("#scale-bar").style.background = GRADIENTS[kind];
}

/** The direction from which a hole is seen best: the mean normal of its patch, else the normal of its rim, else outward. */
export function directionTo(hole, rim = [], mesh = null) {
  const patch = mesh && hole.region ? facing(mesh, hole.region) : { area: 0 };
  if (patch.area > 0 && Math.hypot(...patch.sum) > 0.3 * patch.area) return patch.sum;
  const towards = rimFacing(rim);
  if (Math.hypot(...towards) > 0.05 * hole.diameter ** 2) return towards;
  return Math.hypot(...hole.centre) > 0 ? hole.centre : [0, -1, 0.3];
}

/**
 * Rotates, shifts and zooms by mouse and touch. `click` is called with the event and its position. `begin` may take over a pointer; it then
 * returns an object that handles its moves and its end. If `turns()` is true, the right button rotates instead of shifting.
 */
export function usePointers(viewer, { click, begin = () => null, turns = () => false }) {
  const { canvas } = viewer;
  const down = new Map();
  let moved = 0, taken = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (!down.size) moved = 0;
    down.set(event.pointerId, at(event));
    viewer.flight = null;
    if (down.size === 1) taken = begin(event, at(event));
    else if (taken) { taken.end(event, true); taken = null; }
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    if (taken) return taken.move(event, at(event));
    const now = at(event), dx = now[0] - before[0], dy = now[1] - before[1];
    const half = viewer.aim(...now).half;
    moved += Math.hypot(dx, dy);
    if (down.size === 2) {
      const [, other] = [...down].find(([id]) => id !== event.pointerId);
      const span = (p) => Math.max(Math.hypot(p[0] - other[0], p[1] - other[1]), 1);
      viewer.camera.zoom(span(before) / span(now));
      viewer.camera.shift(dx / 2 / half, dy / 2 / half);
    } else if (event.shiftKey || event.buttons & (turns() ? 4 : 6)) {
      viewer.camera.shift(dx / half, dy / half);
    } else {
      viewer.camera.orbit(dx / half * 1.6, dy / half * 1.6);
    }
    down.set(event.pointerId, now);
    viewer.moving();
  });
  const up = (event) => {
    const was = down.delete(event.pointerId);
    if (was && taken) {
      taken.end(event, event.type !== "pointerup");
      taken = null;
      return;
    }
    if (!was || down.size || moved > 4 || event.type !== "pointerup" || event.button !== 0) return;
    click(event, at(event));
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
    viewer.moving();
  }, { passive: false });
}

/** Rotates, shifts and zooms by the arrow keys, plus and minus. */
export function useArrows(viewer) {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  viewer.canvas.addEventListener("keydown", (event) => {
    const arrow = arrows[event.key];
    if (!arrow && !"+=-".includes(event.key)) return;
    event.preventDefault();
    viewer.flight = null;
    if (!arrow) viewer.camera.zoom(event.key === "-" ? 1.15 : 1 / 1.15);
    else if (event.shiftKey) viewer.camera.shift(0.1 * arrow[0], 0.1 * arrow[1]);
    else viewer.camera.orbit(0.12 * arrow[0], 0.12 * arrow[1]);
    viewer.moving();
  });
}

/**
 * Dark or light theme: follows the system until the button is used, which has a name in each theme. `chosen` is the theme that was chosen
 * at an earlier visit, and `choose` is called with the one that the button chooses.
 */
export function useTheme(changed, { names = { dark: "Light", light: "Dark" }, chosen = null, choose = () => null } = {}) {
  const button = find("#theme"), dark = matchMedia("(prefers-color-scheme: dark)");
  const set = (theme) => {
    document.documentElement.dataset.theme = theme;
    button.textContent = names[theme];
    changed();
  };
  let isChosen = Boolean(names[chosen]);
  set(isChosen ? chosen : dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => isChosen || set(dark.matches ? "dark" : "light"));
  button.addEventListener("click", () => {
    isChosen = true;
    set(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
    choose(document.documentElement.dataset.theme);
  });
}
