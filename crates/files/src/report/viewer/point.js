// The point under a click: its coordinates, and a ball around it for a mask.

import { localised, numberIn } from "./controls.js";

/** A coordinate with the precision of the page's data: about a millionth of the mesh's size. */
function coordinate(x, radius) {
  const decimals = Math.ceil(-Math.log10(2e-6 * radius));
  return String(Number(decimals >= 0 && decimals <= 15 ? x.toFixed(decimals) : x.toPrecision(7)) + 0);
}

/** Copies text to the clipboard; by a text element if the browser forbids the clipboard for files. */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch { /* Not allowed here. */ }
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  return done;
}

/** Default messages on copying; `TEXT` stands for the copied text. */
const POINT_WORDS = { wrong: "the radius must be a positive number", copied: "copied: TEXT", byHand: "copy it by hand: TEXT" };

export class Point {
  constructor(header, pin, words = POINT_WORDS) {
    this.words = words;
    this.header = header;
    this.pin = pin;
    this.at = null;
    this.radius = document.querySelector("#ball-radius");
    this.radius.value = localised(Number((header.radius / 10).toPrecision(3)));
    document.querySelector("#copy-point").addEventListener("click", () => this.take(false));
    document.querySelector("#copy-ball").addEventListener("click", () => this.take(true));
  }

  /** Shows the coordinates of a point; with `ball` also copies a ball around it. */
  choose(point, ball) {
    this.at = point.map((x, i) => coordinate(x + this.header.origin[i], this.header.radius)).join(",");
    document.querySelector("#point-at").textContent = this.at;
    for (const button of document.querySelectorAll("#point button")) button.disabled = false;
    this.pin(point);
    document.querySelector("#copied").textContent = "";
    return ball ? this.take(true) : undefined;
  }

  async take(ball) {
    const radius = numberIn(this.radius.value), said = document.querySelector("#copied");
    if (ball && !(radius > 0 && isFinite(radius))) {
      said.textContent = this.words.wrong;
      this.radius.focus();
      return;
    }
    const text = ball ? `--ball ${this.at},${radius}` : this.at;
    const done = await copy(text);
    this.copied = text;
    said.textContent = (done ? this.words.copied : this.words.byHand).replace("TEXT", () => text);
  }
}
