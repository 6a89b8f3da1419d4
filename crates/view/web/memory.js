// What a reload keeps, also one for another language: camera, tab, tool, fields, presets, chosen holes, measurements, previews and a running
// preview. The program keeps steps, choices and masks. Undo of strokes, points that were clicked, and an open outline are lost.

import { all, find, localised, numberIn } from "../../report/viewer/controls.js";

/** The name of the stored state; each page of a file has its own. */
const KEY = "isomend-page" + location.pathname;
/** The fields that are kept. */
const FIELDS = "#panel :is(input, select)[id]:not([type=file]), .sheet :is(input, select)[id]";

/** Stores the state of the page for a reload. */
export function remember(app) {
  const { camera, options } = app.viewer, { job, previews, presets } = app.steps;
  const fields = Object.fromEntries(all(FIELDS).map((field) => [field.id, field.type === "checkbox" ? field.checked : field.value]));
  const chosen = Object.fromEntries(Object.entries(presets.chosen).map(([kind, preset]) => [kind, preset.name]));
  sessionStorage.setItem(KEY, JSON.stringify({
    current: app.model.state.current, camera: { centre: camera.centre, axes: camera.axes, reach: camera.reach }, tab: app.tab, tool: app.tool, kind: app.steps.kind, show: options.show, colour: app.display.colour, aspect: app.aspects.chosen,
    fields, chosen, measures: app.measure.items, picked: [...app.holes.picked], chosenHole: app.holes.chosen,
    previews, job: job?.preview ? { id: job.id, kind: job.kind, label: job.label, settings: job.settings } : null,
  }));
}

/** What the page before a reload has stored, or null. */
export function recalled() {
  try {
    return JSON.parse(sessionStorage.getItem(KEY));
  } catch {
    return null;
  }
}

/** A value of a field with the decimal mark of the page's language. Its digits stay as they were typed. */
const inLanguage = (value) => typeof value === "string" && Number.isFinite(numberIn(value)) ? value.replace(/[.,]/, localised(0.5)[1]) : value;

/** The settings of a preview in the page's language. */
const settingsInLanguage = (settings) => settings && {
  ...settings, values: Object.fromEntries(Object.entries(settings.values).map(([name, value]) => [name, inLanguage(value)])),
};

/** Sets the fields and presets of a stored state, before the first picture. */
export function recallFields(app, { fields, chosen, previews, job }) {
  for (const [id, value] of Object.entries(fields)) {
    const field = document.getElementById(id);
    if (!field) continue;
    if (field.type === "checkbox") field.checked = value;
    else field.value = field.inputMode === "decimal" ? inLanguage(value) : value;
  }
  for (const [kind, name] of Object.entries(chosen)) app.steps.presets.choose(kind, name);
  app.bottom.wanted = find("#flat-bottom").checked;
  app.measure.changedUnit();
  app.steps.previews = previews.map((preview) => ({ ...preview, settings: settingsInLanguage(preview.settings) }));
  app.steps.before = job && { ...job, settings: settingsInLanguage(job.settings) };
}

/** Sets the rest of a stored state, once the mesh is shown. */
export async function recallView(app, { current, camera, tab, tool, kind, show, colour, aspect, picked, chosenHole, measures }) {
  app.aspects.chosen = aspect;
  app.open(tab);
  app.setTool(tool);
  app.steps.show(kind);
  // Holes and places belong to a mesh; another tab may have made another one since.
  if (current === app.model.state.current) {
    app.holes.picked = new Set(picked);
    app.holes.chosen = chosenHole;
    app.holes.changed();
    app.measure.items = measures;
    app.measure.list();
  }
  for (const query of ["#section", "#up"]) find(query).dispatchEvent(new Event("input"));
  if (!find("fieldset.change").disabled) app.display.option("show", show);
  await app.display.setColour(colour);
  Object.assign(app.viewer.camera, camera);
  await app.steps.missed();
}
