"""The operators: fill holes, restore and fair selected faces, repair. Called from the panel they work in a thread, with progress, and
Escape cancels them; called by a script they return when the work is done."""

import time

import bpy

from . import settings
from .given_back import NotGivenBack, give_back
from .refusals import reason_against
from .taken import Taken
from .work import Work

# Seconds between two looks at a run.
PAUSE = 0.1

# Events that move the view, which is possible during a run.
OF_VIEW = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSEMOVE"}


class NothingToDo(Exception):
    """No hole or face was chosen; the message says what to select."""


class Mending:
    """What the operators have in common."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        item = context.active_object
        return item is not None and item.type == "MESH" and item.mode in ("OBJECT", "EDIT")

    def length(self, taken, value):
        """A length in the units of the arrays; 0 means that none was given."""
        return value / taken.scale if value > 0 else None

    def solving(self, taken):
        """Options of all that fills holes."""
        return {"energy": self.energy, "sharp": self.sharp, "voxel": self.length(taken, self.voxel) or "auto"}

    def begun(self, context):
        """The mesh and the work on it; none where the object is refused."""
        reason = reason_against(context.active_object)
        if reason:
            self.report({"ERROR"}, reason)
            return None
        try:
            taken = Taken(context.active_object)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return None
        return taken, Work(self.work(taken))

    def ended(self, context, item, taken, result):
        """Puts what came of the work in place: `result` returns it, or raises what went wrong."""
        import isomend

        try:
            mended = result()
            mode = item.mode
            if mode == "EDIT":
                bpy.ops.object.mode_set(mode="OBJECT")
            try:
                if not taken.is_same(item):
                    self.report({"ERROR"}, "The mesh was changed meanwhile; nothing was done")
                    return {"CANCELLED"}
                vertices, faces = give_back(item, taken, mended)
            finally:
                if mode == "EDIT":
                    bpy.ops.object.mode_set(mode="EDIT")
        except isomend.Cancelled:
            self.report({"WARNING"}, "Cancelled; nothing was changed")
            return {"CANCELLED"}
        except (isomend.IsomendError, NothingToDo, NotGivenBack) as error:
            self.report({"ERROR"}, sentence(str(error)))
            return {"CANCELLED"}
        context.scene.isomend.holes.clear()
        self.report({"INFO" if mended.complete else "WARNING"}, summary(mended, taken, context, vertices, faces))
        return {"FINISHED"}

    def execute(self, context):
        """Does the work at once; a script waits for it."""
        begun = self.begun(context)
        if begun is None:
            return {"CANCELLED"}
        taken, work = begun
        manager = context.window_manager
        manager.progress_begin(0, 100)
        try:
            return self.ended(context, context.active_object, taken, lambda: work.run(lambda p: manager.progress_update(100 * p)))
        finally:
            manager.progress_end()

    def invoke(self, context, event):
        """Begins the work in a thread."""
        begun = self.begun(context)
        if begun is None:
            return {"CANCELLED"}
        self._taken, work = begun
        self._item = context.active_object
        self._work = work.start()
        self._since = time.monotonic()
        self._timer = context.window_manager.event_timer_add(PAUSE, window=context.window)
        context.window_manager.modal_handler_add(self)
        self.tell(context, 0, work.text())
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Shows how far the work is, and ends with it. Only the view can be used meanwhile."""
        if event.type == "ESC" and event.value == "PRESS":
            self._work.cancel()
            self.tell(context, self._work.part, "isomend: being cancelled")
        if event.type in OF_VIEW:
            return {"PASS_THROUGH"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        if self._work.is_running():
            self.tell(context, self._work.part, f"{self._work.text()} (Esc cancels)")
            return {"RUNNING_MODAL"}
        self.over(context)
        return self.ended(context, self._item, self._taken, self._work.result)

    def cancel(self, context):
        """Blender ends a run, such as when another file is opened."""
        self._work.cancel()
        self.over(context)

    def over(self, context):
        """Takes the timer and the progress away."""
        context.window_manager.event_timer_remove(self._timer)
        self.tell(context, -1, None)

    def tell(self, context, part, text):
        """Shows progress in the panel and in the status bar."""
        shown = context.scene.isomend
        shown.progress, shown.progress_text = part, text or ""
        if context.workspace is not None:
            context.workspace.status_text_set(text)
        if context.screen is not None:
            for area in context.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()


class ISOMEND_OT_fill(Mending, bpy.types.Operator):
    """Fill holes by surfaces that continue the curvature of their surroundings. The mesh itself stays as it is"""

    bl_idname = "isomend.fill"
    bl_label = "Fill holes"
    __annotations__ = {**settings.of_fill(), **settings.common()}

    def work(self, taken):
        options = self.solving(taken)
        widest = self.length(taken, self.max_diameter)
        chosen_alone, flat = self.scope == "SELECTED", self.flat

        def fill(progress):
            found = taken.model().inspect()
            chosen = taken.chosen_holes(found.holes) if chosen_alone else [hole.id for hole in found.holes if not hole.is_border]
            fits = [hole.id for hole in found.holes if hole.id in chosen and not (widest and hole.diameter > widest)]
            if not fits:
                raise NothingToDo(reason_for_none(found.holes, chosen_alone, len(chosen)))
            caps = fits if flat else ()
            return found.fill(
                holes=fits if chosen_alone else None, max_diameter=widest, flat=caps, progress=progress, **options
            )  # fmt: skip

        return fill


def reason_for_none(holes, chosen_alone, chosen):
    """Why there is no hole to fill."""
    if not holes:
        return "the mesh has no holes"
    if chosen:
        return "all holes that were chosen are wider than the largest diameter"
    if chosen_alone:
        return "no hole is selected; select an edge of its rim, or choose all holes"
    return "the mesh has only outer borders of open sheets; select an edge of one to fill it"


class ISOMEND_OT_restore(Mending, bpy.types.Operator):
    """Cut the selected faces out and fill the region so that it continues its surroundings"""

    bl_idname = "isomend.restore"
    bl_label = "Restore selected faces"
    __annotations__ = {**settings.of_restore(), **settings.common()}

    def work(self, taken):
        options = self.solving(taken) | {"keep_shape": self.keep_shape}
        return on_faces(taken, lambda marks, progress: taken.model().restore(marks, keep_vertices=True, progress=progress, **options))


class ISOMEND_OT_fair(Mending, bpy.types.Operator):
    """Smooth the selected faces by Willmore flow: noise and small features go, large forms stay"""

    bl_idname = "isomend.fair"
    bl_label = "Fair selected faces"
    __annotations__ = settings.of_fair()

    def work(self, taken):
        strength = self.length(taken, self.strength)
        return on_faces(
            taken, lambda marks, progress: taken.model().fair(marks, strength=strength, keep_vertices=True, progress=progress)
        )


class ISOMEND_OT_repair(Mending, bpy.types.Operator):
    """Make the mesh closed, manifold, oriented and free of self-intersections, as far as that is possible"""

    bl_idname = "isomend.repair"
    bl_label = "Repair"
    __annotations__ = {**settings.of_repair(), **settings.common()}

    def work(self, taken):
        options = self.solving(taken)
        options |= {"close_borders": self.close_borders, "keep_holes": self.keep_holes}
        options |= {"weld": self.length(taken, self.weld), "debris": self.debris or None}
        return lambda progress: taken.model().repair(progress=progress, **options)


def on_faces(taken, mend):
    """Work on the selected faces."""
    marks = taken.marks()

    def work(progress):
        if not marks.any():
            raise NothingToDo("no face is selected")
        return mend(marks, progress)

    return work


def sentence(text):
    """A message that begins with a capital letter."""
    return text[:1].upper() + text[1:]


def summary(mended, taken, context, vertices, faces):
    """What was done, in a line: lengths in the units of the scene."""
    report = mended.report
    parts = [f"{faces} new faces, {vertices} new vertices"]
    holes = [hole for hole in report.get("holes", []) if hole.get("outcome") not in (None, "left")]
    failed = [hole for hole in holes if hole["outcome"] == "failed"]
    if holes:
        parts.insert(0, f"{len(holes) - len(failed)} of {len(holes)} holes closed")
    errors = mended.sigma[mended.sigma > 0]
    if len(errors):
        parts.append(f"expected error at most {shown_length(context, float(errors.max()) * taken.scale)}")
    if failed:
        parts.append(f"hole {failed[0]['id']}: {failed[0]['reason']}")
    after = report.get("after")
    if after:
        parts.append("nothing is wrong any more" if after["sound"] else "; ".join(after["reasons"]))
    return "; ".join(parts)


# For each system of units: names of units, with their lengths in metres, the largest first.
UNITS = {
    "METRIC": (("m", 1), ("mm", 1e-3), ("µm", 1e-6)),
    "IMPERIAL": (("ft", 0.3048), ("in", 0.0254), ("thou", 2.54e-5)),
}


def shown_length(context, length):
    """A length in words, in the units of the scene."""
    units = context.scene.unit_settings
    if units.system not in UNITS:
        return f"{length:.2g}"
    metres = length * units.scale_length
    all_units = UNITS[units.system]
    name, size = next((unit for unit in all_units if metres >= unit[1]), all_units[-1])
    return f"{metres / size:.3g} {name}"


CLASSES = (ISOMEND_OT_fill, ISOMEND_OT_restore, ISOMEND_OT_fair, ISOMEND_OT_repair)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
