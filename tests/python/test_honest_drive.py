"""The honest plant: what its file sets, what its drive is told, and the map and campaign on it."""

from pathlib import Path

import pytest
from programs import program
from sextant_py import drive_file
from sextant_py.paths import ROOT
from studies import honest_drive, plant_faults
from studies.fault_campaign import fault_campaign
from studies.fault_campaign import file as fault_campaign_file
from studies.fault_campaign import honest as fault_campaign_honest
from studies.fault_campaign.false_trips import Hours
from studies.page import put_into
from studies.torque_map import honest as torque_map_honest
from studies.torque_map import kinds as torque_map_kinds
from studies.torque_map import points as torque_map_points
from studies.torque_map import torque_map
from studies.torque_map.drive import Drive
from studies.torque_map.points import ESTIMATE, Conditions
from studies.torque_map.results import MapOf, Results
from studies.torque_map.scale import SENSORS


def test_its_sensors_are_those_of_the_torque_map_and_nothing_is_told() -> None:
    plant = honest_drive.plant_settings()
    assert {key: value for key, value in plant.items() if ".sensors." in key} == SENSORS["real"]
    assert honest_drive.DEAD_TIME not in "".join(plant)
    own = drive_file.read(honest_drive.FILE)
    assert not [key for key in own if key.startswith(honest_drive.TOLD)]
    ordinary = honest_drive.ORDINARY.settings
    assert {key: own[key] for key in ordinary} == ordinary


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return honest_drive.identified(honest_drive.ORDINARY, program("sextant-mil"), tmp_path_factory.mktemp("honest"))


def test_the_drive_is_told_what_is_found(told: Path) -> None:
    """Dead time and threshold voltage are one number at one link voltage, and the sensors' gains differ by 2 %."""
    found = drive_file.read(told)
    of_the_threshold = 1.2 / 530 * 125
    assert found["drive.inverter.dead_time_us"] == pytest.approx(3.0 + of_the_threshold, rel=0.02)
    assert found["control.machine_estimate.r_s_ohm"] == pytest.approx(0.435 + 0.02, rel=0.03)
    assert found["plant.inverter.dead_time_us"] == 3.0


def test_its_campaign_keeps_the_sensors_of_the_file(told: Path, tmp_path: Path) -> None:
    campaign = fault_campaign_file.Campaign(told, program("sextant-mil"), tmp_path)
    assert campaign.sensors == {fault_campaign_file.OWN: {}}
    plan = fault_campaign_file.cases(["foc"], 1, campaign.sensors)
    assert {case.sensors for case in plan} == {fault_campaign_file.OWN}
    assert len(fault_campaign_file.cases(["foc"], 1)) == 2 * len(plan)
    steady = next(case for case in plan if case.fault is None and case.place == 1)
    assert campaign.run(steady)["kind"] == plant_faults.HARMLESS


def test_a_map_keeps_what_the_file_tells_of_machine_and_inverter() -> None:
    base = {
        "drive.inverter.dead_time_us": 3.2,
        "control.machine_estimate.r_s_ohm": 0.5,
        "control.machine_estimate.l_m_h": 0.08,
    }
    drive = Drive("", base, {"r_s_ohm": 0.4, "r_r_ohm": 0.8, "x_m_ohm": 26}, set())
    real = torque_map_points.machine_settings(drive, Conditions(r_s=2.0, l_m=0.5))
    assert real["machine.r_s_ohm"] == 0.8 and real["control.machine_estimate.r_s_ohm"] == 0.5
    assert real["machine.x_m_ohm"] == 13 and real["control.machine_estimate.l_m_h"] == 0.08
    assert "control.machine_estimate.x_m_ohm" not in real
    believed = torque_map_points.machine_settings(drive, Conditions(r_s=2.0, l_m=0.5, detune="estimate"))
    assert believed["machine.r_s_ohm"] == 0.4 and believed["control.machine_estimate.r_s_ohm"] == 1.0
    assert believed["control.machine_estimate.l_m_h"] == 0.04
    for machine, key in (("x_m_ohm", "x_m_ohm"), ("l_m_h", "x_m_ohm"), ("l_m_h", "l_m_h")):
        other = Drive("", {f"{ESTIMATE}{key}": 20.0}, {"r_s_ohm": 0.4, "r_r_ohm": 0.8, machine: 26}, set())
        for detune, kept in (("machine", 20.0), ("estimate", 10.0)):
            found = torque_map_points.machine_settings(other, Conditions(l_m=0.5, detune=detune))
            assert {name: found[name] for name in found if "_m_" in name and name.startswith(ESTIMATE)} == {
                f"{ESTIMATE}{key}": kept
            }
    assert torque_map_points.inverter_settings(drive, Conditions()) == {}
    wrong = torque_map_points.inverter_settings(drive, Conditions(dead_time=0.9))
    assert wrong == {"drive.inverter.dead_time_us": 2.88}
    assert Conditions().key != Conditions(dead_time=0.9).key


