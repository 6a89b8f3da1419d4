// Texts of the group "Patches and unit" in English and German, in the form of strings.js.

/** Each text by its name: English, then German. Names in braces are placeholders. */
export const DELIVER_WORDS = {
  hand_over: ["Patches of the last step, and unit", "Flicken des letzten Schritts, Einheit"],
  tolerance: ["tolerance", "Toleranz"],
  tolerance_title: ["The largest error allowed: holes whose patches may err by more are listed", "Der größte erlaubte Fehler: Löcher, deren Flicken stärker abweichen können, werden genannt"],
  tolerance_positive: ["the tolerance must be a positive number", "die Toleranz muss eine positive Zahl sein"],
  mark: ["mark patches", "Flicken kennzeichnen"],
  mark_none: ["not", "nicht"],
  mark_colour: ["colour", "Farbe"],
  mark_hatch: ["hatching", "Schraffur"],
  mark_colour_of: ["Colour of the patches", "Farbe der Flicken"],
  paint_patches: ["paint patches", "Flicken bemalen"],
  paint_none: ["not", "nicht"],
  paint_continue: ["as beside them", "wie daneben"],
  paint_title: ["The paint of a slicer (colours, supports, seams, fuzzy skin) on the patches of the last step, in a 3MF file: --paint", "Die Bemalung aus dem Slicer (Farben, Stützen, Nähte, raue Haut) auf den Flicken des letzten Schritts, in einer 3MF-Datei: --paint"],
  patches_file: ["patches as a file of their own", "Flicken als eigene Datei"],
  piece_file: ["the missing piece", "das fehlende Stück"],
  piece_title: ["The solid between the marked faces that were cut out and the patch, to print; after a restoration", "Der Körper zwischen den herausgeschnittenen Flächen und dem Flicken, zum Drucken; nach einer Erneuerung"],
  no_patches_yet: ["Fill, restore or repair first: the last step has no patches.", "Zuerst füllen, erneuern oder reparieren: der letzte Schritt hat keine Flicken."],
  invented: ["New surface of the last step: {area}, {percent} % of the surface.", "Ergänzt im letzten Schritt: {area}, {percent} % der Oberfläche."],
  invented_none: ["The last step has no patches.", "Der letzte Schritt hat keine Flicken."],
  expected: ["Expected error: {mean} on average, {largest} at most.", "Erwarteter Fehler: im Mittel {mean}, höchstens {largest}."],
  expected_in_part: [
    "Expected error: {mean} on average, {largest} at most, not known on {part} % of the new surface.",
    "Erwarteter Fehler: im Mittel {mean}, höchstens {largest}, auf {part} % der neuen Fläche nicht bekannt.",
  ],
  expected_unknown: ["Its expected error is unknown.", "Der erwartete Fehler ist unbekannt."],
  within: ["Twice the expected error is within {tolerance} on {part} % of it.", "Auf {part} % davon liegt der doppelte erwartete Fehler unter {tolerance}."],
  beyond_patches: ["Not within the tolerance: patches {patches}.", "Nicht in der Toleranz: Flicken {patches}."],
  beyond: ["Not within the tolerance: patches of holes {holes}.", "Nicht in der Toleranz: Flicken der Löcher {holes}."],
  no_piece: ["No piece can be made: {reason}.", "Ein Stück lässt sich nicht machen: {reason}."],
};
