"""check, repair, compare, convert, sdf and surface on arrays give the results of the commands."""

import json
import os
import subprocess

import numpy as np
import pytest
import shapes

import isomend


def report_of(program, folder, *words):
    """The JSON report of a command; its exit code may be 3."""
    done = subprocess.run([program, *map(str, words), "-q", "--json", "-"], cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 3), done.stderr
    return json.loads(done.stdout)


def of_files(report, *timed):
    """A report without the entries of files and without the times."""
    return {name: value for name, value in report.items() if name not in ("input", "output", "first", "second", *timed)}


def damaged():
    """A ball with a hole, a duplicate face and turned faces, and a small ball that pierces it."""
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=2)
    small, of_small = shapes.closed_sphere()
    turned = faces.copy()
    turned[:40] = turned[:40, ::-1]
    small = 0.3 * small + (0.0, 0.0, -1.0)
    return np.vstack([vertices, small]), np.vstack([turned, faces[100:101], of_small + len(vertices)])


def test_the_command_line_gives_the_same_verdict(tmp_path, program):
    vertices, faces = damaged()
    verdict = isomend.check(vertices, faces, thin=0.05, debris=0.2)
    isomend.Model(vertices, faces).write(tmp_path / "a.obj")
    report = report_of(program, tmp_path, "check", "a.obj", "--thin", 0.05, "--debris", 0.2)
    assert of_files(verdict.report) == of_files(report)
    assert not verdict and not verdict.sound and verdict.reasons == report["reasons"]
    assert not verdict.watertight and not verdict.closed and not verdict.oriented and verdict.manifold == report["manifold"]
    assert set(verdict.defects) == {defect["kind"] for defect in report["defects"]} >= {"boundary_edge", "misoriented", "self_intersection", "duplicate"}
    for defect in report["defects"]:
        own = verdict.defects[defect["kind"]]
        assert own.count == defect["count"] and own.faces.dtype == np.int64
        assert own.faces[:1000].tolist() == defect["faces"] and own.places[:1000].tolist() == defect["places"]
    # Lines are folded where COLUMNS is set, as some packages do.
    unfolded = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    command = [program, "check", "a.obj", "--thin", "0.05", "--debris", "0.2"]
    printed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=unfolded)
    # The command line ends with the command that mends the mesh.
    mends = "\nto mend it: isomend repair a.obj -o OUT\n"
    assert f"{verdict}\n{mends}" == printed.stdout and verdict.reasons[0] in repr(verdict)
    # All faces are listed, not only the thousand of the report.
    assert len(isomend.check(*shapes.closed_sphere(), thin=3).defects["thin"].faces) == len(shapes.closed_sphere()[1]) > 1000


def test_a_ball_is_sound():
    verdict = isomend.check(*shapes.closed_sphere())
    assert verdict and verdict.watertight and verdict.defects == {} and verdict.reasons == []
    assert isomend.Model(*shapes.closed_sphere()).check(threads=1).report == verdict.report


