"""The two plants of the demo: the drives they belong to, and the table of their figures."""

from pathlib import Path

import pytest
from programs import program
from rich.console import Console
from sextant_py import demo_methods, printed_configuration
from sextant_py.errors import UserError

METRICS = {
    "torque_error_rms_nm": 1.5,
    "torque_ripple_pp_nm": 12.25,
    "torque_bias_nm": -0.125,
    "response_time_ms": 0.5,
    "flux_min_wb": 1.0625,
    "flux_max_wb": 1.125,
    "switching_frequency_hz": 9000,
    "peak_current_a": 23.5,
    "energy_copper_j": 1500,
}


def test_the_runs_are_of_the_live_drives_and_differ_in_the_method_alone(tmp_path: Path) -> None:
    programs = program("sextant-mil").parent
    drives = {method: demo_methods.drive_of(programs, file) for method, file in demo_methods.FILES.items()}
    different = {key for key, value in drives["dtc"].items() if drives["foc"][key] != value}
    assert different == {"control.controller"}
    assert {method: drive["control.controller"] for method, drive in drives.items()} == {"dtc": "dtc", "foc": "foc"}
    assert drives["dtc"]["plant.integrator"] == "cvode"
    assert drives["dtc"]["machine.inertia_kg_m2"] == 0.5, "the profile is made for it"
    for method, drive in drives.items():
        scenario = tmp_path / f"{method}.toml"
        scenario.write_text(demo_methods.scenario_of(drive, tmp_path), encoding="utf-8")
        again = printed_configuration.tables_of(program("sextant-mil"), scenario)
        assert again["control"]["controller"] == method
        assert again["duration_s"] == 10


def test_a_file_that_the_drive_refuses_is_named(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text("drive_id = 1.5\n", encoding="utf-8")
    with pytest.raises(UserError, match=r"bad\.toml.*drive_id: expected an integer"):
        demo_methods.drive_of(program("sextant-mil").parent, file)


def test_the_table_has_the_figures_of_both(tmp_path: Path) -> None:
    console = Console(width=120, record=True, file=(tmp_path / "said").open("w"))
    console.print(demo_methods.table_of({"dtc": METRICS, "foc": METRICS | {"torque_ripple_pp_nm": 0.75}}))
    text = console.export_text()
    assert "dtc (ecu.toml)" in text and "foc (ecu_foc.toml)" in text
    assert len([line for line in text.splitlines() if line.startswith("│")]) == len(demo_methods.ROWS)
    rows = {line.split("│")[1].strip(): line.split("│")[2:4] for line in text.splitlines() if line.startswith("│")}
    assert [cell.strip() for cell in rows["torque ripple, peak to peak"]] == ["12.25 N·m", "0.75 N·m"]
    assert rows["offset of the mean torque"][0].strip() == "-0.125 N·m"
    assert rows["stator flux"][0].strip() == "1.062 … 1.125 Wb"
    assert rows["switching frequency of a device"][0].strip() == "9.0 kHz"
    assert rows["copper loss"][0].strip() == "1.500 kJ"
