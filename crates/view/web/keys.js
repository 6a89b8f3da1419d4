// Keyboard control: shortcuts of the page, and a cross in the view that keys move in place of a pointer.

import { find, localised } from "../../report/viewer/controls.js";

/** Moves the cross by keys; Enter clicks at it. */
export function useCross(app) {
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

/** Installs the keyboard shortcuts of the page. */
export function useViewKeys(app) {
  const { display, holes, steps, viewer, paint, views } = app;
  const option = (name) => display.option(name, !viewer.options[name]);
  const show = (name) => find("fieldset.change").disabled || display.option("show", name);
  const press = (query) => find(query).disabled || find(query).click();
  const doing = (what) => holes.chosen !== null && holes.set(holes.chosen, what);
  const brush = (factor) => { app.setBrush(paint.radius * factor); find("#brush").value = localised(Number(paint.radius.toPrecision(3))); };
  const next = (query) => {
    const select = find(query);
    select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
    select.dispatchEvent(new Event("change"));
  };
  const actions = {
    0: () => viewer.fly(views.home()), 1: () => show("before"), 2: () => show("after"), 3: () => show("both"), 4: () => show("slider"),
    5: () => views.go("front"), 6: () => views.go("right"), 7: () => views.go("top"), 8: () => views.go("isometric"), 9: () => press("#parallel"),
    n: () => holes.step(1), p: () => holes.step(-1), i: () => doing("fill"), k: () => doing("open"), l: () => doing("flat"),
    j: () => holes.chosen !== null && holes.bridge(holes.chosen),
    w: () => option("wire"), f: () => option("flat"), r: () => option("rims"), h: () => press("#mask-hide"), c: () => next("#colour"), y: () => next("#shading"),
    x: () => { find("#section").value = find("#section").value ? "" : "x"; display.cut(); },
    t: () => app.setTool("turn"), b: () => app.setTool("brush"), z: () => app.setTool("fair"), o: () => app.setTool("box"), s: () => app.setTool("lasso"), m: () => app.setTool("component"),
    u: () => app.setTool("smooth"), q: () => app.setTool("distance"), a: () => views.fitSelected(), ",": () => press("#roll-left"), ".": () => press("#roll-right"),
    e: () => { app.open("paint"); find("#erase").click(); }, g: () => press("#grow"), d: () => press("#shrink"), v: () => press("#invert"),
    "[": () => brush(0.8), "]": () => brush(1.25), "?": () => press("#help"),
  };
  document.addEventListener("keydown", (event) => {
    const key = event.key?.toLowerCase(), typing = event.target.matches?.("input:not([type=checkbox]):not([type=radio]):not([type=range]), select, textarea");
    if ((event.ctrlKey || event.metaKey) && !typing && (key === "z" || key === "y")) {
      event.preventDefault();
      const redoes = key === "y" || event.shiftKey, painting = app.tab === "paint" && app.tool !== "fair" && (app.mask()?.done.length || app.mask()?.undone.length);
      return press(painting ? (redoes ? "#restroke" : "#unstroke") : redoes ? "#redo" : "#undo");
    }
    if ((event.ctrlKey || event.metaKey) && key === "s") {
      event.preventDefault();
      if (app.tab === "save") return press("#save");
      app.open("save");
      return find("#save").focus();
    }
    if (find("#keys").open || find("#opener").open) return undefined;
    if (event.key === "Escape" && !typing) return app.card.hide() ? undefined : paint.started ? paint.cancel() : app.measure.points.length ? app.measure.cancel() : steps.job ? steps.cancel() : app.setTool("turn");
    // On many keyboards brackets and signs need Alt, AltGr or both Ctrl and Alt.
    const isSign = key?.length === 1 && !/[a-z0-9]/.test(key), plain = !event.ctrlKey && !event.altKey || isSign && (event.altKey || event.getModifierState("AltGraph"));
    if (plain && !event.metaKey && !typing) actions[key]?.();
    return undefined;
  });
}
