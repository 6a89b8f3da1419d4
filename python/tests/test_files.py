"""Files that are filled, restored, faired and copied: the same bytes as from the command line."""

import subprocess
import zipfile

import numpy as np
import pytest
import shapes
from conftest import DATA

import isomend


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "gltf", "glb", "vtk", "vtp", "off", "3mf", "usda", "usdz"])
@pytest.mark.parametrize("name", ["sphere.ply", "sheet.obj"])
def test_the_command_line_fills_files_to_the_same_bytes(tmp_path, program, name, kind):
    theirs, own = tmp_path / "theirs", tmp_path / "own"
    theirs.mkdir(), own.mkdir()
    subprocess.run([program, "fill", DATA / name, "-o", theirs / f"a.{kind}", "-q"], check=True)
    filled = isomend.read(DATA / name).fill()
    filled.write(own / f"a.{kind}")
    assert {p.name: p.read_bytes() for p in own.iterdir()} == {p.name: p.read_bytes() for p in theirs.iterdir()}
    if kind not in ("gltf", "obj"):
        assert filled.to_bytes(kind) == (theirs / f"a.{kind}").read_bytes()


@pytest.mark.parametrize("kind", ["ply", "glb"])
def test_the_command_line_fills_glb_files_to_the_same_bytes(tmp_path, program, kind):
    run = lambda *words: subprocess.run([program, *words, "-q"], cwd=tmp_path, check=True)  # noqa: E731
    run("fill", str(DATA / "sheet.obj"), "-o", "first.glb", "--max-diameter", "0.001")
    run("fill", "first.glb", "-o", f"theirs.{kind}", "--holes", "2")
    isomend.read(tmp_path / "first.glb").fill(holes=[2]).write(tmp_path / f"own.{kind}")
    assert (tmp_path / f"own.{kind}").read_bytes() == (tmp_path / f"theirs.{kind}").read_bytes()


@pytest.mark.parametrize("name", ["painted.ply"])
def test_the_command_line_restores_files_to_the_same_bytes(tmp_path, program, name):
    words = [program, "restore", DATA / name, "-o", tmp_path / "theirs.ply", "--colour", "ff0000", "--grow", "0.2", "-q"]
    subprocess.run(words, check=True)
    mask = {"colours": [{"rgb": [1, 0, 0], "tolerance": 0.1}], "grow": 0.2}
    model = isomend.read(DATA / name)
    restored = model.restore(mask)
    marked, removed = restored.report["marked_faces"], restored.report["removed_faces"]
    theirs = isomend.read(tmp_path / "theirs.ply")
    assert removed >= marked > 0
    restored.write(tmp_path / "own.ply")
    assert (tmp_path / "own.ply").read_bytes() == (tmp_path / "theirs.ply").read_bytes()
    assert np.array_equal(theirs.faces, restored.faces)


def test_a_restored_glb_keeps_its_document(tmp_path, program):
    isomend.read(DATA / "sphere.ply").fill().write(tmp_path / "a.glb")
    ball = {"balls": [[[0, 0, -1], 0.6]]}
    words = [program, "restore", "a.glb", "-o", "theirs.glb", "--ball", "0,0,-1,0.6", "-q"]
    subprocess.run(words, cwd=tmp_path, check=True)
    isomend.read(tmp_path / "a.glb").restore(ball).write(tmp_path / "own.glb")
    assert (tmp_path / "own.glb").read_bytes() == (tmp_path / "theirs.glb").read_bytes()


def test_the_command_line_fairs_files_to_the_same_bytes(tmp_path, program):
    words = [program, "fair", DATA / "sphere.ply", "-o", tmp_path / "theirs.ply", "--ball", "0,0,-1,0.6", "--strength", "0.5", "-q"]
    subprocess.run(words, check=True)
    isomend.read(DATA / "sphere.ply").fair({"balls": [[[0, 0, -1], 0.6]]}, strength=0.5).write(tmp_path / "own.ply")
    assert (tmp_path / "own.ply").read_bytes() == (tmp_path / "theirs.ply").read_bytes()


def test_a_file_is_read_and_written_unchanged(tmp_path):
    for name in ("scan.ply", "sheet.obj"):
        model = isomend.read(DATA / name)
        assert isomend.read((DATA / name).read_bytes(), format=name[-3:]).vertices.tobytes() == model.vertices.tobytes()
        model.write(tmp_path / "copy.ply")
        assert isomend.read(tmp_path / "copy.ply").faces.tobytes() == model.faces.tobytes()
    assert model.to_bytes("ply", ascii=True).startswith(b"ply\nformat ascii")
    assert "sheet" not in repr(model) and "vertices" in repr(model)


def test_a_3mf_package_keeps_what_a_model_does_not_hold(tmp_path):
    plain, painted, out = (tmp_path / f"{name}.3mf" for name in ("plain", "painted", "out"))
    isomend.convert(DATA / "sphere.ply", plain)
    with zipfile.ZipFile(plain) as package:
        parts = {name: package.read(name) for name in package.namelist()}
    name = "3D/3dmodel.model"
    count = parts[name].count(b"<triangle ")
    parts[name] = parts[name].replace(b'"/>\n<triangle ', b'" paint_color="8"/>\n<triangle ')
    parts["Metadata/project_settings.config"] = b"{}"
    with zipfile.ZipFile(painted, "w") as package:
        for part, content in parts.items():
            package.writestr(part, content)
    for paint in ("none", "continue"):
        filled = isomend.fill(painted)
        filled.delivering(paint=paint).write(out)
        with zipfile.ZipFile(out) as package:
            assert package.read("Metadata/project_settings.config") == b"{}"
            painted_faces = package.read(name).count(b"paint_color")
        assert painted_faces == count - 1 if paint == "none" else painted_faces > count
    with pytest.raises(isomend.ParameterError, match='"none" or "continue"'):
        filled.delivering(paint="red")


def test_values_of_a_file_are_arrays_of_the_model(tmp_path):
    model = isomend.read(DATA / "painted.ply")
    colours = [values for values in model.point_data.values() if values.dtype == np.uint8]
    assert colours and len(colours[0]) == len(model.vertices)
    sheet = isomend.read(DATA / "sheet.obj").fill(holes=[1])
    for values in sheet.corner_data.values():
        assert values.shape[:2] == (len(sheet.faces), 3)


def test_a_file_of_64_bit_floats_stays_exact(tmp_path, program):
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=3)
    isomend.Model(vertices, faces).write(tmp_path / "a.vtp")
    subprocess.run([program, "fill", "a.vtp", "-o", "theirs.vtp", "-q"], cwd=tmp_path, check=True)
    filled = isomend.read(tmp_path / "a.vtp").fill()
    assert filled.vertices.tobytes() == isomend.fill(vertices, faces).vertices.tobytes()
    assert filled.to_bytes("vtp") == (tmp_path / "theirs.vtp").read_bytes()
