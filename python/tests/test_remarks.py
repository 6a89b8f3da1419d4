"""What results say: counts of holes, holes left open, patches that need attention; in the text, the notes and the log."""

import logging
import pickle

import numpy as np
import pytest
import shapes

import isomend


def levels(caplog):
    """The level and the text of each message of the library, without details."""
    return [(record.levelno, record.getMessage()) for record in caplog.records if record.levelno >= logging.INFO]


def half_ball():
    """The lower half of a ball: its patch continues the ball far above the rim."""
    return shapes.open_sphere(around=64, latitudes=32, top=16)


def sheet():
    """A wavy sheet of 12 x 12 squares with a hole in the middle: its outer border is hole 1."""
    at = {place: number for number, place in enumerate(np.ndindex(13, 13))}
    vertices = np.array([(i, j, 0.3 * np.sin(i)) for i, j in at])
    squares = [(i, j) for i, j in np.ndindex(12, 12) if not (5 <= i < 7 and 5 <= j < 7)]
    corners = [[at[place] for place in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))] for i, j in squares]
    return vertices, np.array([face for a, b, c, d in corners for face in ((a, b, c), (a, c, d))])


def test_holes_that_are_left_are_counted_and_logged(caplog):
    vertices, faces = shapes.open_ends()
    with caplog.at_level(logging.INFO, logger="isomend"):
        filled = isomend.fill(vertices, faces, holes=[1])
    assert filled.complete and repr(filled).endswith(": 1 hole closed, 1 left open>")
    assert levels(caplog) == [(logging.INFO, "hole 2 left open: not asked for")]
    assert "hole 2 left open: not asked for" in str(filled) and filled.notes == []
    assert str(filled).splitlines()[-1].startswith("1 of 2 holes closed (1 by the level set), 1 left open")
    small = min(hole.diameter for hole in isomend.inspect(vertices, faces).holes)
    bounded = isomend.fill(vertices, faces, max_diameter=1.01 * small)
    assert repr(bounded).endswith(": 1 hole closed, 1 left open>")
    assert "hole 1 left open: wider than the largest diameter asked for; a larger max_diameter fills it" in str(bounded)


def test_an_outer_border_that_stays_open_without_being_asked_is_a_warning(caplog):
    said = "hole 1 left open: the outer border of an open sheet, which is filled only when it is named: holes=[1]"
    with caplog.at_level(logging.INFO, logger="isomend"):
        filled = isomend.fill(*sheet())
    assert repr(filled).endswith(": 1 hole closed, 1 left open>") and levels(caplog) == [(logging.WARNING, said)]
    assert said in str(filled)
    caplog.clear()
    with caplog.at_level(logging.INFO, logger="isomend"):
        isomend.fill(*sheet(), keep_open=[1])
        isomend.fill(*sheet(), holes=[2])
    assert [level for level, _ in levels(caplog)] == [logging.INFO, logging.INFO]
    repaired = isomend.repair(*sheet())
    assert "left open: the outer border of an open sheet, which is filled only when it is named; close_borders=True" in str(repaired)
    assert repr(repaired).endswith(": 1 hole closed, 1 left open; not sound>")


def test_a_patch_that_bulges_is_a_remark(caplog):
    said = "hole 1: the patch rises far above the rim; check its shape; flat=[1] makes a flat cap instead"
    vertices, faces = half_ball()
    with caplog.at_level(logging.INFO, logger="isomend"):
        filled = isomend.fill(vertices, faces)
    assert filled.flawless and filled.notes == [said] and levels(caplog) == [(logging.WARNING, said)]
    assert said in str(filled).splitlines() and pickle.loads(pickle.dumps(filled)).notes == [said]
    caplog.clear()
    flat = isomend.fill(vertices, faces, flat=[1])
    assert flat.notes == [] and not levels(caplog) and "flat" not in repr(flat)


def test_the_text_of_each_work_ends_with_its_outcome():
    vertices, faces = shapes.closed_sphere()
    restored = str(isomend.restore(vertices, faces, {"balls": [[0, 0, 1, 0.4]]})).splitlines()
    assert restored[0].endswith(" cut out") and restored[-1].startswith("the hole is closed")
    faired = isomend.fair(vertices, faces, {"balls": [[0, 0, 1, 0.4]]}, strength=0.3)
    assert str(faired).startswith("features narrower than 0.3") and str(faired).splitlines()[-1].startswith("moved by at most ")
    assert repr(faired).endswith("faired>")
    repaired = isomend.repair(*shapes.open_sphere())
    assert str(repaired).splitlines()[-1] == "watertight and printable: yes" and repr(repaired).endswith("1 hole closed; sound>")
    assert repr(isomend.fill(vertices, faces)).endswith("0 of them new: no holes>")


def test_a_result_is_checked_as_a_model_is(filled):
    assert filled.check(thin=0.01).report == filled.model().check(thin=0.01).report
    with pytest.raises(isomend.ParameterError, match="check has no parameter 'thinner'"):
        filled.check(thinner=1)


def test_kinds_of_defects_that_are_not_found_count_none():
    verdict = isomend.check(*shapes.closed_sphere())
    assert verdict and verdict.defects == {} and "boundary_edge" not in verdict.defects
    none = verdict.defects["boundary_edge"]
    assert none.count == 0 and none.faces.shape == (0,) and none.places.shape == (0, 3) and verdict.defects == {}
    with pytest.raises(KeyError, match="there is no kind of defect 'hole'; there are boundary_edge, "):
        verdict.defects["hole"]


def test_volumes_and_distances_take_meshes_as_other_functions_do(tmp_path):
    vertices, faces = shapes.closed_sphere()
    model = isomend.Model(vertices, faces)
    model.write(tmp_path / "ball.ply")
    wanted = isomend.sdf(vertices, faces, voxel=0.2).values
    for mesh in (model, (vertices, faces), tmp_path / "ball.ply"):
        assert isomend.sdf(mesh, voxel=0.2).values.tobytes() == wanted.tobytes()
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 3.0]])
    at = isomend.signed_distance(points, vertices, faces)
    for mesh in (model, (vertices, faces), tmp_path / "ball.ply"):
        assert isomend.signed_distance(points, mesh).tobytes() == at.tobytes()