def made_up(variant: torque_map_honest.Variant, letter: str) -> Results:
    speeds, torques = [*torque_map_honest.SPEEDS], [*torque_map_honest.TORQUES]
    rows = [letter * len(speeds) for _ in torques]
    maps = [MapOf(one, rows, [[9.0] * len(speeds) for _ in torques]) for one in variant.sets]
    return Results(variant.name, variant.label, "1", "c", speeds, torques, maps, told="r_s_ohm 1")


def test_the_page_counts_what_is_silently_wrong(tmp_path: Path) -> None:
    maps = {one.name: made_up(one, "s") for one in torque_map_honest.VARIANTS}
    picture, page = torque_map_honest.write(maps, tmp_path)
    assert picture.stat().st_size > 0
    text, counts = page.read_text(encoding="utf-8"), [results.points for results in maps.values()]
    assert f"| **silently wrong** | {' | '.join(map(str, counts))} |" in text
    assert "{" not in text


def test_no_cause_above_standstill_is_that_of_several_drives() -> None:
    maps = [made_up(one, "s") for one in torque_map_honest.VARIANTS]
    found = torque_map_kinds.found(maps, torque_map_honest.kinds())
    slow = torque_map_honest.SLOW_RAD_S
    above = [kind for kind in found if max(kind.speeds) > slow]
    assert {next(iter(kind.points)) for kind in above} == set(torque_map_honest.NAMES)
    assert all(len(kind.points) == 1 and min(kind.speeds) > slow for kind in above)


def test_campaign_and_map_of_the_honest_plant_take_no_other_drive() -> None:
    assert fault_campaign.parse_arguments(["--honest"]).is_of_page
    assert not fault_campaign.parse_arguments(["--honest", "--quick"]).is_of_page
    for words in (["--honest", "my.toml"], ["--honest", "--library"]):
        with pytest.raises(SystemExit):
            fault_campaign.parse_arguments(words)
    for words in (["--honest", "my.toml"], ["--honest", "--quick"], ["--honest", "--drive", "foc"]):
        with pytest.raises(SystemExit):
            torque_map.parse_arguments(words)


def test_the_page_takes_the_tables_of_the_campaign(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text((ROOT / "docs/fault_campaign.md").read_text(encoding="utf-8"), encoding="utf-8")
    run = {"name": "open phase", "method": "foc", "case": "", "kind": plant_faults.NAMED, "seen": "OPEN_PHASE"}
    runs = [
        run | {"late_ms": 2.5},
        run | {"name": "encoder stuck", "kind": plant_faults.MISSED, "late_ms": None},
        run | {"name": fault_campaign_file.STEADY, "kind": plant_faults.OTHERWISE, "late_ms": None},
    ]
    runs = [one | {"inverter": "125 µs"} for one in runs]
    found = fault_campaign_file.Found(runs, [Hours("random, foc", 360.0, 12)])
    put_into(page, fault_campaign_honest.blocks(found, 1))
    text = page.read_text(encoding="utf-8")
    assert (
        "1 seed at 5 operating points: 3 runs; 1 of 1 without a fault trip. "
        "Of 2 faults: 1 named, 1 missed (1 of encoder stuck). The latest trip: 2.5 ms." in text
    )
    assert "- no trip: random, foc (360 s)" in text
    assert fault_campaign_honest.tables(found).startswith("125 µs:\n\n| injection | method | runs |")
