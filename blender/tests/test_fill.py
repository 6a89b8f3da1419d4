"""Filling: same positions as the command line, the mesh's own elements unchanged, values continued, refusals."""

import time

import numpy as np
import pytest
import shapes
from conftest import ROOT


def filled_by_program(program, tmp_path, item, *options):
    """The vertices of the command line's result for the same mesh."""
    import isomend

    shapes.write_ply(tmp_path / "in.ply", shapes.positions(item.data), shapes.triangles_of(item.data))
    program("fill", tmp_path / "in.ply", "-o", tmp_path / "out.ply", "-q", *options)
    out = isomend.read(str(tmp_path / "out.ply"))
    return out.vertices.astype(np.float32), out.faces


def dressed(bpy, item):
    """UV maps, colours, materials, sharp and seam edges, weights and attributes of all kinds on a mesh."""
    mesh, rng = item.data, np.random.default_rng(7)
    for name in ("UVMap", "second"):
        uv = mesh.uv_layers.new(name=name)
        uv.data.foreach_set("uv", rng.random(2 * len(mesh.loops)).astype(np.float32))
    for name, kind, domain in (
        ("float", "FLOAT", "POINT"), ("whole", "INT", "POINT"), ("flag", "BOOLEAN", "POINT"), ("vector", "FLOAT_VECTOR", "POINT"),
        ("paint", "BYTE_COLOR", "CORNER"), ("light", "FLOAT_COLOR", "POINT"), ("region", "INT", "FACE"), ("load", "FLOAT", "EDGE"),
    ):  # fmt: skip
        attribute = mesh.attributes.new(name, kind, domain)
        prop, components = {"FLOAT_VECTOR": ("vector", 3), "BYTE_COLOR": ("color_srgb", 4), "FLOAT_COLOR": ("color", 4)}.get(kind, ("value", 1))
        some = rng.integers(0, 2 if kind == "BOOLEAN" else 100, components * len(attribute.data)) / (1 if kind in ("INT", "BOOLEAN") else 100)
        attribute.data.foreach_set(prop, some.astype({"INT": np.int32, "BOOLEAN": bool}.get(kind, np.float32)))
    for name in ("red", "blue"):
        mesh.materials.append(bpy.data.materials.new(name))
    half = [int(p.center.z > 0) for p in mesh.polygons]
    mesh.polygons.foreach_set("material_index", half)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.edges[5].use_seam = mesh.edges[9].use_edge_sharp = True
    item.vertex_groups.new(name="bone").add(range(0, len(mesh.vertices), 3), 0.25, "REPLACE")
    item.modifiers.new("Subdivision", "SUBSURF")
    return {a.name: a.domain for a in mesh.attributes if not a.name.startswith(".")}


def test_same_positions_as_the_command_line_and_nothing_else_changed(bpy, scene, program, tmp_path):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    before = dressed(bpy, item)
    old = item.data.copy()
    expected, faces = filled_by_program(program, tmp_path, item)
    assert bpy.ops.isomend.fill() == {"FINISHED"}

    mesh, count = item.data, len(old.vertices)
    assert np.array_equal(shapes.positions(mesh), expected)
    new = faces[len(shapes.triangles_of(old)) :]
    assert shapes.polygons(mesh)[: len(old.polygons)] == shapes.polygons(old)
    assert np.array_equal(np.array(shapes.polygons(mesh)[len(old.polygons) :]), new)
    assert not mesh.validate(verbose=True) and shapes.is_closed(mesh)

    kinds = {"FLOAT_VECTOR": ("vector", 3), "FLOAT2": ("vector", 2), "BYTE_COLOR": ("color_srgb", 4), "FLOAT_COLOR": ("color", 4)}
    for name in before:
        prop, components = kinds.get(old.attributes[name].data_type, ("value", 1))
        was, now = (shapes.values(m, name, prop, components) for m in (old, mesh))
        assert np.array_equal(was, now[: len(was)]), name
    assert [m.name for m in mesh.materials] == ["red", "blue"]
    assert [m.name for m in item.modifiers] == ["Subdivision"]
    assert mesh.edges[5].use_seam and mesh.edges[9].use_edge_sharp
    assert [tuple(e.vertices) for e in mesh.edges][: len(old.edges)] == [tuple(e.vertices) for e in old.edges]
    weights = [next((g.weight for g in v.groups if g.group == 0), 0) for v in mesh.vertices]
    assert weights[:count] == [0.25 if i % 3 == 0 else 0 for i in range(count)]
    assert 0 < max(weights[count:]) < 0.25, "weights are continued on the patch"