def test_the_command_line_gives_the_same_repair(tmp_path, program):
    vertices, faces = damaged()
    done = isomend.repair(vertices, faces)
    assert done.complete and isomend.check(done.vertices, done.faces).sound and shapes.is_closed(done.faces)
    assert not done.report["before"]["sound"] and done.report["after"]["sound"] and done.report["command"] == "repair"
    assert done.report["steps"]["duplicate_faces"] == 1 and done.report["steps"]["united_bodies"] == 2
    isomend.Model(vertices, faces).write(tmp_path / "a.obj")
    report = report_of(program, tmp_path, "repair", "a.obj", "-o", "theirs.obj")
    done.write(tmp_path / "own.obj")
    assert (tmp_path / "own.obj").read_bytes() == (tmp_path / "theirs.obj").read_bytes()
    assert of_files(done.report, "seconds", "regions") == of_files(report, "seconds", "regions")
    # Kept faces come first, and the patches after them.
    assert done.kept_faces.shape == (len(faces),) and done.is_patch.sum() > 0
    assert not done.is_patch[: done.kept_faces.sum()].any()
    kept = isomend.repair(vertices, faces, keep_open=[1])
    assert not kept.complete and kept.report["after"]["holes"] == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"skip": ["holes"]}, ["--skip", "holes"]),
        ({"skip": "duplicates"}, ["--skip", "duplicates"]),
        ({"skip": ["orientation", "holes"]}, ["--skip", "orientation,holes"]),
        ({"skip": ["non-manifold"]}, ["--skip", "non-manifold"]),
        ({"skip": ["intersections"]}, ["--skip", "intersections"]),
        ({"keep_open": [1]}, ["--keep-open", "1"]),
        ({"solid": True}, ["--solid"]),
        ({"drop_unused": True, "drop_inside": True}, ["--drop-unused", "--drop-inside"]),
        ({"debris": 0.9, "weld": 1e-3, "close_borders": True}, ["--debris", "0.9", "--weld", "0.001", "--close-borders"]),
        ({"max_diameter": 0.01, "voxel": 0.05, "finish": "none"}, ["--max-diameter", "0.01", "--voxel", "0.05", "--finish", "none"]),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
)
def test_the_command_line_gives_the_same_repair_for_each_option(tmp_path, program, options, words):
    vertices, faces = damaged()
    inner, of_inner = shapes.closed_sphere()
    vertices = np.vstack([vertices, 0.1 * inner, [(9.0, 9.0, 9.0)]])
    faces = np.vstack([faces, of_inner + len(vertices) - len(inner) - 1])
    isomend.Model(vertices, faces).write(tmp_path / "a.obj")
    report = report_of(program, tmp_path, "repair", "a.obj", "-o", "theirs.obj", *words)
    done, plain = isomend.repair(vertices, faces, **options), isomend.repair(vertices, faces)
    done.write(tmp_path / "own.obj")
    assert (tmp_path / "own.obj").read_bytes() == (tmp_path / "theirs.obj").read_bytes()
    assert done.report["steps"] == report["steps"] and done.report["after"] == report["after"]
    if options.get("skip") != ["non-manifold"] and "solid" not in options:
        assert plain.report["steps"] != done.report["steps"] or plain.vertices.tobytes() != done.vertices.tobytes()


def test_an_incomplete_repair_gives_the_reason(caplog):
    vertices, faces = shapes.open_sphere()
    with caplog.at_level("WARNING", logger="isomend"):
        loose = isomend.repair(vertices, faces, skip=["holes"])
    assert not loose.complete and "1 hole is open" in caplog.text
    with pytest.raises(isomend.StrictError, match="not sound: 1 hole is open"):
        isomend.repair(vertices, faces, skip=["holes"], strict=True)


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"weld": 0}, "weld must be a positive number"),
        ({"debris": 1.5}, "debris must be a number from 0 to 1"),
        ({"drop_inside": 1}, "drop_inside must be True or False"),
        ({"skip": ["hole"]}, "skip must be one of 'duplicates', .*'holes', but is 'hole'"),
        ({"skip": "holes", "close_borders": True}, "leave one of the two out"),
        ({"max_diameter": -1}, "max_diameter must be a positive number"),
        ({"voxel": 0}, "voxel must be a positive number"),
        ({"threads": 0}, "threads must be a whole number from 1"),
    ],
)
def test_invalid_options_of_a_repair_are_refused(sphere, options, what):
    with pytest.raises(isomend.ParameterError, match=what):
        isomend.repair(*sphere, **options)
    if "voxel" in options:
        with pytest.raises(isomend.ParameterError, match=r"repair has no parameter 'hole' \(is holes meant\?\); it has weld, "):
            isomend.Model(*sphere).repair(hole=[1])


