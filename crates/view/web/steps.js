// Steps: running commands, progress, cancel, previews, undo and redo, history.

import { begun } from "../../report/viewer/activity.js";
import { copy } from "../../report/viewer/point.js";
import { all, digits, find, newButton } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { formsIn } from "./fields.js";
import { Presets } from "./presets.js";
import { stepLine } from "./result.js";
import { counts, has, language, tr } from "./strings.js";

/** Completed fraction of a run from which on the remaining time is shown. */
const MIN_SHARE = 0.04;

/** Seconds as minutes and seconds. */
const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;

export class Steps {
  constructor(app) {
    this.app = app;
    this.forms = {};
    this.job = null;
    this.previews = [];
    this.ended = new Set();
    this.regions = new Map();
    /** The preview that ran when the page was reloaded for another language. */
    this.before = null;
    this.presets = new Presets(app, () => this.describe());
    for (const input of all("[name=kind]")) input.addEventListener("change", () => this.show(input.value));
    find("#run").addEventListener("click", () => this.run(this.kind));
    find("#preview").addEventListener("click", () => this.run(this.kind, { preview: true, only: this.kind === "fill" ? app.holes.only() : null }));
    find("#defaults").addEventListener("click", () => this.presets.reset(this.kind));
    find("#fields").addEventListener("submit", (event) => { event.preventDefault(); this.run(this.kind); });
    find("#fields").addEventListener("change", ({ target }) => { find("#mend-trouble").textContent = this.forms[this.kind].troubleOf(target); });
    find("#fields").addEventListener("input", () => {
      this.presets.follow(this.kind);
      find("#mend-trouble").textContent = "";
      this.describe();
    });
    find("#ask-no").addEventListener("click", () => this.ask(null));
    find("#ask-yes").addEventListener("click", () => this.asked?.());
    find("#cancel").addEventListener("click", () => this.cancel());
    find("#copy-command").addEventListener("click", async () => {
      const text = find("#mend-text").textContent;
      app.say(await copy(text) ? tr("copied", { text }) : tr("copy_by_hand"));
    });
    find("#undo").addEventListener("click", () => this.move("undo"));
    find("#redo").addEventListener("click", () => this.move("redo"));
    find("#against").addEventListener("change", () => this.compare(Number(find("#against").value)));
  }

  get kind() {
    return find("[name=kind]:checked").value;
  }

  /** Builds the forms from the program's parameters and defaults. */
  start(parameters, defaults) {
    this.forms = formsIn(parameters, defaults);
    this.presets.start();
    // A hidden submit button, so that Enter in a field runs the command.
    find("#fields").append(Object.assign(document.createElement("button"), { className: "hidden", tabIndex: -1, textContent: tr("run") }));
    this.show("fill");
  }

  /** Shows a command's form. */
  show(kind) {
    find(`[name=kind][value=${kind}]`).checked = true;
    find("#mender").dataset.kind = kind;
    find("#run").textContent = tr("run_" + kind);
    for (const box of all("#fields > div")) box.hidden = box.id !== "fields-" + kind;
    this.presets.show(kind);
    this.app.like.show(kind);
    find("#mend-trouble").textContent = "";
    this.describe();
  }

  /** Shows the command that would run, and on which holes or faces. */
  describe() {
    if (!this.forms.fill) return;
    const { kind } = this, { holes } = this.app, marked = this.app.marked(), only = holes.only();
    if (kind === "repair") this.app.bottom.show();
    find("#preview").disabled = !this.canPreview();
    const on = {
      fill: !holes.canFill() ? holes.text() : only ? tr("preview_only", { what: holes.chosenName() }) : "", restore: marked ? "" : tr("mark_first"), fair: marked ? "" : tr("on_surface"),
      repair: holes.caps().length ? tr("on_mesh_flat", { ids: holes.caps().join(", ") }) : "",
    };
    const which = kind === "fill" || kind === "repair" ? this.holesOf(kind) : marked ? ["--faces mask.txt"] : [];
    find("#mend-on").textContent = on[kind];
    const isCommand = kind !== "fill" || which[0].startsWith("--");
    find("#copy-command").disabled = !isCommand;
    find("#mend-text").textContent = isCommand ? ["isomend", kind, ...which, ...this.typed(kind)].join(" ") : which[0];
  }

