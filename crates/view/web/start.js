// The main module of the start page of a folder: its meshes and the recent files, a file chooser, dropped files.

import { find } from "../../report/viewer/controls.js";
import { putIcons } from "./icons.js";
import { putWords, usePageTheme } from "./layout.js";
import { Opener, useDrop } from "./opener.js";
import { language, setLanguage, tr } from "./strings.js";

async function beginStart() {
  putWords();
  putIcons();
  find("#language").value = language();
  find("#language").addEventListener("change", () => {
    setLanguage(find("#language").value);
    location.reload();
  });
  usePageTheme(() => null);
  const opener = window.isomend = new Opener(find("#opener-box"));
  useDrop((files) => opener.send(files));
  await opener.update();
  document.documentElement.dataset.state = "ready";
}

beginStart().catch((error) => {
  document.documentElement.dataset.state = "failed";
  find("#root").textContent = tr("cannot_show", { error: error.message });
});