def test_an_island_in_a_hole_is_joined_as_by_the_command_line(bpy, scene, program, tmp_path):
    import isomend

    scan = isomend.read(str(ROOT / "data/scan.ply"))
    item = shapes.added(bpy, scan.vertices, scan.faces)
    expected, _ = filled_by_program(program, tmp_path, item)
    bpy.ops.isomend.fill(scope="ALL")
    assert np.array_equal(shapes.positions(item.data), expected) and shapes.is_closed(item.data)


def test_patches_are_marked_and_values_continued(bpy, scene):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    mesh = item.data
    height = mesh.attributes.new("height", "FLOAT", "POINT")
    height.data.foreach_set("value", shapes.positions(mesh)[:, 2].copy())
    uv = mesh.uv_layers.new(name="UVMap")
    corners = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops], np.float32)
    uv.data.foreach_set("uv", corners.ravel())
    mesh.materials.append(bpy.data.materials.new("a"))
    mesh.materials.append(bpy.data.materials.new("b"))
    mesh.polygons.foreach_set("material_index", [1] * len(mesh.polygons))
    vertices, faces = len(mesh.vertices), len(mesh.polygons)
    bpy.ops.isomend.fill()

    new = np.arange(len(mesh.polygons)) >= faces
    assert np.array_equal(shapes.values(mesh, "isomend_patch", "value")[:, 0] == 1, new)
    sigma = shapes.values(mesh, "isomend_sigma", "value")[:, 0]
    assert np.all(sigma[:vertices] == 0) and np.all(sigma[vertices:] != 0) and 0 < sigma.max() < 0.02
    group = item.vertex_groups["isomend patch"].index
    marked = {v.index for v in mesh.vertices if any(g.group == group for g in v.groups)}
    assert marked == {v for p in mesh.polygons if new[p.index] for v in p.vertices}
    assert [p.select for p in mesh.polygons] == new.tolist(), "the patch is selected"

    z = shapes.positions(mesh)[vertices:, 2]
    assert abs(shapes.values(mesh, "height", "value")[vertices:, 0] - z).max() < 0.02
    loops = [n for p in mesh.polygons if new[p.index] for n in p.loop_indices]
    place = np.array([mesh.vertices[mesh.loops[n].vertex_index].co[:2] for n in loops])
    values = np.array([mesh.uv_layers["UVMap"].data[n].uv for n in loops])
    assert abs(values - place).max() < 0.05, "texture coordinates are continued"
    assert {p.material_index for p in mesh.polygons if new[p.index]} == {1}


def test_marks_of_a_first_fill_stay_through_edit_mode_and_a_second_fill(bpy, scene):
    small, large = shapes.window(range(14, 16), range(30, 32)), shapes.window()
    item = shapes.added(bpy, *shapes.globe(without=small | large))
    mesh, faces, count = item.data, len(item.data.polygons), len(item.data.vertices)
    for index in (1, 0):
        bpy.ops.isomend.find_holes()
        bpy.ops.isomend.select_hole(index=index)
        assert bpy.ops.isomend.fill(scope="SELECTED") == {"FINISHED"}
        errors = shapes.values(mesh, "isomend_sigma", "value")
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(shapes.values(mesh, "isomend_patch", "value")[:, 0] == 1, np.arange(len(mesh.polygons)) >= faces)
    assert np.array_equal(shapes.values(mesh, "isomend_sigma", "value"), errors) and np.all(errors[count:] != 0)
    assert not any("." in a.name[1:] for a in mesh.attributes), "no attribute was made anew under another name"


