// Opening meshes: the list of the folder and of the recent files, a file chooser, and dropped files.

import { find } from "../../report/viewer/controls.js";
import { askJson, sendBytes } from "./net.js";
import { fileSize, tr } from "./strings.js";

export class Opener {
  /** `leave` is awaited before the browser goes to another page; `opened` is called if a file is open on this page already. */
  constructor(box, { leave = async () => null, opened = () => null } = {}) {
    Object.assign(this, { leave, opened });
    const part = (name, words = "") => Object.assign(document.createElement(name), { textContent: words });
    this.filter = Object.assign(part("input"), { type: "text", id: "open-path", spellcheck: false });
    this.filter.placeholder = tr("filter_files");
    this.filter.setAttribute("autocomplete", "off");
    this.filter.setAttribute("aria-label", tr("filter_files"));
    this.trouble = Object.assign(part("p"), { id: "open-trouble", className: "trouble" });
    this.trouble.setAttribute("role", "alert");
    this.said = Object.assign(part("p"), { id: "open-said", className: "hint" });
    this.said.setAttribute("role", "status");
    this.recentHead = part("h3", tr("recent_files"));
    this.recent = Object.assign(part("ul"), { id: "recent-files", className: "files" });
    this.folderHead = part("h3", tr("in_folder"));
    this.list = Object.assign(part("ul"), { id: "folder-files", className: "files" });
    const label = Object.assign(part("label", tr("drop_or_choose")), { className: "chooser" });
    this.chooser = Object.assign(part("input"), { type: "file", id: "choose-file", multiple: true });
    label.append(this.chooser);
    box.append(label, this.filter, this.trouble, this.said, this.recentHead, this.recent, this.folderHead, this.list);
    this.filter.addEventListener("input", () => this.put());
    this.filter.addEventListener("keydown", (event) => event.key === "Enter" && this.open(this.matched()));
    this.chooser.addEventListener("change", () => {
      const files = [...this.chooser.files];
      // So that the same file can be chosen again.
      this.chooser.value = "";
      this.send(files);
    });
    this.files = [];
    this.recentHead.hidden = this.recent.hidden = true;
  }

  /** Fetches the list. */
  async update() {
    const { files, sizes, recent, root } = await askJson("files");
    this.files = files.map((name, i) => ({ name, size: sizes[i] }));
    this.latest = recent.map((name) => ({ name, size: this.files.find((file) => file.name === name)?.size }));
    this.folderHead.textContent = `${tr("in_folder")} ${root}`;
    this.put();
    return files;
  }

  /** Whether the name of a file contains the text of the filter. */
  fits({ name }) {
    return name.toLowerCase().includes(this.filter.value.trim().toLowerCase());
  }

  /** The file that Enter in the filter opens: the only one that is listed, else the one of the typed name. */
  matched() {
    const typed = this.filter.value.trim(), listed = new Set([...this.latest || [], ...this.files].filter((file) => this.fits(file)).map(({ name }) => name));
    return typed && listed.size === 1 ? [...listed][0] : typed;
  }

  put() {
    const fits = (file) => this.fits(file), latest = (this.latest || []).filter(fits);
    this.recentHead.hidden = this.recent.hidden = !latest.length;
    this.recent.replaceChildren(...latest.map((file) => this.row(file)));
    this.list.replaceChildren(...this.files.filter(fits).map((file) => this.row(file)));
  }

  row({ name, size }) {
    const item = document.createElement("li"), button = document.createElement("button"), text = document.createElement("span"), small = document.createElement("small");
    button.type = "button";
    text.textContent = button.title = name;
    small.textContent = size === undefined ? "" : fileSize(size);
    button.append(text, small);
    button.addEventListener("click", () => this.open(name));
    item.append(button);
    return item;
  }

  /** Runs `act`, and shows its error. */
  async attempt(act) {
    this.trouble.textContent = this.said.textContent = "";
    try {
      await act();
    } catch (error) {
      this.trouble.textContent = error.message;
    }
  }

  /** Opens a file of the folder: its own page replaces this one in the browser. */
  open(path) {
    return this.attempt(async () => {
      if (!path) throw new Error(tr("type_name"));
      await this.leave();
      const { page } = await askJson("open", { path });
      if (page === location.pathname) return this.opened(path);
      return location.assign(page);
    });
  }

  /** Sends files from the user's computer to the folder, one after the other. A single one is opened; of several, each is named as taken or refused. */
  send(files) {
    return this.attempt(async () => {
      const taken = [], refused = [];
      for (const file of files) {
        this.said.textContent = tr("sending_file", { name: file.name });
        await sendBytes(`send?name=${encodeURIComponent(file.name)}`, file).then(({ path }) => taken.push(path), (error) => refused.push(`${file.name}: ${error.message}`));
      }
      this.said.textContent = "";
      if (files.length === 1 && taken.length) return this.open(taken[0]);
      if (taken.length) await this.update();
      if (taken.length) this.said.textContent = tr("taken_files", { names: taken.join(", ") });
      if (refused.length) throw new Error(refused.join("\n"));
      return undefined;
    });
  }
}

/** Handles files that are dropped on the page. */
export function useDrop(taken) {
  const sign = find("#drop"), over = (event, shown) => {
    event.preventDefault();
    sign.hidden = !shown;
  };
  document.addEventListener("dragover", (event) => over(event, true));
  document.addEventListener("dragleave", (event) => event.relatedTarget || over(event, false));
  document.addEventListener("drop", (event) => {
    over(event, false);
    const files = [...event.dataTransfer.files];
    if (files.length) taken(files);
  });
}
