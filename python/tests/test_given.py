"""What functions take in place of what they name, and what they say of a mistake: holes for numbers, meshes for volumes, arrays for pairs."""

import importlib
import importlib.util

import numpy as np
import pytest
import shapes

import isomend

STRUCTURED = """# vtk DataFile Version 3.0
x
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 2 2 2
ORIGIN 0 0 0
SPACING 1 1 1
POINT_DATA 8
SCALARS d float 1
LOOKUP_TABLE default
-1 1 1 1 1 1 1 1
"""


def test_holes_stand_for_their_numbers():
    vertices, faces = shapes.open_ends()
    found = isomend.inspect(vertices, faces)
    first, second = found.holes
    assert found.fill(holes=found.holes).faces.tolist() == found.fill(holes=[1, 2]).faces.tolist()
    assert found.fill(keep_open=[second]).report["outcomes"] == found.fill(keep_open=[2]).report["outcomes"]
    assert found.fill(flat=(first, 2)).report["outcomes"]["flat"] == 2
    bridged = found.fill(bridge=[found.holes])
    assert [region["holes"] for region in bridged.report["regions"]] == [[1, 2]]
    with pytest.raises(isomend.ParameterError, match=r"^holes must be a list of hole numbers, such as \[1\], or 'all', but is the hole 1$"):
        found.fill(holes=first)
    with pytest.raises(isomend.ParameterError, match=r"such as \[1\], or 'all', but is 2$"):
        found.fill(holes=2)
    # A hole is no component.
    with pytest.raises(isomend.ParameterError, match="^each number of drop must be a whole number, but is the hole 1$"):
        isomend.repair(vertices, faces, drop=[first])


def test_crease_ends_stand_for_their_numbers():
    vertices, faces = shapes.open_cube()
    found = isomend.inspect(vertices, faces)
    ends = found.crease_ends[:2]
    assert len(ends) == 2
    assert found.fill(crease=[ends]).faces.tolist() == found.fill(crease=[(1, 2)]).faces.tolist()
    with pytest.raises(isomend.ParameterError, match="but is the hole 1$"):
        found.fill(crease=[(found.holes[0], ends[0])])


def test_holes_of_a_result_have_expected_errors():
    vertices, faces = shapes.open_ends()
    filled = isomend.fill(vertices, faces, holes=[1])
    closed, left = filled.holes
    assert closed["expected_error"] == filled.report["invented"]["patches"][0]["expected_error"]
    assert 0 < closed["expected_error"]["mean"] <= closed["expected_error"]["largest"] == filled.sigma.max()
    assert left["outcome"] == "left" and left["expected_error"] is None
    assert isomend.fill(*shapes.closed_sphere()).holes == [] and isomend.fair(*shapes.closed_sphere(), strength=0.3).holes == []


def test_the_number_of_holes_is_said_in_words():
    sheet = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    meshes = [shapes.closed_sphere(), sheet, shapes.open_ends()]
    assert [repr(isomend.inspect(*mesh)).split(" with ")[1] for mesh in meshes] == ["no holes>", "1 hole>", "2 holes>"]


def test_a_mesh_is_no_volume_and_the_other_way_round(tmp_path):
    ball = isomend.Model(*shapes.closed_sphere())
    with pytest.raises(TypeError, match=r"isomend\.surface\(volume\) extracts"):
        isomend.fill(ball.sdf(voxel=0.2))
    with pytest.raises(TypeError, match=r"isomend\.surface\(volume\) extracts"):
        isomend.fill_mesh(ball.sdf(voxel=0.2))
    for ending in ("ply", "stl", "vtp", "vtk", "obj"):
        ball.write(tmp_path / f"ball.{ending}")
        with pytest.raises(isomend.FileError, match=rf"ball.{ending} holds a mesh, not a volume: isomend.read reads it") as error:
            isomend.read_volume(tmp_path / f"ball.{ending}")
        assert error.value.filename == str(tmp_path / f"ball.{ending}")
    with pytest.raises(isomend.FileError, match="the bytes hold a mesh"):
        isomend.surface((tmp_path / "ball.ply").read_bytes())
    (tmp_path / "cut.vti").write_bytes(ball.sdf(voxel=0.2).to_bytes()[:300])
    with pytest.raises(isomend.FileError, match="damaged"):
        isomend.read_volume(tmp_path / "cut.vti")
    with pytest.raises(isomend.FileError, match="No such file|cannot find"):
        isomend.read_volume(tmp_path / "none.vti")
    ball.sdf(voxel=0.2).write(tmp_path / "ball.vti")
    (tmp_path / "points.vtk").write_text(STRUCTURED)
    for path in (tmp_path / "ball.vti", tmp_path / "points.vtk"):
        assert isomend.read_volume(path).values.size
        for read in (isomend.read, isomend.fill, isomend.check, lambda path: isomend.restore(ball, {"inside": [path]})):
            with pytest.raises(isomend.FileError, match=r"it is a volume: isomend\.read_volume reads it, isomend\.surface") as error:
                read(path)
            assert "'isomend" not in str(error.value) and error.value.filename == str(path)


