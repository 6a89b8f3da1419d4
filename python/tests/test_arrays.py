"""Fills, restorations and fairings of meshes given as arrays."""

import json
import subprocess

import numpy as np
import pytest
import shapes

import isomend


def test_a_fill_keeps_the_input_and_continues_the_sphere(sphere, filled):
    vertices, faces = sphere
    assert filled.vertices.dtype == np.float64 and filled.faces.dtype == np.int64
    assert filled.vertices[: len(vertices)].tobytes() == vertices.tobytes()
    assert np.array_equal(filled.faces[: len(faces)], faces)
    assert shapes.is_closed(filled.faces)
    new = filled.vertices[len(vertices) :]
    assert len(new) > 50 and np.abs(np.linalg.norm(new, axis=1) - 1).max() < 0.01
    assert np.array_equal(filled.is_patch, np.arange(len(filled.faces)) >= len(faces))
    assert filled.complete and filled.flawless
    assert filled.report["command"] == "fill" and filled.report["outcomes"]["closed"] == 1
    assert filled.report["input"] == {"vertices": len(vertices), "faces": len(faces)}
    assert len(filled.sigma) == len(filled.vertices) and not filled.sigma[: len(vertices)].any()
    assert np.nanmax(filled.sigma) > 0


def test_a_fill_writes_the_bytes_of_the_command_line(tmp_path, sphere, filled, program):
    """As OBJ, which holds 64-bit floats exactly."""
    isomend.Model(*sphere).write(tmp_path / "in.obj")
    subprocess.run([program, "fill", "in.obj", "-o", "out.obj", "-q", "--json", "out.json"], cwd=tmp_path, check=True)
    filled.write(tmp_path / "own.obj")
    assert (tmp_path / "own.obj").read_bytes() == (tmp_path / "out.obj").read_bytes()
    theirs = json.loads((tmp_path / "out.json").read_text())
    timeless = lambda report: {k: v for k, v in report.items() if k not in ("input", "output", "seconds", "regions")}  # noqa: E731
    assert timeless(theirs) == timeless(filled.report)
    again = isomend.read(tmp_path / "out.obj")
    assert again.vertices.tobytes() == filled.vertices.tobytes()
    assert np.array_equal(again.faces, filled.faces)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble])
@pytest.mark.parametrize("index", [np.uint8, np.int16, np.uint32, np.int64, np.uint64, np.float64])
def test_arrays_of_any_number_type_are_accepted(dtype, index):
    vertices, faces = shapes.open_sphere(around=12, latitudes=8, top=2)
    vertices = vertices.astype(dtype)
    done = isomend.fill(vertices, faces.astype(index))
    assert done.vertices[: len(vertices)].tobytes() == vertices.astype(np.float64).tobytes()
    assert shapes.is_closed(done.faces)


def test_integer_arrays_views_and_lists_are_accepted():
    vertices, faces = shapes.open_sphere(around=12, latitudes=8, top=2)
    whole = np.round(vertices * 1000).astype(np.int32)
    reference = isomend.fill(whole.astype(float), faces)
    for given in (whole, whole.tolist(), np.asfortranarray(whole), np.repeat(whole, 2, axis=0)[::2], whole.astype(">f4")):
        done = isomend.fill(given, faces.tolist())
        assert done.vertices.tobytes() == reference.vertices.tobytes()


def test_one_inspection_is_used_for_several_fills():
    vertices, faces = shapes.open_ends()
    found = isomend.inspect(vertices, faces)
    assert [hole.edges for hole in found.holes] == [48, 48]
    upper, lower = found.holes
    assert upper.diameter > lower.diameter and upper.centre[2] > 0 > lower.centre[2]
    assert np.allclose(vertices[upper.rim, 2], upper.centre[2], atol=1e-9)
    assert not upper.is_outer_boundary and np.allclose(np.abs(upper.normal), (0, 0, 1), atol=1e-9)
    one, other, both = found.fill(holes=[1]), found.fill(keep_open=[1]), found.fill()
    assert [h["outcome"] for h in one.report["holes"]] == ["closed", "left"]
    assert [h["outcome"] for h in other.report["holes"]] == ["left", "closed"]
    assert shapes.is_closed(both.faces) and not shapes.is_closed(one.faces)
    assert both.vertices.tobytes() == isomend.fill(vertices, faces).vertices.tobytes()
    assert found.fill(max_diameter=lower.diameter * 1.01).report["outcomes"]["left"] == 1


