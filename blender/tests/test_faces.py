"""Restoring, fairing and repairing: faces that are not selected or defective stay, with all their attributes."""

from types import SimpleNamespace

import numpy as np
import pytest
import shapes


def choose(item, inside):
    """Selects the polygons whose centre a function accepts."""
    marks = np.array([bool(inside(p.center)) for p in item.data.polygons])
    item.data.polygons.foreach_set("select", marks)
    return marks


def numbered(item):
    """Gives the polygons numbers, from 1, and texture coordinates to their corners."""
    mesh = item.data
    mesh.attributes.new("number", "INT", "FACE").data.foreach_set("value", np.arange(1, len(mesh.polygons) + 1, dtype=np.int32))
    uv = mesh.uv_layers.new(name="UVMap")
    uv.data.foreach_set("uv", np.arange(2 * len(mesh.loops), dtype=np.float32))


def corners(mesh):
    """For each polygon the positions and texture coordinates of its corners, from the first one in order."""
    uv = mesh.uv_layers["UVMap"].data
    places = [[tuple(mesh.vertices[mesh.loops[n].vertex_index].co) for n in p.loop_indices] for p in mesh.polygons]
    return [[(place, tuple(uv[n].uv)) for place, n in zip(row, p.loop_indices)] for row, p in zip(places, mesh.polygons)]


def stayed(item, before, marks):
    """How many polygons that were not selected are as they were, corner by corner and in order, at the beginning of the mesh. A few at
    the rim lose one of their triangles."""
    numbers = shapes.values(item.data, "number", "value")[:, 0].astype(int) - 1
    after = corners(item.data)
    whole = next((n for n in range(1, len(numbers)) if numbers[n] < numbers[n - 1]), len(numbers))
    assert not marks[numbers[:whole]].any() and [before[n] for n in numbers[:whole]] == after[:whole]
    return whole


def test_restored_faces_are_the_command_lines(bpy, scene, program, tmp_path):
    import isomend

    vertices, faces = shapes.globe()
    bump = (vertices[:, 0] > 0.85).reshape(-1, 1)
    item = shapes.added(bpy, vertices * (1 + 0.1 * bump), faces)
    numbered(item)
    marks = choose(item, lambda centre: centre.x > 0.7)
    before = corners(item.data)
    triangles, of = shapes.triangles_of(item.data), [t.polygon_index for t in item.data.loop_triangles]
    shapes.write_ply(tmp_path / "in.ply", shapes.positions(item.data), triangles)
    (tmp_path / "faces.txt").write_text("\n".join(str(i) for i, p in enumerate(of) if marks[p]))
    program("restore", tmp_path / "in.ply", "-o", tmp_path / "out.ply", "-q", "--faces", tmp_path / "faces.txt")
    expected = isomend.read(str(tmp_path / "out.ply")).vertices.astype(np.float32)

    assert bpy.ops.isomend.restore() == {"FINISHED"}
    mesh = item.data
    assert np.array_equal(shapes.positions(mesh), expected)
    assert not mesh.validate(verbose=True) and shapes.is_closed(mesh)
    assert stayed(item, before, marks) >= (~marks).sum() - 8
    radii = np.linalg.norm(shapes.positions(mesh), axis=1)
    assert abs(radii - 1).max() < 0.02, "the bump is gone"


def test_fairing_takes_noise_away_where_faces_are_selected(bpy, scene):
    vertices, faces = shapes.globe()
    noise = 0.01 * np.random.default_rng(1).standard_normal((len(vertices), 1)) * (vertices[:, :1] > 0.5)
    item = shapes.added(bpy, vertices * (1 + noise), faces)
    numbered(item)
    marks = choose(item, lambda centre: centre.x > 0.45)
    before = corners(item.data)
    assert bpy.ops.isomend.fair(strength=0.6) == {"FINISHED"}
    assert stayed(item, before, marks) >= (~marks).sum() - 8
    assert shapes.is_closed(item.data) and not item.data.validate(verbose=True)
    radii = np.linalg.norm(shapes.positions(item.data), axis=1)
    assert abs(radii[shapes.positions(item.data)[:, 0] > 0.6] - 1).std() < 0.005


