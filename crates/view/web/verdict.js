// The verdict on a mesh: one for the result of a step and for the check, by the same minimum wall, in words of the page.

import { begun } from "../../report/viewer/activity.js";
import { digits, find, numberIn } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { counts, tr, whole } from "./strings.js";

/** Walls thinner than this fraction of the extent of the mesh are named even if no minimum wall is set. */
const THIN = 1 / 500;
/** Time without typing after which a minimum wall is used for a check, in milliseconds. */
const PAUSE = 300;
/** The field of the minimum wall in the form of a repair. */
const FORM_WALL = '[id="repair--min-wall"]';
/** The levels of a verdict, from the best. */
const LEVELS = ["good", "fair", "bad"];

/** The worse one of two levels. */
export const worse = (a, b) => LEVELS[Math.max(LEVELS.indexOf(a), LEVELS.indexOf(b))];

export class Verdict {
  constructor(app) {
    this.app = app;
    this.found = new Map();
    find("#min-wall").addEventListener("input", () => this.typed());
  }

  /** Makes the fields for the minimum wall of a repair and of the check show the same value. */
  start() {
    const own = find("#min-wall"), other = find(FORM_WALL);
    other.addEventListener("input", () => {
      own.value = other.value;
      this.typed();
    });
    own.addEventListener("input", () => {
      this.share();
      this.app.steps.describe();
    });
  }

  /** Copies the minimum wall of the check into the form of a repair: the check's holds whatever preset is taken. */
  share() {
    find(FORM_WALL).value = find("#min-wall").value;
  }

  /** The minimum wall in mesh units, or null. */
  wall() {
    const text = find("#min-wall").value.trim(), value = numberIn(text), right = !text || value > 0 && Number.isFinite(value);
    find("#min-wall").setAttribute("aria-invalid", !right);
    return text && right ? value : null;
  }

  /** Checks again when no digit of the minimum wall has been typed for a time. */
  typed() {
    this.wall();
    clearTimeout(this.timer);
    this.end ??= begun("request");
    this.timer = setTimeout(() => {
      this.changed();
      this.end();
      this.end = null;
    }, PAUSE);
  }

  changed() {
    this.app.defects.renew();
    this.app.result.update();
  }

  /** The check of a mesh of the session, by the present minimum wall. */
  async of(id) {
    const wall = this.wall(), key = `check/${id}${wall ? `?min_wall=${wall}` : ""}`;
    if (!this.found.has(key)) {
      const found = askJson(key);
      found.catch(() => this.found.delete(key));
      this.found.set(key, found);
      for (const old of [...this.found.keys()].slice(0, -4)) this.found.delete(old);
    }
    return this.found.get(key);
  }

  /** A length with its unit. */
  length(x) {
    return digits(x) + this.app.unit();
  }

  /** The thinnest wall and what it is, for a list of numbers; `none` where no wall is known. */
  wallNumber(walls, none = "–") {
    return [walls ? this.length(walls.least) : none, tr(walls?.sampled ? "number_wall_sampled" : "number_wall")];
  }

  /** An expected error with its unit: two significant digits, as in the terminal. */
  error(x) {
    return this.length(Number(x.toPrecision(2)));
  }

  /** A defect with its number; thin walls with the minimum. */
  nameOf(kind, count) {
    const wall = kind === "thin_wall" && this.wall();
    return wall ? tr("thinner_walls", { wall: this.length(wall), faces: counts("face", count) }) : `${tr("kind_" + kind)}: ${whole(count)}`;
  }

  /** The level of a check, and its line: `bad` only if there are defects; a mesh without any whose shape a repair has changed, or to which
   * a repair has given thin walls, is `fair`. */
  judged({ sound, holes, defects = [], debris, walls, doubt }) {
    const reasons = [];
    if (holes) reasons.push(tr("open_holes", { holes: counts("hole", holes) }));
    for (const { kind, count } of defects) if (count && !(kind === "boundary_edge" && holes)) reasons.push(this.nameOf(kind, count));
    if (doubt) reasons.push(tr("doubtful"));
    const wrong = defects.filter(({ kind }) => kind !== "thin_wall" || this.wall());
    if (!sound && !wrong.length && (doubt || defects.length)) return { level: "fair", line: tr("doubtful_shape") };
    if (!sound) return { level: "bad", line: tr("not_sound", { reasons: reasons.join(", ") || "–" }) };
    const thin = walls && !this.wall() && walls.least < THIN * 2 * this.app.model.state.scene.radius, mild = [];
    if (thin) mild.push(tr("thin_somewhere", { least: this.length(walls.least) }));
    if (debris) mild.push(counts("debris", debris));
    if (mild.length) return { level: "fair", line: tr("sound_but", { what: mild.join(", ") }) };
    return { level: "good", line: tr("sound") };
  }
}

/** Fills a list of numbers: pairs of a value and its name. */
export function putNumbers(list, pairs) {
  list.replaceChildren(...pairs.map(([value, name]) => {
    const row = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd");
    dt.textContent = name;
    dd.append(value);
    row.append(dt, dd);
    return row;
  }));
}
