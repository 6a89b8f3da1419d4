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


def flap():
    """A ball with a hole, and a face that stands on one of its edges: around this face goes a boundary that does not close."""
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=3)
    return np.vstack([vertices, [[0.5, 0.1, -1.5]]]), np.vstack([faces, [[1, 2, len(vertices)]]])


def one_sided():
    """A Moebius strip."""
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rows = [(np.cos(a / 2), np.cos(a), np.sin(a), np.sin(a / 2), side) for a in turns for side in (-0.3, 0.3)]
    vertices = [((1 + s * half) * x, (1 + s * half) * y, s * z) for half, x, y, z, s in rows]
    after = [(2 * i + 2, 2 * i + 3) for i in range(23)] + [(1, 0)]
    return vertices, [face for i, (c, d) in enumerate(after) for face in ((2 * i, c, 2 * i + 1), (2 * i + 1, c, d))]


def test_a_boundary_chain_that_does_not_close_is_said_with_its_place(caplog):
    said = "a boundary chain of 2 edges does not close, from 0.2588, 0, -0.9659 to 0.25, 0.067, -0.9659: it ends where an edge has more than "
    said += "two faces; isomend.repair separates the surfaces there, then fills; its debris=0.01 removes loose faces"
    with caplog.at_level(logging.INFO, logger="isomend"):
        filled = isomend.fill(*flap())
    assert not filled.complete and filled.report["outcomes"]["open"] == 0 and len(filled.report["open_chains"]) == 1
    assert levels(caplog) == [(logging.WARNING, said)]
    with pytest.raises(isomend.StrictError) as error:
        isomend.fill(*flap(), strict=True)
    assert str(error.value) == f"{said}; the result is in `result`" and pickle.loads(pickle.dumps(error.value)).args == error.value.args
    # A fill of named holes leaves the chain out of account.
    caplog.clear()
    named = isomend.fill(*flap(), holes=[1], strict=True)
    assert named.complete and not levels(caplog)
    repaired = isomend.repair(*flap(), debris=0.01)
    assert repaired.complete and repaired.check()
    caplog.clear()
    with caplog.at_level(logging.INFO, logger="isomend"):
        strip = isomend.fill(*one_sided())
    assert not strip.complete and len(levels(caplog)) == len(strip.report["open_chains"]) == 2
    assert all("one-sided" in text and text.endswith("; it bounds no hole and cannot be filled") for _, text in levels(caplog))


def test_of_many_boundary_chains_the_number_is_said(caplog):
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=3)
    ends = [(*(1.5 * vertices[1 + i]),) for i in range(24)]
    flaps = [[ring + i, ring + 1 + i, len(vertices) + i] for ring in (25, 73) for i in range(0, 23, 2)]
    filled = isomend.fill(np.vstack([vertices, ends]), np.vstack([faces, flaps]))
    chains, texts = len(filled.report["open_chains"]), [text for _, text in levels(caplog)]
    assert chains == 24 and texts[-1] == f"{chains - len(texts) + 1} more boundary chains do not close"


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