def test_nothing_selected_or_all_of_it_is_said(bpy, scene):
    item = shapes.added(bpy, *shapes.globe())
    choose(item, lambda centre: False)
    for operator in (bpy.ops.isomend.restore, bpy.ops.isomend.fair):
        with pytest.raises(RuntimeError, match="No face is selected"):
            operator()
    choose(item, lambda centre: True)
    count = len(item.data.polygons)
    with pytest.raises(RuntimeError):
        bpy.ops.isomend.fair()
    assert len(item.data.polygons) == count


def test_repair_of_turned_and_duplicate_faces_and_holes(bpy, scene):
    vertices, faces = shapes.globe(without=shapes.window())
    faces = [tuple(reversed(f)) if i in (100, 101, 350) else f for i, f in enumerate(faces)]
    item = shapes.added(bpy, vertices, [*faces, faces[200]])
    numbered(item)
    before = corners(item.data)
    assert bpy.ops.isomend.repair() == {"FINISHED"}
    mesh = item.data
    assert shapes.is_closed(mesh) and not mesh.validate(verbose=True)
    after, numbers = corners(mesh), shapes.values(mesh, "number", "value")[:, 0].astype(int)
    # Quadrilaterals stay quadrilaterals, also if they are reversed; each corner keeps its texture coordinates.
    kept = [after[i] for i in range(len(faces))]
    assert numbers[: len(faces)].tolist() == list(range(1, len(faces) + 1))
    for old, new in zip(before, kept):
        assert sorted(old) == sorted(new)
    radii = [p.center.dot(p.normal) for p in mesh.polygons]
    assert min(radii) > 0, "all faces look outward"


def test_repair_unites_bodies_that_intersect(bpy, scene):
    vertices, faces = shapes.globe()
    count = len(vertices)
    # Two balls that intersect; the corners of one quadrilateral are separate vertices at the positions of others.
    both = np.concatenate([vertices, vertices + np.float32([0.9, 0.2, 0.1]), vertices[list(faces[400])]])
    quads = [tuple(2 * count + i for i in range(len(f))) if n == 400 else f for n, f in enumerate(faces)]
    item = shapes.added(bpy, both, [*quads, *[tuple(count + v for v in f) for f in faces]])
    numbered(item)
    before = {tuple(sorted(row)) for row in corners(item.data)}
    bpy.ops.isomend.repair()
    mesh = item.data
    assert not mesh.validate(verbose=True) and len(mesh.vertices) < len(both)
    same = [row for row in corners(mesh) if tuple(sorted(row)) in before]
    assert len(same) > 0.5 * len(before), "faces that touch no defect stay quadrilaterals with their coordinates"
    import isomend

    assert isomend.check(shapes.positions(mesh).astype(float), shapes.triangles_of(mesh)).sound


def test_lines_and_points_beside_the_surface_stay(bpy, scene):
    vertices, faces = shapes.globe(without=shapes.window())
    item = shapes.added(bpy, [*vertices, (3, 0, 0), (4, 0, 0), (5, 0, 0)], faces)
    mesh, count = item.data, len(vertices)
    mesh.edges.add(1)
    mesh.edges[-1].vertices = (count, count + 1)
    choose(item, lambda centre: centre.z > 0.9)
    bpy.ops.isomend.restore()
    places = {tuple(v.co) for v in mesh.vertices}
    assert {(3, 0, 0), (4, 0, 0), (5, 0, 0)} <= places
    ends = [{mesh.vertices[v].co.x for v in e.vertices} for e in mesh.edges]
    assert {3, 4} in ends and not mesh.validate(verbose=True)