  /** The options of a command that choose holes: of a fill those to fill, of a repair those that it closes flat. */
  holesOf(kind, only = null) {
    const { holes } = this.app;
    return kind === "fill" ? [holes.text(only)] : kind === "repair" ? holes.capsText() : [];
  }

  /** The options of a command that differ from the defaults. */
  typed(kind) {
    return [...this.forms[kind].typed(), ...this.app.like.typed(kind)];
  }

  /** Starts a step or a preview. */
  async run(kind, { preview = false, only = null, sure = false } = {}) {
    this.ask(null);
    const place = this.app.showsJob() ? "#mend-trouble" : "#message";
    await this.app.attempt(place, async () => {
      if (this.job) throw new Error(tr("is_running"));
      const params = this.forms[kind].read(), { like } = this.app;
      like.read(kind, params);
      if (kind === "fill") Object.assign(params, this.app.holes.params(only));
      if (kind === "repair") params.fill.flat = this.app.holes.caps();
      const mask = kind === "restore" || kind === "fair" ? this.app.marks() : [];
      if (kind === "restore" && !mask.length) throw new Error(tr("paint_first"));
      // Faces were marked before: ask whether the whole surface is meant.
      if (kind === "fair" && !mask.length && this.app.choices.masked && !sure) {
        return this.ask(tr("fair_all"), () => this.run(kind, { preview, only, sure: true }));
      }
      const label = ["isomend", kind, ...this.holesOf(kind, only), ...this.typed(kind)].join(" ");
      return this.request(label, { kind, params, mask: mask.length ? mask : null, no_texture: like.noTexture(kind), preview }, preview ? this.presets.settings(kind) : null);
    });
  }

  /** Requests a step, and shows that it runs; `label` is its command line. */
  async request(label, step, settings = null) {
    this.begin(step.kind, Boolean(step.preview), label);
    this.job.settings = settings;
    try {
      await this.app.choices.flush();
      const { job } = await askJson("step", step);
      if (this.job && !this.ended.has(job)) this.job.id = job;
    } catch (error) {
      this.end();
      throw error;
    }
  }

  /** Asks the user before a run; without words, hides the question. */
  ask(words, act = null) {
    this.asked = act;
    find("#ask").hidden = !words;
    find("#ask-words").textContent = words || "";
    if (!words) return;
    this.app.open("paint");
    find("#ask-yes").focus();
  }

  begin(kind, preview, label) {
    this.endJob ??= begun("job");
    this.job = { id: null, kind, preview, label, place: this.app.tab, since: Date.now() / 1000, moved: Date.now() / 1000, share: 0 };
    this.regions.clear();
    find("#job").hidden = false;
    find("#job-name").textContent = tr(preview ? "preview_of" : "running", { what: has("kind_" + kind) ? tr("kind_" + kind) : kind });
    find("#job-line").textContent = "…";
    find("#job-bar").removeAttribute("value");
    find("#job-regions").replaceChildren();
    find("#cancel").disabled = false;
    find("#intro").hidden = true;
    clearInterval(this.clock);
    this.clock = setInterval(() => this.tick(), 500);
    this.tick();
    this.buttons();
  }

  /** Shows a run that was started before the page was opened; after a reload for another language it may be a preview. */
  join({ job, kind, since }) {
    if (this.job || this.ended.has(job)) return;
    const { before } = this, isPreview = before?.kind === kind && (before.id ?? job) === job;
    this.begin(kind, isPreview, isPreview ? before.label : "");
    this.before = null;
    this.job.id = job;
    this.job.settings = isPreview ? before.settings : null;
    this.job.since = since ?? this.job.since;
  }

  /** Adds a preview that ended while the page was reloaded for another language. */
  missed() {
    const { before } = this, made = this.app.model.state.states.filter((s) => s.preview && !this.previews.some(({ id }) => id === s.id)).pop();
    this.before = null;
    return before && made ? this.previewed(made.id, before) : null;
  }

  /** Shows the elapsed and the estimated remaining time of a run. */
  tick() {
    if (!this.job) return;
    const { since, share, moved } = this.job, now = Date.now() / 1000, gone = Math.max(0, now - since);
    // A run that makes no progress for a time is not about to end.
    const left = Math.max(gone * (1 - share) / share, now - moved);
    const rest = share > MIN_SHARE && gone > 2 && left >= 1 ? tr("time_left", { time: clock(left) }) : "";
    find("#job-time").textContent = clock(gone) + rest;
  }