def test_a_repair_continues_values_and_can_be_stopped():
    vertices, faces = damaged()
    data = {"point_data": {"heat": vertices[:, 2].astype(np.float32)}, "cell_data": {"scan": np.arange(len(faces), dtype=np.int32)}}
    done = isomend.repair(vertices, faces, **data)
    assert done.point_data["heat"].dtype == np.float32 and len(done.point_data["heat"]) == len(done.vertices)
    kept = np.flatnonzero(done.kept_faces)
    assert np.isin(kept, done.cell_data["scan"][~done.is_patch]).all()
    with pytest.raises(isomend.Cancelled):
        isomend.repair(*shapes.open_sphere(around=256, latitudes=128, top=50), progress=lambda *_: False)


def test_the_command_line_gives_the_same_comparison(tmp_path, program, sphere, filled):
    isomend.Model(*sphere).write(tmp_path / "a.obj")
    filled.write(tmp_path / "b.obj")
    report = report_of(program, tmp_path, "compare", "a.obj", "b.obj", "--samples", 5000)
    done = isomend.compare(sphere, filled, samples=5000)
    assert of_files(done.report) == of_files(report)
    assert done.report["first"] == {"vertices": len(sphere[0]), "faces": len(sphere[1])}
    assert done.kept.faces == done.kept.faces_in_order == len(sphere[1]) and done.kept.vertices == len(sphere[0])
    assert done.a_to_b.max < 1e-12 and done.b_to_a.max > 0.2 and done.b_to_a.samples == 5000
    assert done.b.area == pytest.approx(4 * np.pi, rel=0.01) and done.b.boundary_vertices == 0
    assert np.linalg.norm(done.b_to_a.max_at) == pytest.approx(1, abs=0.01)
    for first in (tmp_path / "a.obj", str(tmp_path / "a.obj"), isomend.Model(*sphere)):
        assert of_files(isomend.compare(first, filled.model(), samples=5000, threads=1).report) == of_files(report)
    for samples, what in ((0, "samples must be a whole number from 1"), (2.5, "samples must be a whole"), (10**9, "samples must be a whole number from 1 to 100000000, but is 1000000000")):
        with pytest.raises(isomend.ParameterError, match=what):
            isomend.compare(sphere, filled, samples=samples)
    with pytest.raises(isomend.MeshError, match="first mesh has no face with an area"):
        isomend.compare(([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), filled)
    with pytest.raises(TypeError, match="no mesh of trimesh"):
        isomend.compare(sphere, 3)


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "glb", "vtk", "vtp"])
def test_the_command_line_converts_to_the_same_bytes(tmp_path, program, kind, sphere):
    isomend.Model(*sphere, point_data={"heat": sphere[0][:, 2]}).write(tmp_path / "a.vtp")
    command = [program, "convert", "a.vtp", "-o", f"theirs.{kind}"]
    done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True)
    notes = isomend.convert(tmp_path / "a.vtp", tmp_path / f"own.{kind}")
    assert (tmp_path / f"own.{kind}").read_bytes() == (tmp_path / f"theirs.{kind}").read_bytes()
    assert notes or kind in ("vtk", "vtp", "ply")
    assert all(note in done.stderr for note in notes)


def test_a_conversion_takes_formats_by_name(tmp_path, sphere):
    isomend.Model(*sphere).write(tmp_path / "a.ply")
    isomend.convert((tmp_path / "a.ply").read_bytes(), tmp_path / "b.data", from_="ply", to="stl", ascii=True)
    assert (tmp_path / "b.data").read_bytes().startswith(b"solid")
    with pytest.raises(isomend.ParameterError, match="no format 'xyz'"):
        isomend.convert(tmp_path / "a.ply", tmp_path / "c.ply", to="xyz")
    with pytest.raises(isomend.FileError, match="none.ply"):
        isomend.convert(tmp_path / "none.ply", tmp_path / "c.ply")
    with pytest.raises(isomend.ParameterError, match="has no text form"):
        isomend.convert(tmp_path / "a.ply", tmp_path / "c.glb", ascii=True)


