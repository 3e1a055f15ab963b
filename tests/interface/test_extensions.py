"""Verify that additions of one file outside the packages are reported."""

import csv
import importlib.util
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from fem import (
    COLUMNS,
    CONSTRAINTS,
    ELEMENT_KINDS,
    FRICTION_LAWS,
    IMPACT_COLUMNS,
    LUMPINGS,
    MATERIALS,
    START_KINDS,
    ElementKind,
)
from fem.explicit.time_loop import end_step
from fem.laws.friction import Drag
from fem.registry import Registry, digest_of_laws
from fem.start.inertia_relief import statics
from postprocess.report.command_report import write_report
from solver import REACTIONS
from tailslap.campaign.random_scenes import choices_of
from tailslap.case.corner import corner_case
from tailslap.case.corner.corner_checks import CHECKS
from tailslap.case.corner.corner_report import CornerReport
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.report import ImpactReport
from tailslap.case.impact.run import attempt
from tailslap.case.resources import loop_seconds
from tailslap.cli import _status
from tailslap.errors import InputError
from tailslap.result.columns import impact_columns
from tailslap.scene.read import read_scene

FOLDER = Path(__file__).parents[1] / "extensions"
ADDED: dict[str, tuple[Registry[Any], str]] = {
    "smoothed_friction": (FRICTION_LAWS, "smoothed"), "cubic_constraint": (CONSTRAINTS, "cubic"),
    "hardening_material": (MATERIALS, "hardening"), "serendipity_element": (ELEMENT_KINDS, "quad8"),
    "diagonal_lumping": (LUMPINGS, "diagonal"), "pressed_start": (START_KINDS, "pressed"),
    "height_column": (COLUMNS, "height"), "rise_check": (CHECKS, "rise"),
    "speed_column": (IMPACT_COLUMNS, "speed"),
}  # fmt: skip
"""File, with the registry and name of its object."""

SCENE = ("corner.reaction=smoothed", "corner.constraint=cubic", "material.law=hardening")
PLATE = (
    "plate.element=quad8", "plate.lumping=diagonal", "plate.start=pressed", "plate.elements=[10,3]",
    "verify.companion=false",
)  # fmt: skip


def load(name):
    """Import a file as a module, as a script does."""
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    sys.modules[name] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def registered():
    for name in ADDED:
        load(name)
    yield
    for registry, name in ADDED.values():
        registry.pop(name)


@pytest.fixture(scope="module")
def result(registered):
    return corner_case.CornerCase(*read_scene("paper-table-3", SCENE)).run()


@pytest.fixture(scope="module")
def plate_result(registered):
    """Of what may be added to the plate alone."""
    return corner_case.CornerCase(*read_scene("paper-table-3", PLATE)).run()


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    place = tmp_path_factory.mktemp("results")
    write_report(CornerReport(result).composed(pictures=False), place)
    return place


def test_a_whole_impact_has_its_column(registered):
    """Its first value is the speed of the vehicle, with the unit."""
    case = ImpactCase(*read_scene("impact-mash-tl4-sut", ("plate.elements=[8,2]", "time.end=50 ms")))
    history = ImpactReport(attempt(case)).histories["history.csv"]
    assert history["speed"][0] == pytest.approx(np.hypot(case.touch.v_gx, case.touch.v_gy), rel=1e-14)
    assert impact_columns()["speed"].unit == "m/s"


def test_a_run_with_all_of_them_is_right(result):
    """Each of them has a small effect on the motion."""
    assert [check.name for check in result.checks if not check.passed] == []
    assert max(map(abs, result.difference.values())) < 1e-3


def test_the_loop_is_made_of_them(result):
    parameters = result.fe_plan.model.parameters
    parts = (parameters.friction, parameters.corner.constraint, parameters.material)
    kinds = [type(part).__name__ for part in parts]
    assert kinds == ["Smoothed", "Cubic", "Hardening"]
    history = result.run.history
    limit = 0.47 * np.sqrt(history["reaction_normal"] ** 2 + 1.0)
    np.testing.assert_allclose(np.abs(history["reaction_tangential"][:-1]), limit[:-1], rtol=1e-12)


def test_its_energies_are_in_the_ledger(result):
    history, constraint = result.run.history, result.fe_plan.model.parameters.corner.constraint
    gap = history["gap"][:-1]
    energy = 0.5 * constraint.stiffness * gap**2 * (1.0 + 0.5 * gap**2)
    np.testing.assert_allclose(history["contact_energy"][:-1], energy, rtol=1e-12)


