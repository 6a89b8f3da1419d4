// The frame of the page: folding tools and panels, panes, help, language, dark and light theme.

import { all, find, useTheme } from "../../report/viewer/controls.js";
import { putIcons } from "./icons.js";
import { keep, kept } from "./settings.js";
import { HELP, language, setLanguage, tr } from "./strings.js";

/** What the button for the theme shows in each. */
const THEME_SIGNS = { dark: "☀", light: "☾" };

/** Dark or light theme, which the browser keeps once it is chosen. */
export const usePageTheme = (changed) => useTheme(changed, { names: THEME_SIGNS, chosen: kept("theme", null), choose: (theme) => keep("theme", theme) });

/** Fills in the texts of the chosen language; tooltips name the key. */
export function putWords() {
  const put = { words: "textContent", title: "title" };
  for (const [kind, property] of Object.entries(put)) for (const element of all(`[data-${kind}]`)) element[property] = tr(element.dataset[kind]);
  for (const element of all("[data-key]")) if (element.dataset.key) element.title += ` (${element.dataset.key})`;
  for (const element of all("[data-label]")) element.setAttribute("aria-label", tr(element.dataset.label));
  document.documentElement.lang = language();
}

/** Makes tools and panels foldable. */
function useFolds(app) {
  for (const name of ["rail", "panel"]) {
    const button = find("#fold-" + name), root = document.documentElement;
    const set = (folded) => {
      root.toggleAttribute("data-fold-" + name, folded);
      button.setAttribute("aria-expanded", !folded);
    };
    set(kept("fold-" + name, "") === "yes");
    button.addEventListener("click", () => {
      const folded = !root.hasAttribute("data-fold-" + name);
      set(folded);
      keep("fold-" + name, folded ? "yes" : "");
      app.viewer?.refresh();
    });
  }
}

/** Makes the tabs usable by pointer and keyboard. */
function useTabs(app) {
  const names = all("[role=tab]").map((tab) => tab.id.slice(4));
  for (const button of all("[data-pane]:not([role=tab])")) {
    // A second click leads back to the job.
    button.addEventListener("click", () => app.open(app.tab === button.dataset.pane ? names.find((name) => find("#tab-" + name).tabIndex === 0) : button.dataset.pane));
  }
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

/** Builds the help dialog with keys and gestures. */
function useHelp() {
  const sheet = find("#keys"), list = find("#keys-list");
  for (const [heading, rows] of HELP) {
    const dl = document.createElement("dl");
    for (const [key, what] of rows) {
      const row = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = tr(key);
      dd.textContent = tr(what);
      row.append(dt, dd);
      dl.append(row);
    }
    list.append(Object.assign(document.createElement("h3"), { textContent: tr(heading) }), dl);
  }
  find("#help").addEventListener("click", () => {
    sheet.showModal();
    find("#help").setAttribute("aria-expanded", true);
  });
  sheet.addEventListener("close", () => find("#help").setAttribute("aria-expanded", false));
  sheet.addEventListener("click", (event) => event.target === sheet && sheet.close());
  find("#keys-close").addEventListener("click", () => sheet.close());
}

/** Shows the introduction as long as no step was made and the user has not closed it. */
export function showIntro(app) {
  find("#intro").hidden = app.model.state.current !== 0 || app.model.state.states.length > 1 || kept("intro", "") === "seen";
}

/** Reloads the page in another language; does not reload if the choices cannot be sent. */
async function changeLanguage(app) {
  const select = find("#language"), wanted = select.value;
  select.value = language();
  try {
    await app.choices?.flush();
  } catch (error) {
    app.say(error.message, true);
    return;
  }
  setLanguage(wanted);
  location.reload();
}

/** Sets up the frame, before the mesh is loaded. */
export function useLayout(app) {
  putWords();
  putIcons();
  find(".stage").addEventListener("dragstart", (event) => event.preventDefault());
  // A click beside an open sheet closes it.
  document.addEventListener("pointerdown", (event) => { for (const sheet of all(".flyout[open]")) if (!sheet.contains(event.target) && find("#look").contains(event.target)) sheet.open = false; });
  find("#message").textContent = tr("opening");
  find("#language").value = language();
  find("#language").addEventListener("change", () => changeLanguage(app));
  useFolds(app);
  useTabs(app);
  useHelp();
  usePageTheme(() => app.viewer?.refresh());
  find("#intro-close").addEventListener("click", () => {
    find("#intro").hidden = true;
    keep("intro", "seen");
  });
}