  end() {
    clearInterval(this.clock);
    this.job = null;
    find("#job").hidden = true;
    this.app.smoother.clear();
    this.buttons();
    this.endJob?.();
    this.endJob = null;
  }

  buttons() {
    find("#run").disabled = Boolean(this.job);
    find("#preview").disabled = !this.canPreview();
    find("#fill-all").disabled = Boolean(this.job) || !this.app.holes.canFill();
    find("#fill-chosen").disabled = Boolean(this.job) || !this.app.holes.picked.size;
    const { undo, redo } = this.app.model.state;
    find("#undo").disabled = Boolean(this.job) || !undo;
    find("#redo").disabled = Boolean(this.job) || !redo;
    if (!this.job) this.describe();
  }

  /** Whether a preview can be made: nothing runs, and a fill has a hole to fill. */
  canPreview() {
    return !this.job && (this.kind !== "fill" || this.app.holes.canFill());
  }

  /** Cancels the run. */
  async cancel() {
    if (!this.job) return;
    find("#cancel").disabled = true;
    find("#job-line").textContent = tr("cancelling");
    await this.app.attempt("#message", async () => {
      const job = this.job.id ?? (await this.app.model.fetchState()).busy?.job;
      if (job !== undefined) await askJson("cancel", { job });
    });
  }

  /** Handles an event of the program. */
  async hear(name, data) {
    if (name === "progress") return this.progress(data);
    if (name === "state") return this.app.tabs.changed();
    const { job } = this;
    this.ended.add(data.job);
    this.end();
    if (name === "failed") {
      const words = data.error || tr("run_failed");
      this.app.say(words, true);
      if (job) find("#mend-trouble").textContent = words;
    }
    if (name === "cancelled") this.app.say(tr("cancelled"));
    if (name === "done" && job?.preview) return this.previewed(data.state, job);
    await this.app.refresh();
    if (name === "done") this.app.say(tr("done"));
  }

  /** Shows the progress of a run: finished regions and running ones. */
  progress({ region, regions, hole, stage, share, line }) {
    if (!this.job) this.begin("fill", false, "");
    if (hole && stage === "ended") this.regions.delete(hole);
    else if (hole) this.regions.set(hole, share ?? this.regions.get(hole));
    const ended = regions ? tr("regions_done", { done: region ?? 0, all: counts("region", regions) }) : "";
    // The program's line is in English.
    const own = language() === "en" ? line : "";
    find("#job-line").textContent = [ended, own].filter(Boolean).join("; ");
    const parts = [...this.regions.values()].reduce((sum, part) => sum + (part || 0), 0), total = regions ? ((region ?? 0) + parts) / regions : share;
    if (Number.isFinite(total)) {
      if (total > this.job.share) this.job.moved = Date.now() / 1000;
      find("#job-bar").value = this.job.share = Math.min(1, total);
    }
    const rows = [...this.regions].slice(-12).map(([number, part]) => {
      const item = document.createElement("li"), bar = document.createElement("progress");
      bar.max = 1;
      if (Number.isFinite(part)) bar.value = part;
      bar.setAttribute("aria-label", tr("region_of", { number }));
      item.append(bar, tr("hole_name", { id: number }));
      return item;
    });
    find("#job-regions").replaceChildren(...rows);
  }

  /** Undoes or redoes a step. */
  async move(way) {
    if (find("#" + way).disabled) return;
    await this.app.attempt("#message", async () => {
      await this.app.choices.flush();
      await askJson(way, {});
      await this.app.refresh();
      this.app.say(tr(way === "undo" ? "undone" : "redone", { label: this.labelOf(this.app.model.current) }));
    });
  }

  /** Handles a lost connection to the program. */
  lose() {
    this.lost = true;
    this.app.say(tr("no_answer"), true);
  }

  /** Handles a restored connection: fetches the state, since events may have been missed. */
  async again() {
    if (!this.lost) return;
    this.lost = false;
    this.app.say("");
    await this.app.refresh();
    if (this.job && !this.app.model.state.busy) this.end();
  }

  /** Adds a finished preview. */
  async previewed(id, { label, settings }) {
    await this.app.model.fetchState();
    this.previews.push({ id, label, settings });
    this.app.like.update();
    await this.showPreviews();
  }