def test_selected_holes_and_sizes(bpy, scene):
    small, large = shapes.window(range(14, 16), range(30, 32)), shapes.window()
    item = shapes.added(bpy, *shapes.globe(without=small | large))
    assert bpy.ops.isomend.find_holes() == {"FINISHED"}
    found = scene.isomend.holes
    assert [hole.number for hole in found] == [1, 2] and found[0].diameter > found[1].diameter > 0.1
    between = (found[0].diameter + found[1].diameter) / 2

    bpy.ops.isomend.select_hole(index=1)
    assert sum(edge.select for edge in item.data.edges) == found[1].edges
    assert bpy.ops.isomend.fill(scope="SELECTED") == {"FINISHED"}
    assert bpy.ops.isomend.find_holes() == {"FINISHED"} and len(scene.isomend.holes) == 1
    with pytest.raises(RuntimeError, match="No hole is selected"):
        item.data.polygons.foreach_set("select", [False] * len(item.data.polygons))
        item.data.edges.foreach_set("select", [False] * len(item.data.edges))
        item.data.vertices.foreach_set("select", [False] * len(item.data.vertices))
        bpy.ops.isomend.fill(scope="SELECTED")
    with pytest.raises(RuntimeError, match="are wider than the largest diameter"):
        bpy.ops.isomend.fill(max_diameter=between)
    assert bpy.ops.isomend.fill(max_diameter=2 * between) == {"FINISHED"} and shapes.is_closed(item.data)


def test_a_bridge_joins_selected_holes_as_by_the_command_line(bpy, scene, program, tmp_path):
    near = shapes.window(range(8, 12), range(5, 10)) | shapes.window(range(8, 12), range(12, 17))
    item = shapes.added(bpy, *shapes.globe(without=near))
    expected, faces = filled_by_program(program, tmp_path, item, "--bridge", "1+2")
    apart, _ = filled_by_program(program, tmp_path, item)
    assert not np.array_equal(apart, expected)
    with pytest.raises(RuntimeError, match="joins two or more selected holes"):
        bpy.ops.isomend.fill(scope="ALL", bridge=True)
    bpy.ops.isomend.find_holes()
    bpy.ops.isomend.select_hole(index=0)
    with pytest.raises(RuntimeError, match="joins two or more selected holes"):
        bpy.ops.isomend.fill(scope="SELECTED", bridge=True)
    bpy.ops.isomend.select_hole(index=1, extend=True)
    assert bpy.ops.isomend.fill(scope="SELECTED", bridge=True) == {"FINISHED"}
    assert np.array_equal(shapes.positions(item.data), expected) and np.array_equal(shapes.triangles_of(item.data)[-1], faces[-1])


def eared_globe():
    """A globe with an ear at each end of its X axis, the one at +X missing; and the same globe complete."""
    vertices, faces = shapes.globe(48, 96)
    ear = 0.25 * np.exp((abs(vertices[:, :1]) - 1) / 0.01)
    vertices = (vertices * (1 + ear)).astype(np.float32)
    missing = [vertices[list(face)].mean(axis=0)[0] > 0.97 for face in faces]
    return vertices, [face for face, gone in zip(faces, missing) if not gone]


@pytest.mark.parametrize(("mirror", "like"), [("x", "mirror:0,0,0,1,0,0"), ("search", "mirror")])
def test_the_other_side_is_mirrored_as_by_the_command_line(bpy, scene, program, tmp_path, capfd, mirror, like):
    vertices, faces = eared_globe()
    item = shapes.added(bpy, vertices, faces)
    count = len(vertices)
    expected, _ = filled_by_program(program, tmp_path, item, "--like", like)
    assert bpy.ops.isomend.fill(mirror=mirror) == {"FINISHED"}
    assert "1 with the mirrored shape" in capfd.readouterr().out
    assert np.array_equal(shapes.positions(item.data), expected) and shapes.is_closed(item.data)
    assert shapes.positions(item.data)[count:, 0].max() > 1.2, "the ear is back"
    plain = shapes.added(bpy, vertices, faces)
    bpy.ops.isomend.fill()
    assert shapes.positions(plain.data)[count:, 0].max() < 1.1


def test_the_mirror_plane_follows_the_axes_of_a_scaled_object(bpy, scene):
    vertices, faces = eared_globe()
    stretch = np.array([1, 1.5, 2], np.float32)
    item = shapes.added(bpy, vertices / stretch, faces)
    item.scale, item.rotation_euler, item.location = stretch, (0.3, 0.2, 0.1), (5, 6, 7)
    bpy.context.view_layer.update()
    assert bpy.ops.isomend.fill(mirror="x") == {"FINISHED"}
    assert shapes.positions(item.data)[:, 0].max() > 1.2, "the ear is back"


