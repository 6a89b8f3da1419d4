"""Tests of the layout of the page of `isomend view`, in Chromium: what must fit, not overlap, not move, be readable. For view_tasks.py."""

import json

from browser_test import PICTURE

SIZES = ((1280, 800), (1920, 1080), (1024, 700))
TABS = ("holes", "paint", "print", "check", "measure", "history", "save")
# The visible controls, with their boxes.
SEEN = """(() => { const seen = (e) => e.checkVisibility({ visibilityProperty: true }) && e.getBoundingClientRect().width > 2;
  return [...document.querySelectorAll("header button, header select, #rail :is(button, select, label), #panel :is(button, select, summary, output), .compare label")]
    .filter((e) => seen(e) && !e.closest("ol, #masks, #summary, #mender > details, .pane details, .hidden, #fields, label label, #presets, #gizmo")).map((e) => { const b = e.getBoundingClientRect();
      return [e.id || e.dataset.words || e.textContent.trim(), b.left, b.top, b.right, b.bottom, !!e.closest("label") && e.tagName !== "LABEL"]; }); })()"""
# Elements other than lists whose content does not fit, so that they scroll.
SCROLLS = """[...document.querySelectorAll("html, body, #rail, #panel, [role=tabpanel]")].filter((e) => e.checkVisibility() && !e.querySelector("details[open]") &&
  (e.scrollHeight > e.clientHeight + 1 || e.scrollWidth > e.clientWidth + 1)).map((e) => [e.id || e.tagName, e.scrollWidth, e.clientWidth, e.scrollHeight, e.clientHeight])"""
# Controls whose words do not fit.
CUT = """[...document.querySelectorAll("header button, #panel :is(button, label, select, summary, dd)")].filter((e) => {
  if (!e.checkVisibility({ visibilityProperty: true }) || e.closest(".hidden, #history, #recipe, .files, #presets input")) return false;
  if (e.tagName !== "SELECT") return e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).textOverflow !== "ellipsis" && getComputedStyle(e).display !== "inline";
  const style = getComputedStyle(e), pen = document.createElement("canvas").getContext("2d");
  pen.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
  // The arrow takes about 16 pixels.
  return pen.measureText(e.selectedOptions[0]?.text ?? "").width + 16 > e.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight) + 4;
  }).map((e) => [e.id || e.className || e.tagName, (e.selectedOptions?.[0]?.text ?? e.textContent).trim().slice(0, 30)])"""
# Texts with less contrast to their background than WCAG's level AA requires.
FAINT = """(() => {
  const parse = (text) => { const c = document.createElement("canvas").getContext("2d", { willReadFrequently: true }); c.clearRect(0, 0, 1, 1); c.fillStyle = text; c.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = c.getImageData(0, 0, 1, 1).data; return [r, g, b, a / 255]; };
  const light = ([r, g, b]) => { const f = (x) => (x /= 255) <= .03928 ? x / 12.92 : ((x + .055) / 1.055) ** 2.4; return .2126 * f(r) + .7152 * f(g) + .0722 * f(b); };
  const behind = (e) => { let back = null; const over = []; for (; e && !back; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor);
      if (c[3] > .99) back = c; else if (c[3] > 0) over.push(c); }
    back ||= [255, 255, 255, 1]; for (const c of over.reverse()) back = back.map((x, k) => k < 3 ? c[k] * c[3] + x * (1 - c[3]) : 1); return back; };
  const wrong = [];
  for (const e of document.querySelectorAll("header *, #rail *, #panel *, .compare *, .foot *")) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!own || !e.checkVisibility({ visibilityProperty: true, opacityProperty: true }) || e.closest(":disabled, .hidden, option, fieldset[disabled]") || e.matches("label:has(:disabled) *")) continue;
    const style = getComputedStyle(e), a = light(parse(style.color)), b = light(behind(e)), ratio = (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
    const large = parseFloat(style.fontSize) >= 24 || parseFloat(style.fontSize) >= 18.66 && style.fontWeight >= 700;
    if (ratio < (large ? 3 : 4.5)) wrong.push([e.textContent.trim().slice(0, 30), ratio.toFixed(2)]); }
  return wrong; })()"""
# Positions of the elements that must not move.
STAND = """(() => [...document.querySelectorAll("#view, #rail button, #fill-all, header button, [role=tab]")].map((e) => {
  const b = e.getBoundingClientRect(); return [e.id || e.textContent.trim(), Math.round(b.x), Math.round(b.y)]; }))()"""


def resize(page, width, height):
    page.size(width, height)
    # The picture has the new size once the page has seen its own.
    page.until(f"innerWidth === {width} && innerHeight === {height} && (({{ canvas: c }}) => c.width === Math.round(c.clientWidth * {page.scale}) && c.height === Math.round(c.clientHeight * {page.scale}))(isomend.viewer)",
               f"the window has {width} x {height} pixels")
    page.calm(PICTURE)


def dark(page, is_dark):
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if is_dark else "light"}])
    page.until(f"!document.documentElement.dataset.theme || document.documentElement.dataset.theme === '{'dark' if is_dark else 'light'}'", "the theme follows the system")


def overlapping(boxes):
    """Pairs of controls that overlap by more than a pixel, without pairs of a control and its own label."""
    wrong = []
    for i, (name, left, top, right, bottom, inner) in enumerate(boxes):
        for other, x0, y0, x1, y1, within in boxes[i + 1:]:
            if inner or within:
                continue
            if min(right, x1) - max(left, x0) > 1 and min(bottom, y1) - max(top, y0) > 1:
                wrong.append((name, other))
    return wrong


