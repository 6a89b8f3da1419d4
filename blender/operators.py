"""The operators that mend the active mesh: fill holes, restore and fair selected faces, repair."""

import bpy

from . import settings
from .given_back import NotGivenBack, give_back
from .modes import object_mode
from .running import Running
from .taken import digest_of


class NothingToDo(Exception):
    """There is no hole to fill, or no face is selected; the message says what to select."""


class Mending(Running):
    """Base class of the operators that mend a mesh."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.active_object.mode in ("OBJECT", "EDIT")

    def solving(self, taken):
        """Options of the operators that fill holes."""
        return {
            "energy": self.energy, "sharp": self.sharp, "voxel": taken.length(self.voxel) or "auto", "like": taken.like(self.mirror)
        }  # fmt: skip

    def finish(self, context, item, taken, result):
        """Writes the result into the mesh, and reports to the user. `result()` returns the result, or raises the work's exception."""
        import isomend

        try:
            mended = result()
            with object_mode():
                if digest_of(item.data) != taken.digest:
                    self.report({"ERROR"}, "The mesh was changed during the run; the result was discarded")
                    return {"CANCELLED"}
                vertices, faces = give_back(item, taken, mended)
        except isomend.Cancelled:
            self.report({"WARNING"}, "Cancelled; nothing was changed")
            return {"CANCELLED"}
        except (isomend.IsomendError, NothingToDo, NotGivenBack) as error:
            self.report({"ERROR"}, sentence(str(error)))
            return {"CANCELLED"}
        shown = context.scene.isomend
        shown.holes.clear()
        shown.checked = ""
        self.report({"INFO" if mended.complete else "WARNING"}, summary(mended, taken, context, vertices, faces))
        return {"FINISHED"}


class ISOMEND_OT_fill(Mending, bpy.types.Operator):
    """Fill holes with surfaces that continue the curvature of their surroundings. The mesh's own faces do not change"""

    bl_idname = "isomend.fill"
    bl_label = "Fill holes"
    __annotations__ = {**settings.of_fill(), **settings.common()}

    def work(self, taken):
        options = self.solving(taken)
        widest = taken.length(self.max_diameter)
        chosen_alone, flat, bridge = self.scope == "SELECTED", self.flat, self.bridge

        def fill(progress):
            found = taken.model().inspect()
            chosen = taken.chosen_holes(found.holes) if chosen_alone else [hole.id for hole in found.holes if not hole.is_outer_boundary]
            to_fill = [hole.id for hole in found.holes if hole.id in chosen and not (widest and hole.diameter > widest)]
            if not to_fill:
                raise NothingToDo(reason_for_none(found.holes, chosen_alone, len(chosen)))
            if bridge and not (chosen_alone and len(to_fill) > 1):
                raise NothingToDo("a bridge joins two or more selected holes; select an edge of each rim, and choose selected holes")
            return found.fill(
                holes=to_fill if chosen_alone else None, max_diameter=widest, flat=to_fill if flat else (),
                bridge=[to_fill] if bridge else (), progress=progress, **options,
            )  # fmt: skip

        return fill


def reason_for_none(holes, chosen_alone, chosen):
    """Why there is no hole to fill."""
    if not holes:
        return "the mesh has no holes"
    if chosen:
        return "all chosen holes are wider than the largest diameter"
    if chosen_alone:
        return "no hole is selected; select an edge of its rim, or choose all holes"
    return "the mesh has only outer borders of open sheets; select an edge of one to fill it"


class ISOMEND_OT_restore(Mending, bpy.types.Operator):
    """Cut out the selected faces and fill the region with a surface that continues its surroundings"""

    bl_idname = "isomend.restore"
    bl_label = "Restore selected faces"
    __annotations__ = {**settings.of_restore(), **settings.common()}

    def work(self, taken):
        options = self.solving(taken) | {"keep_shape": self.keep_shape}
        return on_faces(taken, lambda marks, progress: taken.model().restore(marks, keep_vertices=True, progress=progress, **options))


class ISOMEND_OT_fair(Mending, bpy.types.Operator):
    """Smooth the selected faces by Willmore flow: noise and small features are removed, large forms stay"""

    bl_idname = "isomend.fair"
    bl_label = "Fair selected faces"
    __annotations__ = settings.of_fair()

    def work(self, taken):
        strength = taken.length(self.strength)
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
        options |= {"close_borders": self.close_borders, "skip": ["holes"] * self.keep_holes}
        options |= {"weld": taken.length(self.weld), "debris": self.debris or None}
        return lambda progress: taken.model().repair(progress=progress, **options)


def on_faces(taken, mend):
    """Work on the selected faces: calls `mend(marks, progress)`; raises `NothingToDo` if no face is selected."""
    marks = taken.marks()

    def work(progress):
        if not marks.any():
            raise NothingToDo("no face is selected")
        return mend(marks, progress)

    return work


def sentence(text):
    """The message with a capital first letter."""
    return text[:1].upper() + text[1:]


def summary(mended, taken, context, vertices, faces):
    """A line that says what was done, with lengths in the units of the scene."""
    report = mended.report
    parts = [f"{faces} new faces, {vertices} new vertices"]
    holes = [hole for hole in report.get("holes", []) if hole.get("outcome") not in (None, "left")]
    failed = [hole for hole in holes if hole["outcome"] == "open"]
    if holes:
        parts.insert(0, f"{len(holes) - len(failed)} of {len(holes)} holes closed")
    if any(region.get("counterpart") for region in report.get("regions", [])):
        parts.append(f"{sum(hole.get('closed_by') == 'counterpart' for hole in holes)} with the mirrored shape")
    errors = mended.sigma[mended.sigma > 0]
    if len(errors):
        parts.append(f"expected error at most {shown_length(context, float(errors.max()) * taken.scale)}")
    if failed:
        parts.append(f"hole {failed[0]['id']}: {failed[0]['reason']}")
    after = report.get("after")
    if after:
        parts.append("the mesh has no defects any more" if after["sound"] else "; ".join(after["reasons"]))
    return "; ".join(parts)


# For each system of units: its units with their lengths in metres, the largest first.
UNITS = {
    "METRIC": (("m", 1), ("mm", 1e-3), ("µm", 1e-6)),
    "IMPERIAL": (("ft", 0.3048), ("in", 0.0254), ("thou", 2.54e-5)),
}


def shown_length(context, length):
    """A length of the scene as text, with the unit that suits its size."""
    units = context.scene.unit_settings
    if units.system not in UNITS:
        return f"{length:.2g}"
    metres = length * units.scale_length
    all_units = UNITS[units.system]
    name, size = next((unit for unit in all_units if metres >= unit[1]), all_units[-1])
    return f"{metres / size:.3g} {name}"


CLASSES = (ISOMEND_OT_fill, ISOMEND_OT_restore, ISOMEND_OT_fair, ISOMEND_OT_repair)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
