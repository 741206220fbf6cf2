"""The fault campaign: what it runs, what it counts, and its page."""

import json
import subprocess
from pathlib import Path

import pytest
from programs import program
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from studies import json_file, plant_faults
from studies.fault_campaign import (
    false_trips,
    fault_campaign,
)
from studies.fault_campaign import file as fault_campaign_file
from studies.fault_campaign import library as fault_campaign_library
from studies.fault_campaign import page as fault_campaign_page
from studies.fault_campaign.false_trips import Drive, Hours
from studies.machine_library import faults as machine_library_faults
from studies.page import put_into

ONE = {
    "name": "speed | lost", "fault": "SPEED_SENSOR", "observable": "at once", "runs": 6, "missed": 1, "late": 0,
    "reaction_ms": 0.05, "bound_ms": 10.0, "since_cause_ms": 0.07, "runs_inside": 6, "trips_inside": 2,
}  # fmt: skip


def trip(name: str, at_s: float) -> dict:
    return {"faults": [{"fault": name, "t_s": at_s}, {"fault": "WATCHDOG", "t_s": at_s + 1}]}


def test_help_needs_no_build(tmp_path: Path) -> None:
    found = subprocess.run([ROOT / "scripts/fault_campaign", "--help"], capture_output=True, text=True, cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert "--quick" in found.stdout


def test_the_page_is_of_the_full_campaign_alone() -> None:
    full = fault_campaign.parse_arguments([])
    assert (full.seeds, full.hours, full.is_of_page) == (100, 1.0, True)
    for words in (["--quick"], ["--seeds", "100"], ["--hours", "0"]):
        assert not fault_campaign.parse_arguments(words).is_of_page
    assert fault_campaign.parse_arguments(["--hours", "0"]).hours == 0


@pytest.mark.parametrize("words", [["--seeds", "0"], ["--hours", "-1"], ["--jobs", "0"]])
def test_numbers_that_are_none_are_refused(words: list[str]) -> None:
    with pytest.raises(SystemExit):
        fault_campaign.parse_arguments(words)


def test_an_hour_of_each_driving_has_no_seed_twice() -> None:
    plan = false_trips.drives(1.0)
    assert len(set(plan)) == len(plan)
    for kind, (_, duration_s) in false_trips.KINDS.items():
        total = sum(one.duration_s for one in plan if one.kind == kind)
        assert 3600 <= total < 3600 + duration_s


def test_random_steps_are_those_of_their_seed(tmp_path: Path) -> None:
    def texts(seed: int) -> list[str]:
        settings = false_trips.KINDS["random torque steps"][0](Drive("", seed, 5.0), tmp_path)
        return [Path(settings[key]).read_text() for key in ("profile.torque_nm.file", "load.speed_rad_s.file")]

    assert texts(1) == texts(1)
    assert texts(1) != texts(2)
    torque, speed = texts(1)
    rows = [tuple(map(float, line.split(","))) for line in torque.splitlines()[1:]]
    assert [t for t, _ in rows] == sorted(t for t, _ in rows)
    assert max(abs(value) for _, value in rows) > 60
    assert float(speed.splitlines()[-1].split(",")[0]) >= 5


def test_a_trip_counts_once_and_ends_its_run() -> None:
    hours: dict[str, Hours] = {}
    false_trips.add(hours, Drive("NYCC", 1, 598.0), {"faults": []})
    false_trips.add(hours, Drive("NYCC", 2, 598.0), trip("OPEN_PHASE", 2.0))
    assert (hours["NYCC"].runs, hours["NYCC"].simulated_s) == (2, 600.0)
    assert hours["NYCC"].faults == {"OPEN_PHASE": 1}
    assert json.loads(json_file.text(hours["NYCC"]))["faults"] == {"OPEN_PHASE": 1}
    shown = fault_campaign_page.trip_list([*hours.values(), Hours("demo", 10.0, 1)])
    assert shown == "- NYCC (600 s): **1 false trip**: OPEN_PHASE 1\n- no trip: demo (10 s)"


def test_the_table_has_periods_where_they_are_few() -> None:
    assert "| at once | 2 T, **1 missed** | 0.07 |" in fault_campaign_page.fault_table([ONE])
    assert "2 T, **1 missed**, **1 later than 10 ms** |" in fault_campaign_page.fault_table([ONE | {"late": 1}])


def test_the_page_keeps_its_text(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    committed = (ROOT / "docs/fault_campaign.md").read_text(encoding="utf-8")
    page.write_text(committed, encoding="utf-8")
    fault_campaign_page.write(page, 7, [ONE], [Hours("NYCC", 598.0, 1)])
    found = page.read_text(encoding="utf-8")
    assert (
        "7 seeds at 3 operating points, with ideal and with real sensors: 6 runs, 1 missed, 0 later than their bounds."
        in found
    )
    assert "6 runs, 2 trips" in found
    assert "## Not detectable" in found
    with pytest.raises(UserError):
        fault_campaign_page.write(tmp_path / "none.md", 7, [ONE], [])


def test_a_file_is_a_campaign_of_its_own() -> None:
    own = fault_campaign.parse_arguments(["my.toml"])
    assert (own.file, own.is_of_page, own.methods) == (Path("my.toml"), False, None)
    assert fault_campaign_file.chosen_methods(None, "foc") == ["foc"]
    assert fault_campaign_file.chosen_methods("dtc,foc", "foc") == ["dtc", "foc"]
    assert len(fault_campaign_file.chosen_methods("all", "foc")) == 7
    with pytest.raises(SystemExit):
        fault_campaign.parse_arguments(["--methods", "all"])


def test_cases_of_a_file_are_all_different() -> None:
    found = fault_campaign_file.cases(["dtc", "foc"], 2)
    assert len({case.key for case in found}) == len(found)
    kinds = len(plant_faults.FAULTS) + 1
    at_standstill = 1  # of them shows nothing there
    assert len(found) == 2 * (kinds * len(fault_campaign_file.PLACES) - at_standstill) * 2 * 2


def test_both_campaigns_inject_the_faults_of_one_list() -> None:
    assert {case.fault for case in fault_campaign_file.cases(["foc"], 1)} == {None, *plant_faults.FAULTS}
    library = {fault for fault, _ in machine_library_faults.cases(machine_library_faults.MACHINES, ["foc"], False)}
    assert library == {fault for fault in plant_faults.FAULTS if fault.draw is None}
    assert len({fault.name for fault in plant_faults.FAULTS}) == len(plant_faults.FAULTS)


def test_a_fault_begins_under_way_or_at_power_up() -> None:
    begin_s = {fault.name: fault.settings(1.7)["plant.faults.at_s"] for fault in plant_faults.FAULTS}
    assert (begin_s["open phase"], begin_s["phase never connected"]) == (1.7, 0.0)


def campaign_file(directory: Path, more: str = "") -> Path:
    file = directory / "my.toml"
    machine = ROOT / "configs" / "machines" / "motulator_2k2.toml"
    text = f'[machine]\nfile = "{machine}"\n[control]\ncontroller = "foc"\n[drive]\nperiod_us = 100\n'
    file.write_text(f"{text}[plant]\nu_dc_v = 566\n{more}", encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> fault_campaign_file.Campaign:
    directory = tmp_path_factory.mktemp("campaign")
    file = campaign_file(directory)
    return fault_campaign_file.Campaign(file, program("sextant-mil"), directory)


@pytest.mark.parametrize(
    ("text", "keeps_sensors", "keeps_encoder"),
    [
        ("seed = 4", False, False),
        ("voltage.offset_v = 3", True, False),
        ("current.noise_a = 0.1", True, False),
        ("encoder.lines = 2048", True, True),
        ("resolver.pole_pairs = 2", True, True),
        ("sin_cos.periods = 512", True, True),
    ],
)
def test_sensors_of_a_file_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, keeps_sensors: bool, keeps_encoder: bool
) -> None:
    monkeypatch.setattr(fault_campaign_file, "DRIVING_S", 1.0)
    file = campaign_file(tmp_path, f"[plant.sensors]\n{text}\n")
    own = fault_campaign_file.Campaign(file, program("sextant-mil"), tmp_path)
    assert own.sensors == ({fault_campaign_file.OWN: {}} if keeps_sensors else own.scale.sensors)
    assert own.encoder == ({} if keeps_encoder else fault_campaign_file.ENCODER)
    _, summary = own.drive_on("foc", 1)
    key, value = text.split(" = ")
    if keeps_sensors:
        assert summary["configuration"][f"plant.sensors.{key}"] == float(value)


def case_of(name: str, place: int) -> fault_campaign_file.Case:
    found = (one for one in plant_faults.FAULTS if one.name == name)
    return fault_campaign_file.Case(next(found, None), "foc", 1, place, "ideal")


def test_runs_of_a_file_are_judged(campaign: fault_campaign_file.Campaign) -> None:
    steady, lost, sagged = (
        campaign.run(case_of(name, 1)) for name in ("none", "encoder at zero", "link under-voltage")
    )
    assert steady["kind"] == plant_faults.HARMLESS
    assert (lost["kind"], lost["seen"]) == (plant_faults.NAMED, "SPEED_SENSOR")
    assert (sagged["kind"], sagged["seen"]) == (plant_faults.NAMED, "DC_UNDER_VOLTAGE")
    assert fault_campaign_file.wrong([steady, lost, sagged]) == []
    assert fault_campaign_file.wrong([steady | {"kind": plant_faults.OTHERWISE}]) != []
    table = plant_faults.injections_table([steady, lost], ("name", "method"))
    assert "| no fault | `foc` | 1 | 0 | 0 | 1 | 0 | – | – |" in table


def test_a_record_of_a_file_is_judged_by_its_torque(campaign: fault_campaign_file.Campaign) -> None:
    case = case_of("open phase", 1)
    _, torque = campaign.place(case)
    at_s, end_s = campaign.times(case)
    right = {"reason": "", "faults": [], "torque_bias_nm": 0.0, "torque_motoring_nm": 99.0}
    assert campaign.judged(case, right)["kind"] == plant_faults.HARMLESS
    assert campaign.judged(case, right | {"torque_bias_nm": -0.2 * torque})["kind"] == plant_faults.MISSED
    half = right | {"torque_motoring_nm": torque / 2, "torque_bias_nm": -torque / 2}
    assert campaign.judged(case, half)["kind"] == plant_faults.HARMLESS
    assert campaign.judged(case, right | {"torque_motoring_nm": None})["kind"] == plant_faults.MISSED
    assert campaign.judged(case, {"reason": "the file is wrong"})["kind"] == plant_faults.REFUSED
    late = campaign.judged(case, right | {"faults": [["OPEN_PHASE", at_s + 0.005]]})
    assert (late["kind"], late["late_ms"]) == (plant_faults.NAMED, pytest.approx(5.0))
    other = campaign.judged(case, right | {"faults": [["FLUX_LOST", at_s + 0.005]]})
    assert other["kind"] == plant_faults.OTHERWISE
    early = campaign.judged(case, right | {"faults": [["OPEN_PHASE", at_s - 0.1]]})
    assert (early["kind"], early["late_ms"]) == (plant_faults.OTHERWISE, 0)
    assert end_s > at_s + 0.5


def library_run(name: str, kind: str, method: str = "foc", period_us: int = 50) -> dict:
    seen = "OPEN_PHASE" if kind in (plant_faults.NAMED, plant_faults.OTHERWISE) else ""
    return {
        "name": name, "method": method, "case": "", "kind": kind, "seen": seen, "late_ms": None,
        "machine": "2.2 kW", "period_us": period_us,
    }  # fmt: skip


def test_the_library_is_four_machines_at_two_periods(tmp_path: Path) -> None:
    library = fault_campaign.parse_arguments(["--library"])
    assert (library.seeds, library.hours, library.is_of_page) == (fault_campaign_library.SEEDS, 1.0, True)
    assert not fault_campaign.parse_arguments(["--library", "--quick"]).is_of_page
    with pytest.raises(SystemExit):
        fault_campaign.parse_arguments(["my.toml", "--library"])
    machines = fault_campaign_library.machines()
    assert [machine.id for machine in machines] == [*fault_campaign_library.MACHINES]
    for period_us in fault_campaign_library.PERIODS_US:
        own = fault_campaign_library.campaign_of(machines[1], period_us, program("sextant-mil"), tmp_path)
        assert own.drive.configuration["drive.period_us"] == period_us
        assert own.drive.configuration["plant.u_dc_v"] == machines[1].u_dc


def test_the_tables_of_the_library_count_what_was_missed() -> None:
    kinds = (plant_faults.NAMED, plant_faults.MISSED, plant_faults.REFUSED)
    runs = [library_run("open phase", kind) for kind in kinds]
    runs += [library_run(fault_campaign_file.STEADY, plant_faults.OTHERWISE, "dtc")]
    table = plant_faults.injections_table(runs, with_latest=False)
    assert "| open phase | 3 | 1 | 0 | 0 | 1 | 1 | OPEN_PHASE 1 |" in table
    by_method = fault_campaign_library.methods_table(runs)
    row = next(line for line in by_method.splitlines() if "2.2 kW" in line)
    assert row.startswith("| 2.2 kW | 0/0, 1 false |")
    assert "| 1/3, 1 refused |" in row


def test_the_page_takes_the_tables_of_the_library(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text((ROOT / "docs/fault_campaign.md").read_text(encoding="utf-8"), encoding="utf-8")
    runs = [library_run("open phase", plant_faults.NAMED)]
    found = fault_campaign_file.Found(runs, [Hours("2.2 kW: random torque steps, foc", 3600.0, 120)])
    put_into(page, fault_campaign_library.blocks(found, 2))
    text = page.read_text(encoding="utf-8")
    assert "2 seeds at 5 operating points: 1 run." in text
    assert "- no trip: 2.2 kW: random torque steps, foc (3600 s)" in text