def test_the_command_line_gives_the_same_volume(tmp_path, program):
    vertices, faces = shapes.open_sphere(around=12, latitudes=8, top=2)
    sphere = vertices * (1.0, 0.2, 0.2), faces
    isomend.Model(*sphere).write(tmp_path / "a.obj")
    for options, words in (
        ({}, []),
        ({"voxel": 0.05, "band": 0.1}, ["--voxel", "0.05", "--band", "0.1"]),
        ({"voxel": 0.05, "band": "full"}, ["--voxel", "0.05", "--band", "full", "--f64"]),
    ):
        report = report_of(program, tmp_path, "sdf", "a.obj", "-o", "theirs.vti", *words)
        volume = isomend.sdf(*sphere, **options)
        volume.write(tmp_path / "own.vti", f64="--f64" in words)
        assert (tmp_path / "own.vti").read_bytes() == (tmp_path / "theirs.vti").read_bytes()
        assert volume.to_bytes(f64="--f64" in words) == (tmp_path / "own.vti").read_bytes()
        assert of_files(volume.report, "seconds") == of_files(report, "seconds")
        assert set(volume.report["seconds"]) == set(report["seconds"]) - {"reading", "writing", "total"}
        assert list(volume.dims) == report["dims"] and volume.spacing == (report["voxel"],) * 3


def test_the_values_of_a_volume_are_distances_at_its_nodes():
    vertices, faces = shapes.closed_sphere()
    vertices = vertices * (1.0, 0.8, 0.6) + (5.0, 0.0, 0.0)
    volume = isomend.sdf(vertices, faces, voxel=0.1, threads=1)
    assert volume.values.shape == volume.dims and len(set(volume.dims)) == 3
    nodes = np.stack(np.meshgrid(*map(np.arange, volume.dims), indexing="ij"), -1)
    points = (np.array(volume.origin) + np.array(volume.spacing) * nodes).reshape(-1, 3)
    distances = isomend.signed_distance(points, vertices, faces).reshape(volume.dims)
    assert np.abs(volume.values - distances).max() < 1e-12


def test_the_command_line_gives_the_same_surface(tmp_path, program, sphere):
    volume = isomend.sdf(*sphere, voxel=0.1)
    volume.write(tmp_path / "a.vti", f64=True)
    for options, words in (({}, []), ({"level": 0.1, "close": True}, ["--level", "0.1", "--close"])):
        report = report_of(program, tmp_path, "surface", "a.vti", "-o", "theirs.obj", *words)
        model = isomend.surface(volume, **options)
        model.write(tmp_path / "own.obj")
        own, theirs = model, isomend.read(tmp_path / "theirs.obj")
        assert np.array_equal(own.faces, theirs.faces) and np.abs(own.vertices - theirs.vertices).max() < 1e-6
        assert len(own.vertices) == report["output"]["vertices"]
        for source in (tmp_path / "a.vti", (tmp_path / "a.vti").read_bytes()):
            assert isomend.surface(source, **options).vertices.tobytes() == own.vertices.tobytes()
    away = np.linalg.norm(isomend.surface(volume, level=0.1).vertices, axis=1)
    assert away[isomend.surface(volume, level=0.1).vertices[:, 2] < 0].mean() == pytest.approx(1.1, abs=0.01)


def test_volumes_are_arrays_and_files(tmp_path):
    x, y, z = np.meshgrid(np.linspace(-1, 1, 11), np.linspace(-1, 1, 12), np.linspace(-1, 1, 13), indexing="ij")
    spacing = (2 / 10, 2 / 11, 2 / 12)
    ball = isomend.Volume(np.sqrt(x**2 + y**2 + z**2) - 0.7, origin=(-1, -1, -1), spacing=spacing)
    surface = isomend.surface(ball)
    assert np.abs(np.linalg.norm(surface.vertices, axis=1) - 0.7).max() < 0.02 and surface.check().sound
    ball.write(tmp_path / "ball.vti", array="density", f64=True)
    again = isomend.read_volume(tmp_path / "ball.vti", array="density")
    assert again.values.tobytes() == ball.values.tobytes() and again.origin == ball.origin and again.spacing == ball.spacing
    assert again.report is None and "11 x 12 x 13" in repr(again)
    open_one = isomend.surface(isomend.Volume(x), level=0.0, close=False)
    assert not open_one.check().closed and isomend.surface(isomend.Volume(x), close=True).check().closed


