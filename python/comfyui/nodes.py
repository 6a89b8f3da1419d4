"""ComfyUI nodes that check, repair and fill meshes. Lengths are in the units of the mesh; 0 stands for isomend's default."""

from . import meshes

ENERGIES = ["willmore", "curvature-variation"]


def length(text, **bounds):
    return ("FLOAT", {"default": 0.0, "min": 0.0, "max": 1e9, "step": 1e-4, "round": False, "tooltip": text, **bounds})


def flag(text):
    return ("BOOLEAN", {"default": False, "tooltip": text})


def following():
    """A progress function that updates ComfyUI's progress bar and obeys its stop button; none outside of ComfyUI."""
    try:
        import comfy.model_management
        import comfy.utils
    except ImportError:
        return None
    bar = comfy.utils.ProgressBar(100)

    def progress(part, done, regions_regions):
        bar.update_absolute(round(100 * part), 100)
        # Raises an exception if the user has stopped the run, which cancels isomend's work.
        comfy.model_management.throw_exception_if_processing_interrupted()

    return progress


def given(**options):
    """The options that are set: not 0, false or none."""
    return {name: value for name, value in options.items() if value}


class IsomendCheck:
    """Checks whether meshes are closed, manifold, oriented and free of self-intersections, and says why not."""

    CATEGORY = "3d/isomend"
    FUNCTION = "check"
    RETURN_TYPES = ("BOOLEAN", "STRING", "MESH")
    RETURN_NAMES = ("sound", "report", "mesh")
    OUTPUT_NODE = True

    @classmethod
    def INPUT_TYPES(cls):
        return {"required": {"mesh": ("MESH",), "min_wall": length("Not sound if a wall of a closed component is thinner than this")}}

    def check(self, mesh, min_wall=0.0):
        import isomend

        verdicts = [
            isomend.check(points, faces, **given(min_wall=min_wall)) for points, faces, _ in meshes.each(mesh)
        ]  # fmt: skip
        text = "\n\n".join(map(str, verdicts))
        sound = all(bool(verdict) for verdict in verdicts)
        return {"ui": {"text": [text]}, "result": (sound, text, mesh)}


class IsomendRepair:
    """Makes meshes closed, manifold, oriented and free of self-intersections, as far as that is possible."""

    CATEGORY = "3d/isomend"
    FUNCTION = "repair"
    RETURN_TYPES = ("MESH", "BOOLEAN", "STRING")
    RETURN_NAMES = ("mesh", "sound", "report")

    @classmethod
    def INPUT_TYPES(cls):
        return {
            "required": {
                "mesh": ("MESH",),
                "close_borders": flag("Also close outer borders of open sheets"),
                "keep_holes": flag("Leave the holes of the mesh open"),
                "solid": flag("Remove the inner skins of double-skinned bodies and close the pinholes that lead to them"),
                "debris": length("Remove components with less than this part of the largest component's area", max=1.0),
                "weld": length("Merge boundary vertices that are no farther apart than this"),
            }
        }

    def repair(self, mesh, close_borders=False, keep_holes=False, solid=False, debris=0.0, weld=0.0):
        options = given(close_borders=close_borders, skip=["holes"] * keep_holes, solid=solid, debris=debris, weld=weld, progress=following())
        out, results = meshes.mended(mesh, lambda model: model.repair(**options))
        sound = all(result.complete for result in results)
        reasons = ["; ".join(result.report["after"]["reasons"]) or "nothing is wrong" for result in results]
        return out, sound, "\n".join(reasons)


class IsomendFill:
    """Fills holes with surfaces that continue the curvature of their surroundings. The meshes' own faces do not change."""

    CATEGORY = "3d/isomend"
    FUNCTION = "fill"
    RETURN_TYPES = ("MESH", "BOOLEAN", "STRING")
    RETURN_NAMES = ("mesh", "complete", "report")

    @classmethod
    def INPUT_TYPES(cls):
        return {
            "required": {
                "mesh": ("MESH",),
                "max_diameter": length("Leave wider holes open"),
                "energy": (ENERGIES, {"tooltip": "Energy that patches minimise: bending, or the variation of curvature"}),
                "voxel": length("Grid spacing of the level set"),
            }
        }

    def fill(self, mesh, max_diameter=0.0, energy="willmore", voxel=0.0):
        options = given(max_diameter=max_diameter, energy=energy, voxel=voxel, progress=following())
        out, results = meshes.mended(mesh, lambda model: model.fill(**options))
        return out, all(result.complete for result in results), "\n".join(map(holes_of, results))


def holes_of(result):
    """A line that says how many holes of a mesh were closed."""
    outcomes = [hole["outcome"] for hole in result.report["holes"]]
    closed = outcomes.count("closed")
    return f"{closed} of {len(outcomes)} holes closed, {int(result.is_patch.sum())} new faces"


NODE_CLASS_MAPPINGS = {"IsomendCheck": IsomendCheck, "IsomendRepair": IsomendRepair, "IsomendFill": IsomendFill}
NODE_DISPLAY_NAME_MAPPINGS = {
    "IsomendCheck": "Check mesh (isomend)",
    "IsomendRepair": "Repair mesh (isomend)",
    "IsomendFill": "Fill holes (isomend)",
}