def test_the_result_does_not_depend_on_the_threads(sphere, filled):
    for threads in (1, 3):
        assert isomend.fill(*sphere, threads=threads).vertices.tobytes() == filled.vertices.tobytes()


def test_parameters_of_the_library_are_keywords(sphere):
    done = isomend.fill(
        *sphere, holes=(1,), voxel=0.08, finish="none", energy="willmore", edge_ratio=1.5
    )
    report = done.report["regions"][0]
    assert report["voxel"] == 0.08 and report["finish"] is None
    plan = isomend.Model(*sphere).plan(voxel=0.08)
    assert plan["dry_run"] and plan["holes"][0]["outcome"] == "would_be_closed"


def test_a_bridge_joins_two_holes():
    vertices, faces = shapes.open_ends(around=24, latitudes=12, top=5)
    assert isomend.fill(vertices, faces, bridge=[(1, 2)]).report["regions"][0]["bridge"]


def test_an_edge_is_continued_between_two_ends():
    vertices, faces = shapes.open_cube()
    found = isomend.inspect(vertices, faces)
    first, second = found.crease_ends
    assert (first.id, second.id, first.hole, round(first.angle)) == (1, 2, 1, 90)
    assert tuple(vertices[first.vertex]) == first.position
    region = found.fill(crease=[(1, 2)]).report["regions"][0]
    assert region["closed_by"] == "sides" and region["crease_ends"] == 2 and region["not_continued"] is None
    with pytest.raises(isomend.ParameterError, match="crease"):
        found.fill(crease=[(1, 2, 3)])
    with pytest.raises(isomend.IsomendError, match="no crease end 3"):
        found.fill(crease=[(1, 3)])


def test_a_dent_is_restored():
    vertices, faces = shapes.closed_sphere()
    dented = vertices.copy()
    dented[vertices[:, 2] > 0.9] *= 0.9
    mark = (vertices[faces][:, :, 2] > 0.8).any(axis=1)
    done = isomend.restore(dented, faces, mark)
    assert shapes.is_closed(done.faces)
    assert done.kept_vertices is not None and done.kept_faces is not None
    kept = dented[done.kept_vertices]
    assert done.vertices[: len(kept)].tobytes() == kept.tobytes()
    assert np.abs(np.linalg.norm(done.vertices[len(kept) :], axis=1) - 1).max() < 0.01
    numbers = isomend.restore(dented, faces, np.flatnonzero(mark))
    assert numbers.vertices.tobytes() == done.vertices.tobytes()
    ball = isomend.restore(dented, faces, {"balls": [[[0, 0, 1], 0.7]]}, keep_shape=0.5)
    assert ball.report["keep_shape"] == 0.5 and ball.report["command"] == "restore"


def test_a_region_is_faired():
    vertices, faces = shapes.closed_sphere()
    rough = vertices * (1 + 0.01 * np.random.default_rng(1).standard_normal((len(vertices), 1)))
    mark = (vertices[faces][:, :, 2] > 0.5).all(axis=1)
    done = isomend.fair(rough, faces, mark, strength=0.4)
    assert done.report["command"] == "fair" and done.report["strength"] == pytest.approx(0.4)
    new = done.vertices[done.kept_vertices.sum() :]
    assert np.linalg.norm(new, axis=1).std() < 0.006


def test_signed_distances_to_a_ball_are_accurate():
    vertices, faces = shapes.closed_sphere()
    points = np.random.default_rng(2).uniform(-2, 2, (200, 3))
    truth = np.linalg.norm(points, axis=1) - 1
    assert np.abs(isomend.signed_distance(points, vertices, faces) - truth).max() < 0.01