def test_edit_mode_and_undo(bpy, scene):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    faces = len(item.data.polygons)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.isomend.fill(scope="SELECTED") == {"FINISHED"}
    assert bpy.context.object.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(bpy.context.object.data.polygons) > faces and shapes.is_closed(bpy.context.object.data)
    assert "UNDO" in bpy.types.ISOMEND_OT_fill.bl_options


def test_units_and_scales_of_objects(bpy, scene):
    plain = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    bpy.ops.isomend.fill()
    count = len(plain.data.vertices)
    # A mesh twice as large, in an object scaled by half, is the same shape in the scene: the same patch, errors and limits.
    vertices, faces = shapes.globe(without=shapes.window())
    item = shapes.added(bpy, 2 * vertices, faces)
    item.scale = (0.5, 0.5, 0.5)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="are wider than the largest diameter"):
        bpy.ops.isomend.fill(max_diameter=0.5)
    assert bpy.ops.isomend.fill(max_diameter=2) == {"FINISHED"}
    assert len(item.data.vertices) == count
    assert np.allclose(shapes.positions(item.data), 2 * shapes.positions(plain.data), atol=1e-6)
    a, b = (shapes.values(m.data, "isomend_sigma", "value") for m in (plain, item))
    assert np.allclose(a, b, rtol=1e-3)
    # Scaled unequally: the object is a ball in the scene, though its mesh is not.
    item = shapes.added(bpy, vertices / np.array([1, 2, 4], np.float32), faces)
    item.scale, item.rotation_euler = (1, 2, 4), (0.3, 0.2, 0.1)
    bpy.context.view_layer.update()
    bpy.ops.isomend.fill()
    radii = np.linalg.norm(shapes.positions(item.data) * [1, 2, 4], axis=1)
    assert abs(radii - 1).max() < 0.01


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda item: item.shape_key_add(name="Basis"), "has shape keys"),
        (lambda item: item.modifiers.new("M", "MULTIRES"), "keeps displacements for each face"),
        (lambda item: item.modifiers.new("M", "MIRROR"), "closes the border in its mirror plane"),
        (lambda item: item.modifiers.new("M", "CLOTH"), "has a simulation of the vertices"),
    ],
)
def test_what_would_break_is_refused_with_the_reason(bpy, scene, change, reason):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    change(item)
    count = len(item.data.polygons)
    for operator in (bpy.ops.isomend.fill, bpy.ops.isomend.restore, bpy.ops.isomend.fair, bpy.ops.isomend.repair):
        with pytest.raises(RuntimeError, match=reason):
            operator()
    assert len(item.data.polygons) == count


def test_modifiers_that_keep_their_meaning_are_no_reason(bpy, scene):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    for kind in ("SUBSURF", "SMOOTH", "ARMATURE", "CORRECTIVE_SMOOTH"):
        item.modifiers.new(kind, kind)
    item.modifiers.new("off", "MIRROR").show_viewport = False
    assert bpy.ops.isomend.fill() == {"FINISHED"} and len(item.modifiers) == 5


def test_large_meshes_take_little_more_than_the_fill(bpy, scene, capsys):
    """200 000 faces with 49 holes: less than 5 seconds in addition to the fill itself."""
    import isomend

    item = shapes.plane_with_holes(bpy, 455, 7)
    item.data.uv_layers.new(name="UVMap")
    vertices, triangles = shapes.positions(item.data).astype(float), shapes.triangles_of(item.data)
    assert len(item.data.polygons) > 200_000
    start = time.perf_counter()
    alone = isomend.Model(vertices, triangles).inspect()
    alone = alone.fill(holes=[hole.id for hole in alone.holes if not hole.is_outer_boundary])
    between = time.perf_counter()
    assert bpy.ops.isomend.fill() == {"FINISHED"}
    end = time.perf_counter()
    with capsys.disabled():
        print(f"\n200 000 faces: the fill {between - start:.1f} s, the operator {end - between:.1f} s")
    assert end - between < between - start + 5
    assert np.array_equal(shapes.positions(item.data), alone.vertices.astype(np.float32))
