"""Draws data/blender.png: data/scan.ply in Blender before the extension's "Fill holes", after it, and with the expected error shown.

    python3 scripts/blender_picture.py --wheel WHEEL

Cycles renders it in Blender's Python module, which is installed into `.venv`."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from blender_environment import ROOT, python_with_blender

WIDTH, HEIGHT = 400, 475

DRAW = '''
import os, sys
import numpy as np
import bpy

bpy.ops.preferences.addon_enable(module="bl_pkg")
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
for item in list(bpy.data.objects):
    bpy.data.objects.remove(item)
bpy.ops.wm.ply_import(filepath="data/scan.ply", forward_axis="Y", up_axis="Z")
item = bpy.context.object
bpy.context.scene.unit_settings.scale_length = 0.001


def material(name, colour):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*colour, 1)
    made.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.6
    return made


item.data.materials.clear()
item.data.materials.append(material("scan", (0.55, 0.53, 0.5)))
box = np.array([tuple(c) for c in item.bound_box])
centre, size = box.mean(axis=0), float(np.ptp(box, axis=0).max())

scene = bpy.context.scene
camera = bpy.data.cameras.new("camera")
camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", 1.05 * size, 10 * size
eye = bpy.data.objects.new("camera", camera)
scene.collection.objects.link(eye)
scene.camera = eye
from mathutils import Vector
way = Vector((-0.75, -1.0, 0.25)).normalized()
eye.location = Vector(centre) + 3 * size * way
eye.rotation_euler = (-way).to_track_quat("-Z", "Y").to_euler()
for power, turn in ((2.2, (0.9, 0.1, -0.9)), (0.8, (1.2, 0, 1.2))):
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = power, turn
    scene.collection.objects.link(sun)
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0.6
scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 32
scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = int(sys.argv[3]), int(sys.argv[4])
scene.render.film_transparent = False
scene.view_settings.view_transform = "Standard"


def render(name):
    scene.render.filepath = os.path.join(sys.argv[2], name)
    bpy.ops.render.render(write_still=True)


render("before.png")
bpy.ops.isomend.fill(scope="ALL")
item.data.materials.append(material("patch", (0.9, 0.35, 0.05)))
marks = np.zeros(len(item.data.polygons), bool)
item.data.attributes["isomend_patch"].data.foreach_get("value", marks)
item.data.polygons.foreach_set("material_index", marks.astype(np.int32))
item.data.update()
render("after.png")
bpy.ops.isomend.show_error()
render("error.png")
images = []
for name in ("before.png", "after.png", "error.png"):
    image = bpy.data.images.load(os.path.join(sys.argv[2], name))
    pixels = np.zeros(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    images.append(pixels.reshape(image.size[1], image.size[0], 4))
whole = np.concatenate(images, axis=1)
out = bpy.data.images.new("all", whole.shape[1], whole.shape[0])
out.pixels.foreach_set(np.ascontiguousarray(whole).ravel())
out.filepath_raw, out.file_format = "data/blender.png", "PNG"
out.save()
'''


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--wheel", type=Path, required=True, help="a wheel of isomend for this system")
    arguments = parser.parse_args()
    python, why = python_with_blender("pytest==9.2.0")
    if python is None:
        sys.exit(f"the picture needs Blender: {why}")
    with tempfile.TemporaryDirectory() as folder:
        pack = [sys.executable, ROOT / "scripts/blender_extension.py", "--out", folder, arguments.wheel.resolve()]
        packed = subprocess.run(pack, check=True, capture_output=True, text=True).stdout.strip()
        environment = os.environ | {"BLENDER_USER_RESOURCES": f"{folder}/user"}
        words = [python, "-c", DRAW, packed, folder, str(WIDTH), str(HEIGHT)]
        subprocess.run(words, check=True, cwd=ROOT, env=environment)


if __name__ == "__main__":
    main()