def test_regions_can_be_solved_elsewhere():
    found = isomend.inspect(*shapes.open_ends())
    tasks = []
    found.each_task(tasks.append, voxel=0.08)
    assert len(tasks) == found.region_count() == 2
    patches = [isomend.solve_task(task, threads=1) for task in tasks]
    put_together = found.assemble(patches, voxel=0.08)
    assert put_together.vertices.tobytes() == found.fill(voxel=0.08).vertices.tobytes()
    with pytest.raises(isomend.ParameterError, match="2 regions, but patches of 1"):
        found.assemble(patches[:1], voxel=0.08)
    with pytest.raises(isomend.ParameterError, match="no task"):
        isomend.solve_task(b"nonsense")
    with pytest.raises(isomend.ParameterError, match="no patch"):
        isomend.is_cramped(b"nonsense")
    with pytest.raises(isomend.ParameterError, match="no region 2 of 2"):
        found.wide_task(2)
    assert not isomend.is_cramped(patches[0])
    wide = [isomend.solve_task(found.wide_task(region, voxel=0.08)) for region in range(2)]
    assert found.assemble(wide, voxel=0.08).vertices.tobytes() == put_together.vertices.tobytes()


def test_values_are_continued_on_patches(sphere):
    vertices, faces = sphere
    heat = vertices[:, 2].astype(np.float32)
    done = isomend.fill(
        vertices,
        faces,
        point_data={"heat": heat, "colors": np.full((len(vertices), 3), 200, np.uint8), "on": np.ones(len(vertices), bool)},
        cell_data={"scan": np.full(len(faces), 7, np.int16), "axis": np.ones((len(faces), 2, 2))},
    )
    assert done.point_data["heat"].dtype == np.float32
    assert done.point_data["heat"][: len(vertices)].tobytes() == heat.tobytes()
    new = done.point_data["heat"][len(vertices) :]
    assert np.isfinite(new).all() and new.min() > 0.7
    assert (done.point_data["colors"] == 200).all() and done.point_data["colors"].dtype == np.uint8
    assert done.point_data["on"].dtype == bool
    assert done.cell_data["scan"].dtype == np.int16 and (done.cell_data["scan"][: len(faces)] == 7).all()
    assert done.cell_data["axis"].shape == (len(done.faces), 2, 2)


def test_a_result_can_be_filled_again():
    first = isomend.fill(*shapes.open_ends(), holes=[1])
    second = first.model().fill()
    assert shapes.is_closed(second.faces)
    assert second.vertices[: len(first.vertices)].tobytes() == first.vertices.tobytes()


def test_integers_of_0_and_1_are_refused_as_a_mask(sphere):
    vertices, faces = shapes.closed_sphere()
    mark = vertices[faces].mean(axis=1)[:, 2] > 0.9
    for wrong in (mark.astype(np.uint8), mark.astype(int), np.zeros(len(faces), int)):
        with pytest.raises(isomend.ParameterError, match="bool"):
            isomend.restore(vertices, faces, wrong)
    with pytest.raises(isomend.ParameterError, match="masked"):
        isomend.restore(vertices, faces, np.ma.array(mark, mask=mark))
    by_marks = isomend.restore(vertices, faces, mark)
    by_numbers = isomend.restore(vertices, faces, np.flatnonzero(mark))
    assert by_marks.faces.tobytes() == by_numbers.faces.tobytes()
    # Further faces are removed to get a manifold rim.
    assert by_marks.report["removed_faces"] >= mark.sum()


def test_results_can_be_pickled_and_unpacked(sphere, filled):
    import pickle

    vertices, faces = filled
    assert np.array_equal(vertices, filled.vertices) and np.array_equal(faces, filled.faces)
    sent = pickle.loads(pickle.dumps(filled))
    assert sent.vertices.tobytes() == filled.vertices.tobytes() and sent.report == filled.report
    assert sent.complete and np.array_equal(sent.is_patch, filled.is_patch)
    assert sent.to_bytes("ply") and len(sent.model().faces) == len(filled.faces)
    error = pickle.loads(pickle.dumps(isomend.StrictError("not flawless", filled)))
    assert str(error) == "not flawless" and len(error.result.faces) == len(filled.faces)