@pytest.mark.parametrize(
    ("call", "error", "what"),
    [
        (lambda s: isomend.check(*s, thin=0), isomend.ParameterError, "thin must be a positive number"),
        (lambda s: isomend.check(*s, debris=2), isomend.ParameterError, "debris must be a number from 0 to 1"),
        (lambda s: isomend.check(*s, threads=0), isomend.ParameterError, "threads must be a whole number from 1"),
        (lambda s: isomend.check(s[0], s[1][:0]), isomend.MeshError, "no faces"),
        (lambda s: isomend.sdf(*s, voxel=-1), isomend.ParameterError, "voxel must be a positive number"),
        (lambda s: isomend.sdf(*s, voxel=1e-6), isomend.ParameterError, "smallest voxel that fits"),
        (lambda s: isomend.sdf(*s, band="half"), isomend.ParameterError, "band must be a positive number or 'full', but is 'half'"),
        (lambda s: isomend.sdf(s[0], [[0, 0, 0]]), isomend.MeshError, "degenerate"),
        (lambda s: isomend.sdf(*s, voxel=0.2).write("a.vtk"), isomend.ParameterError, "end the name a.vtk in .vti"),
        (lambda s: isomend.sdf(*s, voxel=0.2).write("none/a.vti"), isomend.FileError, "no folder"),
        (lambda s: isomend.surface(isomend.sdf(*s, voxel=0.2), level=99), isomend.ParameterError, "one side of the level 99"),
        (lambda s: isomend.surface(isomend.sdf(*s, voxel=0.2), level=np.nan), isomend.ParameterError, "level must be a finite number"),
        (lambda s: isomend.surface(isomend.sdf(*s, voxel=0.2), array="a"), isomend.ParameterError, "one array only"),
        (lambda s: isomend.surface("none.vti"), isomend.FileError, "none.vti"),
        (lambda s: isomend.surface(isomend.Volume(np.full((3, 3, 3), np.nan))), isomend.ParameterError, "finite number first"),
        (lambda s: isomend.surface(isomend.Volume(np.zeros((1, 3, 3)))), isomend.ParameterError, "at least 2"),
        (lambda s: isomend.Volume(np.zeros((3, 3))), isomend.ParameterError, r"shape is \(3, 3\)"),
        (lambda s: isomend.Volume(np.zeros((3, 3, 3), complex)), isomend.ParameterError, "complex"),
        (lambda s: isomend.Volume(np.zeros((3, 3, 3)), spacing=0), isomend.ParameterError, "spacing must be a positive number"),
        (lambda s: isomend.Volume(np.zeros((3, 3, 3)), spacing=(1, 2)), isomend.ParameterError, "spacing must be three"),
        (lambda s: isomend.Volume(np.zeros((3, 3, 3)), origin=(0, 0, np.inf)), isomend.ParameterError, "origin must be three"),
        (lambda s: isomend.read_volume(b"nonsense"), isomend.FileError, "VTI"),
    ],
)
def test_invalid_input_is_refused(sphere, call, error, what):
    with pytest.raises(error, match=what):
        call(sphere)


def test_former_parameters_name_what_takes_their_place():
    model = isomend.Model(*damaged())
    for work, options, now in (
        (model.fill, {"repair": True}, "isomend repair"),
        (model.repair, {"keep_holes": True}, "--skip holes"),
        (model.restore, {"like_scale": True}, "--like"),
    ):
        with pytest.raises(isomend.ParameterError, match=f"any more: use .*{now}"):
            work(*[[0]] * (work == model.restore), **options)
