// The folder of the files: its meshes, the files that were opened lately, new folders.

import { find } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { tr } from "./strings.js";

export class Folder {
  /** `open` opens a file by its path. */
  constructor(app, open) {
    Object.assign(this, { app, open });
    find("#folder-new").addEventListener("click", () => this.ask(find("#folder-row").hidden));
    find("#folder-make").addEventListener("click", () => this.make());
    find("#folder-name").addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.make();
      if (event.key === "Escape") this.ask(false);
    });
  }

  /** Lists the meshes in the folder as suggestions, and the files that were opened lately. */
  async list() {
    const { files, recent } = await askJson("files");
    find("#files").replaceChildren(...files.map((name) => new Option(name, name)));
    find("#recent").hidden = !recent.length;
    find("#recent-files").replaceChildren(...recent.map((name) => this.row(name)));
  }

  row(name) {
    const item = document.createElement("li"), button = Object.assign(document.createElement("button"), { type: "button", textContent: name, title: name });
    button.addEventListener("click", () => this.open(name));
    item.append(button);
    return item;
  }

  /** Shows or hides the field for the name of a new folder. */
  ask(shown) {
    find("#folder-row").hidden = !shown;
    find("#folder-new").setAttribute("aria-expanded", shown);
    find(shown ? "#folder-name" : "#folder-new").focus();
  }

  /** Makes a folder, and suggests to save in it. */
  make() {
    find("#saved").textContent = "";
    return this.app.attempt("#save-trouble", async () => {
      const name = find("#folder-name").value.trim();
      if (!name) throw new Error(tr("type_folder"));
      const { path } = await askJson("folder", { path: name });
      find("#save-path").value = `${path.replaceAll("\\", "/")}/${find("#save-path").value.replace(/^.*\//, "")}`;
      find("#folder-name").value = "";
      this.ask(false);
      find("#saved").textContent = tr("folder_made", { path });
    });
  }
}
