"""What judges the drive on a microcontroller: comparison of golden runs, images and figures."""

import json
from pathlib import Path

import numpy as np
import pytest
from sextant_py.errors import UserError
from studies.microcontroller import page as cortex_page
from studies.microcontroller.cortex_m import bounded, growth, lost_bits
from studies.microcontroller.firmware_image import FORBIDDEN
from studies.microcontroller.golden import COST, OUTPUT, TOLERANCES, compare, load_costs, load_outputs

TICKS = 43.008


def outputs(periods: int = 50) -> np.ndarray:
    numbers = np.zeros(periods, OUTPUT)
    numbers["legs"] = 3
    return numbers


def test_equal_runs_are_identical() -> None:
    found = compare(outputs(), outputs(), [])
    assert found.bit_identical
    assert found.problems == []
    assert found.different == 0


@pytest.mark.parametrize("name", TOLERANCES)
def test_a_number_may_differ_by_its_tolerance_only(name: str) -> None:
    for times, good in ((0.9, True), (1.1, False)):
        other = outputs()
        other[name][7] += times * TOLERANCES[name]
        found = compare(outputs(), other, [])
        assert (found.problems == []) == good
        assert not found.bit_identical
        assert compare(outputs(), other, [], times=2.0).problems == []


def test_no_number_must_be_no_number_in_both() -> None:
    reference, other = outputs(), outputs()
    reference["i_dc"][3] = np.nan
    assert compare(reference, other, []).problems == ["i_dc is no number in other periods"]
    other["i_dc"][3] = np.nan
    assert compare(reference, other, []).problems == []


def test_another_decision_needs_a_variant_that_decides_so() -> None:
    other, variant = outputs(), outputs()
    other["legs"][9] = 1
    assert "first period 9: legs 1 for 3" in compare(outputs(), other, [outputs()]).problems[0]
    variant["legs"][9] = 1
    found = compare(outputs(), other, [outputs(), variant])
    assert (found.problems, found.different, found.on_edge) == ([], 1, 1)
    # All decisions of a period must be those of one variant.
    other["sector"][9] = 2
    assert compare(outputs(), other, [variant]).problems


def test_a_short_replay_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "outputs"
    outputs(10).tofile(file)
    assert len(load_outputs(file, 10)) == 10
    with pytest.raises(UserError, match="10 answers for 11"):
        load_outputs(file, 11)


def costs_file(folder: Path, calibration: list[int], instructions: list[int]) -> Path:
    costs = np.zeros(len(instructions), COST)
    for name in ("drive", "controller", "plant"):
        costs[name] = np.round(np.array(instructions) * TICKS)
    costs["driven"][0] = 1
    file = folder / "costs"
    file.write_bytes(np.round(np.array(calibration) * TICKS).astype("<u4").tobytes() + costs.tobytes())
    return file


def test_costs_are_instructions_without_the_call(tmp_path: Path) -> None:
    costs = load_costs(costs_file(tmp_path, [4, 1004, 2004], [900, 1444]), TICKS)
    assert costs.drive.tolist() == [896, 1440]
    assert costs.driven.tolist() == [True, False]


def test_a_timer_that_does_not_count_instructions_is_refused(tmp_path: Path) -> None:
    for calibration in ([4, 1003, 2004], [4, 1004.4, 2004]):
        with pytest.raises(UserError, match="does not count instructions"):
            load_costs(costs_file(tmp_path, calibration, [900]), TICKS)


def test_what_must_not_be_in_an_image() -> None:
    forbidden = "malloc _malloc_r free _sbrk _Znwj _Znaj __cxa_throw _Unwind_Resume _ZSt20__throw_length_errorPKc"
    forbidden += (
        " abort __aeabi_dadd __aeabi_dmul __aeabi_f2d __aeabi_i2d __aeabi_d2f __aeabi_dcmplt __muldf3 __extendsfdf2"
    )
    assert [name for name in forbidden.split() if not FORBIDDEN.match(name)] == []
    allowed = "_ZdlPv _ZdlPvj __cxa_pure_virtual __aeabi_fadd __aeabi_l2f __aeabi_ldivmod memcpy expm1f halt __addsf3"
    assert [name for name in allowed.split() if FORBIDDEN.match(name)] == []


def test_growth_and_shrinking_beyond_two_percent_are_told() -> None:
    committed = cortex_page.load()
    assert growth(committed, committed) == ([], [])
    now = json.loads(json.dumps(committed))
    now["firmware_bytes"]["flash"] = round(committed["firmware_bytes"]["flash"] * 1.03)
    now["runs"]["delayed"]["instructions"]["drive_step"]["max"] *= 0.9
    grown, shrunk = growth(now, committed)
    assert [text.split(":")[0] for text in grown] == ["flash"]
    assert [text.split(":")[0] for text in shrunk] == ["delayed drive_step max"]
    now["runs"].pop("immediate")
    assert "other figures" in growth(now, committed)[0][0]
    assert len(bounded(committed)) > 20


@pytest.mark.parametrize("key", bounded(cortex_page.load()))
def test_a_growth_of_each_figure_is_told(key: str) -> None:
    committed = cortex_page.load()
    now = json.loads(json.dumps(committed))
    where = now["firmware_bytes"]
    *path, last = key.split()
    if len(path) == 1:
        where = now["methods"][path[0]]
    elif path:
        where = now["runs"][path[0]]["instructions"][path[1]]
    where[last] *= 1.03
    assert [text.split(":")[0] for text in growth(now, committed)[0]] == [key]


def test_a_lost_bit_is_told() -> None:
    committed = cortex_page.load()
    assert lost_bits(committed, committed) == []
    now = json.loads(json.dumps(committed))
    now["runs"]["delayed"]["against_host_float"]["target_unfused"]["bit_identical"] = False
    assert lost_bits(now, committed) == ["delayed, target_unfused"]


def test_the_page_is_what_its_figures_make_of_it() -> None:
    assert cortex_page.differences() == []
    changed = cortex_page.load()
    changed["firmware_bytes"]["flash"] += 1
    page = cortex_page.PAGE.read_text(encoding="utf-8")
    assert cortex_page.rendered(page, changed) != page
