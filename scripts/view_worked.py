"""Tests of the layout of the page of `isomend view` with work on it, in Chromium: each of the four starts before and after its command has run,
at three sizes, light and dark, in both languages. For view_test.py; with --keep it makes the pictures to look at."""

import shutil

from browser_test import PICTURE, ROOT
from view_layout import SIZES, check_contrast, check_place, dark, resize
from view_page import Server
from view_tasks import DENT, begin

# Combinations of size and theme for each language: all sizes, themes and languages, and both languages in the smallest window.
LOOKS = {"en": ((SIZES[0], False), (SIZES[2], True)), "de": ((SIZES[1], True), (SIZES[2], False))}


def language(page, name):
    """Changes the language, and waits for the page in it."""
    if page.run("document.documentElement.lang") != name:
        page.fill_in("#language", name)
        page.until(f"document.documentElement?.dataset.state === 'ready' && document.documentElement.lang === '{name}' && !!isomend.mask()", f"the page is in {name}")


def looked_at(page, name):
    """Tests and pictures of the page as it is now: first in the language that it has, since another one loads the page anew."""
    for tongue in sorted(LOOKS, key=lambda tongue: tongue != page.run("document.documentElement.lang")):
        language(page, tongue)
        for (width, height), is_dark in LOOKS[tongue]:
            resize(page, width, height)
            dark(page, is_dark)
            page.calm(PICTURE)
            if page.keep:
                page.until("isomend.labels.settled", "the numbers are placed")
            where = f"{width}_{'dark' if is_dark else 'light'}_{tongue}"
            check_place(page, f"{name}, {where}", width, height)
            check_contrast(page, f"{name}, {where}")
            page.shot(f"{name}_{where}")
    dark(page, False)
    resize(page, *SIZES[0])


def filled(page):
    """All holes but one are filled; then one that is open is chosen, with its card beside it."""
    page.until("!!isomend.mask()", "the surface is prepared")
    page.run("isomend.holes.choose(isomend.holes.list[0].id)")
    page.settled()
    looked_at(page, "fill_before")
    page.key("k")
    page.click_on("#fill-all")
    page.until_done()
    page.reaches(1, "the holes are filled")
    looked_at(page, "fill")
    page.click_on("#outcome > summary")
    page.fill_in("#colour", "sigma")
    page.until("isomend.display.coloured === 'sigma'", "expected errors are shown")
    looked_at(page, "fill_list")


def repaired(page):
    """The mesh is made printable, and checked: its defects, walls, overhangs, components."""
    page.fill_in("#colour", "plain")
    page.tab("print")
    looked_at(page, "print_before")
    page.click_on("#run")
    page.until_done()
    page.reaches(2, "the mesh is repaired")
    looked_at(page, "print")
    page.tab("check")
    for aspect in ("defects", "walls", "overhangs", "components"):
        page.click_on(f"[name=aspect][value={aspect}] + span")
        page.calm(PICTURE)
        looked_at(page, f"check_{aspect}")


def restored(page):
    """A dent is marked and restored."""
    page.tab("paint")
    page.run(f"isomend.masks.take({page.run(DENT)})")
    looked_at(page, "restore_before")
    page.click_on("#run")
    page.until_done()
    page.reaches(1, "the dent is restored")
    page.click_on("[name=show][value=slider] + span")
    looked_at(page, "restore")


def on(page, program, folder, name, *works):
    """Runs works on a mesh of the folder `data`."""
    mesh = folder / name
    shutil.copy(ROOT / "data" / name, mesh)
    server = Server(program, mesh, folder.parent / f"log_{mesh.stem}.txt")
    try:
        begin(page, server)
        for work in works:
            work(page)
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def worked(page, program, folder):
    """All starts."""
    on(page, program, folder, "scan.ply", filled, repaired)
    on(page, program, folder, "painted.ply", restored)