def test_the_files_and_the_page_show_them(result, folder):
    with (folder / "history.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    recorded = [float(row["height"]) for row in rows]
    np.testing.assert_array_equal(recorded, result.run.history["height"])
    assert recorded[-1] == pytest.approx(result.run.strike.positions[1].mean(), rel=1e-12)
    summary = json.loads((folder / "summary.json").read_text())
    assert [check["passed"] for check in summary["checks"] if check["name"] == "rise"] == [True]
    page = (folder / "report.html").read_text()
    texts = ["smoothed Coulomb friction", "a spring that hardens", "a plate that hardens"]
    texts += ["largest rise of the plate", "Mean height of the nodes above the wall"]
    assert [text for text in texts if text not in page] == []


def test_an_element_a_lumping_and_a_start_make_a_run(plate_result, tmp_path):
    """The motion is rigid except the rotary inertia of this lumping."""
    model, fe_plan = plate_result.fe_plan.model, plate_result.fe_plan
    assert len(model.parameters.table.per_element) == 8
    assert model.mass == pytest.approx(53.0 * 7.8 * 24.38, rel=1e-12)
    assert max(map(abs, plate_result.difference.values())) < 0.02
    assert plate_result.run.history["gap"][0] == pytest.approx(statics(model, fe_plan.start).gap, rel=1e-6)
    write_report(CornerReport(plate_result).composed(pictures=False), tmp_path)
    page = (tmp_path / "report.html").read_text()
    texts = ["quad8", "unstrained, its corner pressed into the constraint"]
    texts += ["it is that of the scaled diagonal"]
    assert [text for text in texts if text not in page] == []


def test_cost_and_draw_weight_are_fields_of_an_element():
    """1000 steps of 30 cells of 1 us and draws by weight."""
    law = ("material.law=neo-hookean",)
    scenes = [read_scene("paper-table-3", (*law, f"plate.distortion={part}"))[0] for part in (0.0, 0.1)]
    cost = {"nanoseconds": 1000.0, "distorted": 3.0, "points": 2}
    kind = ElementKind("costly", "ElementQuadS2", 4, "quad", draw_weight=5000, **cost)
    with mock.patch.dict(ELEMENT_KINDS):
        ELEMENT_KINDS.register(kind)
        seconds = [loop_seconds(scene, kind.name, (10, 3), 1000.0) for scene in scenes]
        drawn = [choices_of(1, number, 0)["element"] for number in range(20)]
    stress = MATERIALS["neo-hookean"].nanoseconds
    expected = [1e-9 * 1000.0 * 30 * (cell + 2.0 * stress) for cell in (1000.0, 3000.0)]
    assert seconds == pytest.approx(expected, rel=1e-12)
    assert set(drawn) == {"open", kind.name}


def test_a_check_from_outside_can_fail(result):
    from tailslap.case.check import evaluated

    history = result.run.history | {"height": -result.run.history["height"]}
    checks = evaluated(CHECKS.values(), replace(result, run=replace(result.run, history=history)))
    failed = [check for check in checks if not check.passed]
    assert [(check.name, check.advice) for check in failed] == [("rise", "less of everything")]


def other_force(law: Any, normal: float, stopping: float) -> float:
    return stopping


def test_a_law_from_outside_belongs_to_the_code_of_its_loops_alone(registered):
    """All laws belong to the identity of checkpoints."""
    law = FRICTION_LAWS["smoothed"]

    def files():
        return [end_step.path(constants) for constants in (Drag(0.3), law.constants(0.3))]

    (drag, smoothed), laws = files(), digest_of_laws()
    with mock.patch.dict(FRICTION_LAWS, smoothed=replace(law, force=other_force)):
        assert files()[0] == drag
        assert files()[1] != smoothed
        assert digest_of_laws() != laws
    assert (files(), digest_of_laws()) == ([drag, smoothed], laws)


def force_as_list(law: Any, normal: float, stopping: float) -> Any:
    return [stopping]


def test_a_law_that_cannot_be_compiled_ends_a_command_with_its_line(registered, tmp_path, capsys):
    words = ["run", "paper-table-3", "--set", "corner.reaction=smoothed", "--out", str(tmp_path / "out")]
    with mock.patch.dict(FRICTION_LAWS, smoothed=replace(FRICTION_LAWS["smoothed"], force=force_as_list)):
        assert _status(words) == 2
    place = f"{__file__}:{force_as_list.__code__.co_firstlineno + 1}"
    assert f"tailslap: {place}: a kernel cannot have [stopping]\n" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ADDED)
def test_a_name_is_registered_once(registered, name):
    registry, key = ADDED[name]
    with pytest.raises(ValueError, match="is registered already"):
        registry.register(registry[key])


def test_two_laws_may_not_share_their_constants(registered):
    with pytest.raises(ValueError, match="the friction law of Smoothed is registered already"):
        FRICTION_LAWS.register(replace(FRICTION_LAWS["smoothed"], name="another"))
    assert "another" not in FRICTION_LAWS


@pytest.mark.parametrize(("change", "key", "registry"), [
    ("corner.reaction=sticky", "corner.reaction", FRICTION_LAWS),
    ("corner.constraint=sticky", "corner.constraint", CONSTRAINTS),
    ("material.law=sticky", "material.law", MATERIALS),
    ("plate.element=sticky", "plate.element", ELEMENT_KINDS),
    ("plate.lumping=sticky", "plate.lumping", LUMPINGS), ("plate.start=sticky", "plate.start", START_KINDS),
])  # fmt: skip
def test_a_scene_names_what_is_registered_and_nothing_else(registered, change, key, registry):
    with pytest.raises(InputError) as caught:
        read_scene("paper-table-3", (change,))
    assert caught.value.key == key
    assert [name for name in registry if repr(name) not in str(caught.value)] == []


def test_every_law_names_a_reaction_of_the_rigid_theory():
    assert {law.rigid for law in FRICTION_LAWS.values()} <= set(REACTIONS)