def meshes_of_all_kinds(vertices, faces):
    """The same mesh as a model, a result, pairs of arrays and of lists, and a mesh of each installed package."""
    model = isomend.Model(vertices, faces)
    yield from (model, model.fill(), (vertices, faces), [vertices, faces], (vertices.tolist(), faces.tolist()))
    for name, make in (
        ("trimesh", lambda package: package.Trimesh(vertices, faces, process=False)),
        ("pyvista", lambda package: package.PolyData.from_regular_faces(vertices, faces)),
        ("meshio", lambda package: package.Mesh(vertices, [("triangle", faces)])),
    ):
        if importlib.util.find_spec(name):
            yield make(importlib.import_module(name))


def test_meshes_of_all_kinds_stand_for_the_files_of_a_mask(tmp_path):
    ball = 0.4 * shapes.closed_sphere()[0] + (0, 0, -1), shapes.closed_sphere()[1]
    isomend.Model(*ball).write(tmp_path / "ball.ply")
    mesh = isomend.Model(*shapes.open_sphere(around=24, latitudes=12, top=3))
    wanted = mesh.restore({"inside": tmp_path / "ball.ply"})
    assert wanted.report["removed_faces"] > 0
    for given in (tmp_path / "ball.ply", *meshes_of_all_kinds(*ball)):
        for inside in (given, [given], (given, str(tmp_path / "ball.ply")), iter([given])):
            assert mesh.restore({"inside": inside}).vertices.tobytes() == wanted.vertices.tobytes()
        assert isomend.compare(given, given).kept.faces == len(ball[1])
        assert isomend.signed_distance([[0, 0, -1]], given)[0] < -0.3
    assert isomend.fair(mesh, {"inside": ball}, strength=0.3).report["command"] == "fair"


def test_meshes_of_all_kinds_stand_for_a_counterpart(tmp_path):
    ball = shapes.closed_sphere()
    isomend.Model(*ball).write(tmp_path / "ball.ply")
    vertices, faces = shapes.open_sphere()
    wanted = isomend.fill(vertices, faces, like=tmp_path / "ball.ply")
    assert wanted.report["regions"][0]["closed_by"] == "counterpart"
    for given in meshes_of_all_kinds(*ball):
        assert isomend.fill(vertices, faces, like=given).vertices.tobytes() == wanted.vertices.tobytes()
    model, found, tasks = isomend.Model(*ball), isomend.inspect(vertices, faces), []
    assert isomend.repair(vertices, faces, like=model).complete
    assert isomend.Model(vertices, faces).plan(like=model)["dry_run"] and found.region_count(like=model) == 1
    found.each_task(tasks.append, like=model)
    wide = isomend.solve_task(found.wide_task(0, like=model))
    for patches in ([isomend.solve_task(task) for task in tasks], [wide]):
        assert found.assemble(patches, like=model).vertices.tobytes() == wanted.vertices.tobytes()


def test_vertices_alone_are_no_mesh():
    vertices, faces = shapes.closed_sphere()
    for call in (isomend.fill, isomend.as_model, lambda given: isomend.compare(given, faces)):
        for given in (vertices, vertices.tolist()):
            with pytest.raises(TypeError, match=r"as in isomend\.compare\(\(vertices, faces\), other\)"):
                call(given)
    assert isomend.compare((vertices, faces), (vertices, faces)).a_to_b.max < 1e-12


def test_a_volume_takes_its_place_by_position():
    values = np.arange(8.0).reshape(2, 2, 2)
    volume = isomend.Volume(values, (1, 2, 3), 0.5)
    assert volume.origin == (1, 2, 3) and volume.spacing == (0.5, 0.5, 0.5)
    named = isomend.Volume(values, spacing=(1, 2, 3))
    assert named.origin == (0, 0, 0) and named.spacing == (1, 2, 3)


def test_widths_are_as_documented():
    """Five areas over the length, at most the diameter."""
    along, rows = 20, 6
    at = {place: number for number, place in enumerate(np.ndindex(along + 1, rows + 1))}
    squares = [place for place in np.ndindex(along, rows) if not (5 <= place[0] < 15 and 2 <= place[1] < 4)]
    corners = [[at[place] for place in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))] for i, j in squares]
    faces = [face for a, b, c, d in corners for face in ((a, b, c), (a, c, d))]
    hole = isomend.inspect([(*place, 0) for place in at], faces).holes[1]
    assert hole.length == 24 and abs(hole.width - 5 * 20 / 24) < 1e-12
    assert "Five times the area over the length, at most the diameter" in isomend.Hole.__doc__