def check_place(page, where, width, height):
    """In the window as it is now: only lists scroll, nothing overlaps, all is in the window and readable."""
    boxes = page.run(SEEN)
    page.expect(not (found := page.run(SCROLLS)), f"{where}: scrolls: {found}")
    page.expect(not (found := overlapping(boxes)), f"{where}: over each other: {found[:4]}")
    out = [b[0] for b in boxes if b[1] < -1 or b[2] < -1 or b[3] > width + 1 or b[4] > height + 1]
    page.expect(not out, f"{where}: outside of the window: {out}")
    page.expect(not (found := page.run(CUT)), f"{where}: cut: {found[:5]}")


def check_contrast(page, where):
    """All words are readable against their background, in the theme as it is now."""
    page.expect(not (found := page.run(FAINT)), f"{where}: too faint: {found[:5]}")


def check_layout(page, tabs=TABS, themes=(False, True)):
    """At three sizes with each tab open: only lists scroll, nothing overlaps, all is in the window. At one size, light and dark: all is
    readable; a theme changes nothing but colours, and a size no colours."""
    for width, height in SIZES[::-1]:
        resize(page, width, height)
        for tab in tabs:
            page.tab(tab)
            check_place(page, f"{width} x {height}, tab {tab}", width, height)
            page.shot(f"{width}_{tab}")
        view = page.view()
        page.expect(view[3] > height - 60, f"the view is {view[3]} high of {height}")
    for is_dark in themes:
        dark(page, is_dark)
        for tab in tabs:
            page.tab(tab)
            check_contrast(page, f"{'dark' if is_dark else 'light'}, tab {tab}")
            page.shot(f"{'dark' if is_dark else 'light'}_{tab}")
    dark(page, False)


def check_rows(page):
    """Holes are rows of one line, can be sorted by any column and chosen several at a time; a row and its rim highlight each other."""
    page.tab("holes")
    heights = page.run("[...new Set([...document.querySelectorAll('#holes li')].map((e) => Math.round(e.getBoundingClientRect().height)))]")
    page.expect(len(heights) == 1 and heights[0] < 34, f"rows are {heights} high")
    for column in ("edges", "diameter", "id"):
        for _ in range(2):
            page.click_on(f"[data-sort={column}]")
            values = page.run(f"isomend.holes.listed().map((h) => h.{column})")
            falls = page.run("isomend.holes.sort.falls")
            page.expect(values == sorted(values, reverse=falls), f"sorted by {column} the list is {values[:5]}")
    page.click_on("[data-sort=id]")
    page.expect(not page.run("isomend.holes.sort.falls"), "the list does not rise again")

    def row(number):
        return page.run(f"(() => {{ const b = document.querySelector('#holes li:nth-child({number}) .hole').getBoundingClientRect(); return [b.x + 20, b.y + b.height / 2]; }})()")

    stand = page.run(STAND)
    page.click(*row(2))
    page.settled()
    page.expect(page.run(STAND) == stand, "choosing a hole moves something")
    page.click(*row(4), modifiers=8)
    page.click(*row(7), modifiers=2)
    picked = page.run("[...isomend.holes.picked]")
    listed = page.run("isomend.holes.listed().map((h) => h.id)")
    page.expect(sorted(picked) == sorted([*listed[1:4], listed[6]]), f"Shift and Ctrl choose {picked}")
    page.key("k")
    page.expect(page.run("[...isomend.holes.picked].every((id) => isomend.holes.doings.get(id) === 'open')"), "what is done is set for one hole only")
    page.key("i")
    page.expect("4" in page.run("document.querySelector('#fill-chosen').textContent"), "the button does not count the holes")
    x, y = row(1)
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    page.until("document.querySelector('#over').getAttribute('points').length > 20 || isomend.holes.over", "the rim of a row is lit")
    page.run("isomend.viewer.fly(isomend.home())")
    page.settled()
    page.until("isomend.labels.settled", "the numbers are placed")
    seen = page.run("""(() => { const label = document.querySelector('#labels .label:not([hidden])'), b = label.getBoundingClientRect();
        return [Number(label.textContent), b.x + b.width / 2, b.y + b.height / 2]; })()""")
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=seen[1], y=seen[2])
    page.until("!!document.querySelector('#holes li.over') || isomend.holes.over", "the row of a rim is lit")
    return stand


def check_keyboard(page):
    """The list of holes is a single tab stop; holes are chosen, set and filled with keys only."""
    page.tab("holes")
    page.run("document.querySelector('[data-sort=doing]').focus()")
    stops = []
    for _ in range(12):
        page.key("Tab")
        stops.append(page.run("document.activeElement.closest('#holes') ? 'list' : document.activeElement.id || document.activeElement.dataset.sort"))
        if stops[-1] == "fill-all":
            break
    page.expect(stops.count("list") == 1, f"the focus goes to {stops}")
    page.run("document.querySelector('#holes .hole[tabindex=\"0\"]').focus()")
    before = page.run("isomend.holes.chosen")
    page.key("ArrowDown")
    after = page.run("isomend.holes.chosen")
    page.expect(after != before and page.run("Number(document.activeElement.dataset.hole)") == after, "arrows do not go through the list")
    page.key("k")
    page.expect(page.run(f"isomend.holes.doings.get({json.dumps(after)})") == "open", "K does not keep the hole open")
    page.key("i")
    page.key("ArrowRight")
    page.expect(page.run("document.activeElement.tagName") == "SELECT", "the right arrow does not go to what is done")
    page.key("Escape")
    page.key("?")
    page.expect(page.run("document.querySelector('#keys').open && document.querySelectorAll('#keys dt').length > 15"), "? shows no help")
    page.shot("help")
    page.key("Escape")
    page.until("!document.querySelector('#keys').open", "Escape closes the help")