@pytest.mark.parametrize("operator", ["fill", "repair"])
def test_a_patch_that_blender_cannot_hold_leaves_the_mesh_as_it_was(bpy, scene, operator):
    """The only patch that closes a single triangle is a triangle with the same vertices."""
    item = shapes.added(bpy, [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    numbered(item)
    before, chosen = corners(item.data), {"scope": "SELECTED"} if operator == "fill" else {"close_borders": True}
    item.data.edges.foreach_set("select", [True] * 3)
    try:
        done = getattr(bpy.ops.isomend, operator)(**chosen)
    except RuntimeError as error:
        assert str(error).startswith("Error: ")
        assert corners(item.data) == before and "isomend_patch" not in item.data.attributes
    else:
        assert done == {"FINISHED"} and not item.data.validate(verbose=True)


def test_a_result_with_duplicate_faces_is_refused_before_anything_is_written(bpy, scene, extension):
    item = shapes.added(bpy, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 2), (1, 3, 2)])
    numbered(item)
    before, taken = corners(item.data), extension.taken.Taken(item)
    numbers = {"point_data": {extension.taken.VERTEX: np.arange(4)}, "sigma": np.zeros(4)}
    # The second triangle is cut out; the patch has the vertices of the first.
    for patch, reason in (((2, 1, 0), "same vertices as another face"), ((1, 1, 3), "same vertex at two corners")):
        mended = SimpleNamespace(
            vertices=taken.vertices, faces=np.array([(0, 1, 2), patch]), is_patch=np.array([False, True]),
            cell_data={extension.taken.TRIANGLE: np.array([0, 0])}, **numbers,
        )  # fmt: skip
        with pytest.raises(extension.given_back.NotGivenBack, match=reason):
            extension.given_back.give_back(item, taken, mended)
        assert corners(item.data) == before and len(item.data.vertices) == 4


def test_marks_of_earlier_patches_stay_when_their_faces_are_added_again(bpy, scene):
    vertices, faces = shapes.globe()
    count = len(vertices)
    both = np.concatenate([vertices, vertices + np.float32([0.9, 0.2, 0.1])])
    item = shapes.added(bpy, both, [*faces, *[tuple(count + v for v in f) for f in faces]])
    mesh = item.data
    # The first body is marked as a patch of an earlier run; where the second body cuts it, parts of its faces are added again.
    marks = np.arange(2 * len(faces)) < len(faces)
    mesh.attributes.new("isomend_patch", "BOOLEAN", "FACE").data.foreach_set("value", marks)
    errors = np.where(np.arange(len(both)) < count, 0.5, 0.25).astype(np.float32)
    mesh.attributes.new("isomend_sigma", "FLOAT", "POINT").data.foreach_set("value", errors)
    item.vertex_groups.new(name="isomend patch").add(list(range(count)), 1.0, "REPLACE")
    numbered(item)
    bpy.ops.isomend.repair()
    numbers = shapes.values(mesh, "number", "value")[:, 0].astype(int)
    assert (np.diff(numbers) <= 0).any(), "faces were added again"
    patch = shapes.values(mesh, "isomend_patch", "value")[:, 0] == 1
    assert np.array_equal(patch, numbers <= len(faces))
    sigma = shapes.values(mesh, "isomend_sigma", "value")[:, 0]
    assert set(sigma.tolist()) == {0.5, 0.25}
    group = item.vertex_groups["isomend patch"].index
    assert [any(g.group == group for g in v.groups) for v in mesh.vertices] == (sigma == 0.5).tolist()


@pytest.mark.parametrize("flat", ["none", "one", "all"])
@pytest.mark.parametrize("operator", ["fill", "restore", "fair", "repair"])
def test_new_faces_are_as_smooth_as_the_faces_at_their_rim(bpy, scene, operator, flat):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    choose(item, lambda centre: centre.z < -0.9)
    count = len(item.data.polygons)
    if flat != "all":
        bpy.ops.object.shade_smooth()
    if flat == "one":
        item.data.polygons[0].use_smooth = False
    assert getattr(bpy.ops.isomend, operator)() == {"FINISHED"}
    smooth = [polygon.use_smooth for polygon in item.data.polygons]
    assert len(smooth) != count and smooth.count(False) == {"none": 0, "one": 1, "all": len(smooth)}[flat]