  /** Lists the previews that the program still has, and shows the last two side by side. */
  async showPreviews() {
    const { model, display, viewer } = this.app, box = find("#previews");
    this.previews = this.previews.filter((p) => model.find(p.id));
    box.hidden = !this.previews.length;
    box.replaceChildren(...this.previews.map((p, i) => this.previewRow(p, i)));
    if (!this.previews.length) return;
    const [a, b] = this.previews.slice(-2), n = this.previews.length;
    if (b) await display.states(b.id, a.id, [tr("preview_number", { number: n - 1 }), tr("preview_number", { number: n })]);
    else await display.states(a.id, model.state.current, [tr("now"), tr("preview_number", { number: 1 })]);
    if (viewer.options.show !== "slider") display.option("show", viewer.canvas.clientWidth < 600 ? "after" : "both");
    this.app.say(tr(b ? "two_previews" : "one_preview"));
  }

  previewRow({ id, label, settings }, i) {
    const row = document.createElement("div"), text = document.createElement("code");
    const button = (words, act) => {
      const made = newButton(words, () => this.app.attempt("#message", act));
      made.setAttribute("aria-label", `${words}: ${tr("preview_number", { number: i + 1 })}`);
      return made;
    };
    text.textContent = `${i + 1}: ${label}`;
    const drop = async () => {
      await askJson("discard", { id });
      this.previews = this.previews.filter((p) => p.id !== id);
      await this.app.refresh();
    };
    const take = async () => {
      await this.app.choices.flush();
      await askJson("adopt", { id });
      for (const other of this.previews) if (other.id !== id) await askJson("discard", { id: other.id }).catch(() => null);
      this.previews = [];
      // The page shows what the step was made with, not what a later preview was made with.
      if (settings) this.presets.restore(settings);
      await this.app.refresh();
      // The previews are no longer compared.
      if (this.app.viewer.options.show === "both") this.app.display.option("show", "after");
      this.app.say(tr("done"));
    };
    row.append(text, button(tr("take"), take), button(tr("drop"), drop), this.report(id));
    return row;
  }

  /** Lists the history. */
  list() {
    const { state } = this.app.model, line = state.states.filter((s) => !s.preview);
    const focused = all("#history button").indexOf(document.activeElement);
    find("#history").replaceChildren(...line.map((s) => this.historyRow(s, s.id === state.current)));
    all("#history button")[focused]?.focus();
    const select = find("#against"), had = Number(select.value);
    select.replaceChildren(...line.filter((s) => s.id !== state.current).map((s) => new Option(this.labelOf(s), s.id)));
    select.disabled = !select.options.length;
    const parent = this.app.model.current.parent, wanted = line.some((s) => s.id === had) && this.against ? had : parent;
    if (wanted !== null && wanted !== undefined) select.value = wanted;
  }

  /** The name of a state in the history: its number and its command. */
  labelOf(s) {
    if (s.parent === null || s.parent === undefined) return tr("as_read");
    const kind = s.command[0], number = this.app.model.state.states.filter((other) => !other.preview).findIndex((other) => other.id === s.id);
    return `${number > 0 ? number + ". " : ""}${has("kind_" + kind) ? tr("kind_" + kind) : kind}`;
  }

  historyRow(s, isCurrent) {
    const item = document.createElement("li"), button = document.createElement("button"), small = document.createElement("small");
    button.type = "button";
    button.textContent = this.labelOf(s);
    if (isCurrent) button.setAttribute("aria-current", "step");
    button.addEventListener("click", () => this.app.attempt("#history-trouble", async () => {
      await this.app.choices.flush();
      if (!isCurrent) await askJson("goto", { id: s.id });
      await this.app.refresh();
    }));
    small.textContent = small.title = [counts("face", s.faces), s.seconds ? `${digits(Number(s.seconds.toPrecision(2)))} s` : "", s.report ? stepLine(s.report) : ""].filter(Boolean).join(" · ");
    button.title = s.command.length ? ["isomend", ...s.command].join(" ") : s.label;
    item.append(button, s.parent === null ? "" : this.report(s.id), small);
    return item;
  }

  /** A link to the report of a step, which opens in a new tab. */
  report(id) {
    return Object.assign(document.createElement("a"), { href: `api/report/${id}`, target: "_blank", rel: "noopener", hreflang: "en", textContent: tr("report"), title: tr("report_title") });
  }

  /** Shows another state for comparison. */
  async compare(id) {
    this.against = true;
    const { model, display } = this.app;
    await this.app.attempt("#history-trouble", () => display.states(model.state.current, id, [model.find(id), model.current].map((s) => this.labelOf(s))));
  }
}
