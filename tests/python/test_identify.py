"""scripts/identify: the fit against levels that are made here, and whole measurements on simulated drives."""

import json
import math
import random
import secrets
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest
from programs import program
from sextant_py import identify, identify_saturated_tones, identify_saturation
from sextant_py.errors import UserError
from sextant_py.identify_files import Results, write_files
from sextant_py.identify_fit import Level, Setup, fit
from sextant_py.identify_impedance import Tone
from sextant_py.identify_machine import estimate_of
from sextant_py.identify_no_load import NoLoad
from sextant_py.identify_shaft import turning
from sextant_py.paths import ROOT

MACHINE = ROOT / "configs" / "machines" / "paper_3hp.toml"
SaturationParameters = tuple[float, int]  # knee [Wb], exponent
SETUP = Setup(period_s=25e-6, leakage_h=4.7e-3)


def levels_of(dead_time_s: float, r_ohm: float, setup: Setup, noise_v: float = 0.0, **other: float) -> list[Level]:
    """Eight levels by Ohm's law and the volt-seconds that each of the three legs loses."""
    made = np.random.default_rng(int(other.get("seed", 0)))
    scatter, link, offset = other.get("scatter", 0.0), other.get("link", 530.0), other.get("offset", 0.0)
    levels = []
    for current in (20.0, 14.7, 9.3, 4.0, -4.0, -9.3, -14.7, -20.0):
        phases = np.array([current, -current / 2, -current / 2])
        lost = np.sign(phases) * (link * dead_time_s / setup.period_s + setup.threshold_v) + setup.slope_ohm * phases
        along = 2 / 3 * (lost[0] - (lost[1] + lost[2]) / 2)
        voltage = r_ohm * current + along + offset + noise_v * made.standard_normal()
        levels.append(Level(current, float(voltage), link, scatter, 0.0))
    return levels


def test_levels_without_noise_give_back_what_made_them() -> None:
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    drawn = random.Random(seed)
    for _ in range(100):
        setup = Setup(
            drawn.uniform(20e-6, 250e-6), 4.7e-3, drawn.choice([0.0, drawn.uniform(0, 2)]), drawn.uniform(0, 0.05)
        )
        dead_time, r_s = drawn.uniform(0, 0.02) * setup.period_s, drawn.uniform(0.05, 5)
        found = fit(levels_of(dead_time, r_s, setup, offset=drawn.uniform(-0.5, 0.5)), setup)
        assert found.dead_time_s == pytest.approx(dead_time, abs=1e-12)
        assert found.r_s_ohm == pytest.approx(r_s, rel=1e-9)


def test_the_stated_deviation_is_that_of_the_results() -> None:
    """Over many measurements, errors by their stated variance have a mean square near that of Student's t with 5
    degrees of freedom, 5/3."""
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    dead, resistance = [], []
    for k in range(2000):
        found = fit(levels_of(1.5e-6, 0.435, SETUP, noise_v=0.05, seed=seed + k), SETUP)
        dead.append((found.dead_time_s - 1.5e-6) / found.dead_time_sigma_s)
        resistance.append((found.r_s_ohm - 0.435) / found.r_s_sigma_ohm)
    for errors in (dead, resistance):
        assert np.median(np.abs(errors)) == pytest.approx(0.727, abs=0.08)  # the median of |t| with 5 degrees
        assert abs(np.mean(errors)) < 0.15


def test_dead_time_and_threshold_are_one_number_at_one_link() -> None:
    real = Setup(25e-6, 4.7e-3, threshold_v=1.06)
    levels = levels_of(1.5e-6, 0.435, real)
    assert fit(levels, real).dead_time_s == pytest.approx(1.5e-6)
    assert fit(levels, SETUP).dead_time_s == pytest.approx(1.5e-6 + 1.06 * 25e-6 / 530)


def test_levels_whose_sign_is_not_certain_are_left_out() -> None:
    levels = levels_of(1.5e-6, 0.435, SETUP)
    # At the lowest levels the currents change their sign: half of the dead time's voltage is gone.
    wrong = [
        Level(one.current_a, one.voltage_v * (0.5 if abs(one.current_a) < 5 else 1), one.link_v, 0.6, 0.0)
        for one in levels
    ]
    found = fit(wrong, SETUP)
    assert found.used == (True, True, True, False, False, True, True, True)
    assert found.dead_time_s == pytest.approx(1.5e-6, rel=1e-6)
    with pytest.raises(UserError, match=r"raise control\.commissioning\.current_limit_a"):
        fit([Level(one.current_a, one.voltage_v, one.link_v, 10.0, 0.0) for one in levels], SETUP)


def test_files_hold_what_was_found(tmp_path: Path) -> None:
    found = fit(levels_of(1.5e-6, 0.435, SETUP, noise_v=0.01, seed=1), SETUP)
    inverter, machine = write_files(tmp_path, Path("x.toml"), Results(SETUP, found=found))
    told = tomllib.loads(inverter.read_text(encoding="utf-8"))
    assert told["dead_time_us"] == pytest.approx(1.5, abs=0.01)
    taken = found.link_v * told["dead_time_us"] * 1e-6 / SETUP.period_s
    assert told["voltage_error_v"] == pytest.approx(0.4 / math.pi * taken, rel=0.01)
    assert told["voltage_error_v"] > found.voltage_error_v
    assert tomllib.loads(machine.read_text(encoding="utf-8"))["r_s_ohm"] == pytest.approx(found.r_s_ohm, rel=1e-4)
    none = fit(levels_of(0.0, 0.435, SETUP, noise_v=0.01, seed=1), SETUP)
    inverter, _ = write_files(tmp_path, Path("x.toml"), Results(SETUP, found=none))
    assert tomllib.loads(inverter.read_text(encoding="utf-8"))["dead_time_us"] == 0


def test_a_slope_resistance_above_what_the_terminals_show_is_refused() -> None:
    setup = Setup(25e-6, 4.7e-3, slope_ohm=1.0)
    with pytest.raises(UserError, match=r"0\.435 ohm.*drive\.inverter\.slope_ohm, 1 ohm"):
        fit(levels_of(1.5e-6, 0.435, SETUP), setup)


def test_a_threshold_above_what_a_leg_takes_is_refused() -> None:
    """A leg takes 1 V; a tenth less than what is told is within what temperatures change."""
    levels = levels_of(0.0, 0.435, Setup(25e-6, 4.7e-3, threshold_v=1.0), noise_v=0.001)
    with pytest.raises(UserError, match=r"1 V.*threshold voltage of 3 V \(--threshold-v"):
        fit(levels, Setup(25e-6, 4.7e-3, threshold_v=3.0))
    assert fit(levels, Setup(25e-6, 4.7e-3, threshold_v=1.05)).dead_time_s < 0


def drive_file(directory: Path, text: str = "") -> Path:
    """A drive with sensors as they are."""
    file = directory / "drive.toml"
    file.write_text(
        f'machine = "{MACHINE}"\n[control]\nflux_reference_wb = 1.1\n[protection]\nover_current_a = 250\n'
        "[plant]\nu_dc_v = 530\n[plant.sensors.current]\nrange_a = 300\nbits = 12\nnoise_a = 0.2\n"
        f"[plant.sensors.voltage]\nrange_v = 1000\nbits = 12\nnoise_v = 0.5\n{text}",
        encoding="utf-8",
    )
    return file


@pytest.mark.parametrize(("period_us", "dead_us"), [(25, 1.5), (125, 3.0), (25, 0.3)])
def test_a_drive_that_knows_nothing_finds_its_dead_time_and_resistance(
    tmp_path: Path, period_us: int, dead_us: float
) -> None:
    file = drive_file(tmp_path)
    plant = [f"drive.period_us={period_us}", f"plant.inverter.dead_time_us={dead_us}"]
    words = [str(file), "--only", "dead_time", "--out", str(tmp_path), "--mil", str(program("sextant-mil"))]
    assert identify.main([*words, "--set", plant[0], "--set", plant[1]]) == 0
    told = tomllib.loads((tmp_path / "inverter.toml").read_text(encoding="utf-8"))
    assert told["dead_time_us"] == pytest.approx(dead_us, rel=0.1)
    machine = tomllib.loads((tmp_path / "machine.toml").read_text(encoding="utf-8"))
    assert machine["r_s_ohm"] == pytest.approx(0.435, rel=0.03)
    assert (tmp_path / "identify.png").stat().st_size > 10_000


def test_saturation_and_a_known_threshold_leave_dead_time_and_resistance_as_they_are(tmp_path: Path) -> None:
    file = drive_file(
        tmp_path, "[plant.saturation]\nknee_wb = 1.1\n[drive.inverter]\nthreshold_v = 1.2\nslope_ohm = 0.02\n"
    )
    words = [str(file), "--only", "dead_time", "--out", str(tmp_path), "--mil", str(program("sextant-mil"))]
    plant = ("drive.period_us=125", "plant.inverter.dead_time_us=3", "plant.inverter.threshold_v=1.2")
    for key in (*plant, "plant.inverter.slope_ohm=0.02"):
        words += ["--set", key]
    assert identify.main(words) == 0
    told = tomllib.loads((tmp_path / "inverter.toml").read_text(encoding="utf-8"))
    assert told["dead_time_us"] == pytest.approx(3, rel=0.02)
    assert (told["threshold_v"], told["slope_ohm"]) == (1.2, 0.02)
    machine = tomllib.loads((tmp_path / "machine.toml").read_text(encoding="utf-8"))
    assert machine["r_s_ohm"] == pytest.approx(0.435, rel=0.01)


def test_a_drive_with_a_wrong_estimate_finds_its_machine(tmp_path: Path) -> None:
    """Told of no dead time, half of the rotor's time constant and 0.7 of L_m. Compared at the terminals: the division
    of the leakage is that of the estimate."""
    estimate = "[control.machine_estimate]\nr_r_ohm = 1.2\nx_ls_ohm = 0.6\nx_lr_ohm = 0.9\nx_m_ohm = 19\n"
    file = drive_file(tmp_path, estimate)
    words = [str(file), "--out", str(tmp_path), "--mil", str(program("sextant-mil"))]
    keys = ("drive.period_us=125", "plant.inverter.dead_time_us=1.5", "plant.inverter.threshold_v=1.2")
    for key in (*keys, "drive.actuation_delay_periods=1"):
        words += ["--set", key]
    assert identify.main(words) == 0
    told = {f"machine.{key}": value for key, value in tomllib.loads((tmp_path / "machine.toml").read_text()).items()}
    found = estimate_of(told)
    assert found.l_ls / found.l_lr == pytest.approx(0.6 / 0.9, rel=1e-3)
    named = tomllib.loads(MACHINE.read_text(encoding="utf-8"))
    true = estimate_of({f"machine.{key}": value for key, value in named.items()}).terminals
    for name, value in vars(true).items():
        assert getattr(found.terminals, name) == pytest.approx(value, rel=0.01), name
    assert told["machine.r_s_ohm"] == pytest.approx(0.435, rel=0.01)
    assert (tmp_path / "identify.png").stat().st_size > 20_000


def test_impedance_alone_tells_the_resistance_too_and_writes_no_inverter(tmp_path: Path) -> None:
    file = drive_file(tmp_path)
    words = [str(file), "--only", "impedance", "--out", str(tmp_path), "--mil", str(program("sextant-mil"))]
    for key in ("drive.period_us=250", "plant.inverter.dead_time_us=3"):
        words += ["--set", key]
    assert identify.main(words) == 0
    machine = tomllib.loads((tmp_path / "machine.toml").read_text(encoding="utf-8"))
    assert machine["r_s_ohm"] == pytest.approx(0.435, rel=0.03)
    assert machine["r_r_ohm"] == pytest.approx(0.816, rel=0.05)
    assert not (tmp_path / "inverter.toml").exists()


def shaft_words(file: Path, directory: Path, *settings: str) -> list[str]:
    keys = ("drive.period_us=125", "plant.inverter.dead_time_us=1.5", "drive.inverter.dead_time_us=1.5", *settings)
    words = [str(file), "--only", "inertia", "--out", str(directory), "--mil", str(program("sextant-mil"))]
    return [*words, *(word for key in keys for word in ("--set", key))]


def test_a_free_shaft_tells_its_inertia_whatever_the_load(tmp_path: Path) -> None:
    """The estimate is half of it; a constant load turns the shaft."""
    file = drive_file(tmp_path, "[control.machine_estimate]\ninertia_kg_m2 = 0.045\n")
    assert identify.main(shaft_words(file, tmp_path, "load.torque_nm.value=2")) == 0
    told = tomllib.loads((tmp_path / "machine.toml").read_text(encoding="utf-8"))
    assert list(told) == ["inertia_kg_m2"]
    assert told["inertia_kg_m2"] == pytest.approx(0.089, rel=0.05)
    assert (tmp_path / "identify.png").stat().st_size > 10_000


def no_load_of(flux: float, current: float) -> NoLoad:
    return NoLoad(flux, current, 1e-3, 35.0)


def coasting(curve: SaturationParameters) -> list[NoLoad]:
    """By the published law, whose current at the whole flux of 1.1 Wb is that of 85.6 mH."""
    knee, exponent = curve
    scale = 1.1 * (1 + (1.1 / knee) ** exponent) / (1.1 / 0.0856)
    fluxes = [1.1 * share for share in identify_saturation.SHARES]
    return [no_load_of(flux, flux * (1 + (flux / knee) ** exponent) / scale) for flux in fluxes]


@pytest.mark.parametrize("curve", [(1.1, 7), (1.3, 3), (1.25, 12)])
def test_fluxes_without_torque_give_back_the_curve_of_the_iron(curve: SaturationParameters) -> None:
    found = identify_saturation.fit(coasting(curve))
    assert (found.knee_wb, found.exponent) == (pytest.approx(curve[0], rel=1e-6), curve[1])
    assert found.machine_flux_wb == pytest.approx(1.1)
    half = np.array([0.55])
    whole, small = ((1 + (flux / curve[0]) ** curve[1]) for flux in (1.1, 0.55))
    assert found.ratio(half)[0] == pytest.approx(whole / small)


def test_iron_that_does_not_saturate_has_no_curve() -> None:
    made = np.random.default_rng(7)
    points = [no_load_of(1.1 * s, 1.1 * s / 0.0856 * (1 + 2e-3 * made.standard_normal())) for s in (0.45, 0.7, 0.9, 1)]
    assert identify_saturation.fit(points) is None


def test_a_tone_on_the_curve_is_that_of_its_differential_equation() -> None:
    """The periodic solution by points against an integration from rest, with a direct current beside the sine."""
    from scipy.integrate import solve_ivp

    points = coasting((1.1, 7))
    iron = identify_saturated_tones.Iron(points[-1], identify_saturation.fit(points))
    resistance, leakage, rotor = 0.435, 5.01e-3, 0.864
    for hertz in (2.0, 60.0):
        omega = 2 * math.pi * hertz
        tone = Tone(omega, 0j, 0.0, 13.3, 8.8)
        fluxes = np.linspace(-2, 2, 40001)
        total = fluxes + leakage * iron.current(fluxes)

        def current(t: float | np.ndarray, omega: float = omega) -> float | np.ndarray:
            return 13.3 + 8.8 * np.sin(omega * t)

        def slope(t: float, psi: np.ndarray, current=current, total=total, fluxes=fluxes) -> np.ndarray:
            flux = np.interp(psi + leakage * current(t), total, fluxes)
            return rotor * (current(t) - iron.current(flux))

        cycles = math.ceil(1.5 * hertz)
        t = (cycles + np.arange(256) / 256) / hertz
        found = solve_ivp(slope, (0, t[-1]), [iron.flux(13.3)], t_eval=t, rtol=1e-7, atol=1e-9, max_step=0.02 / hertz)
        flux = np.interp(found.y[0] + leakage * current(t), total, fluxes)
        turn = np.exp(-1j * omega * t)
        expected = resistance + 1j * omega * np.sum(turn * flux) / np.sum(turn * current(t))
        made = identify_saturated_tones.impedance(iron, tone, resistance, leakage, rotor)
        assert abs(made - expected) < 1e-3 * abs(expected)


@pytest.mark.parametrize("plant", ["ideal sensors", "honest"])
def test_iron_that_saturates_shows_its_machine_at_the_whole_flux_and_its_curve(tmp_path: Path, plant: str) -> None:
    """The machine of the file, by `machine_flux_wb`; linear tones about a direct current find a third less R_r and a
    quarter of L_m. Honest: at small fluxes much of what shows is dead time and errors of the current sensors."""
    honest = ROOT / "configs" / "ecu_honest.toml"
    saturating = "[plant.saturation]\nknee_wb = 1.1\nmachine_flux_wb = 1.1\n"
    file = honest if plant == "honest" else drive_file(tmp_path, saturating)
    words = [str(file), "--only", "dead_time,impedance,no_load", "--out", str(tmp_path)]
    for key in ("drive.period_us=125", "plant.inverter.dead_time_us=1.5"):
        words += ["--set", key]
    assert identify.main([*words, "--mil", str(program("sextant-mil"))]) == 0
    told = tomllib.loads((tmp_path / "machine.toml").read_text(encoding="utf-8"))
    named = tomllib.loads(MACHINE.read_text(encoding="utf-8"))
    true = estimate_of({f"machine.{key}": value for key, value in named.items()}).terminals
    found = estimate_of({f"machine.{key}": value for key, value in told.items() if key != "saturation"}).terminals
    for name, value in vars(true).items():
        close = 0.05 if plant == "honest" and name == "r_s" else 0.02  # the switches have 20 mOhm
        assert getattr(found, name) == pytest.approx(value, rel=close), name
    curve = told["saturation"]
    assert (curve["knee_wb"], curve["exponent"]) == (pytest.approx(1.1, rel=0.02), pytest.approx(7, abs=1))
    assert curve["machine_flux_wb"] == pytest.approx(1.1, rel=0.01)
    scenario = str(ROOT / "configs/scenarios/constant_torque.toml")
    command = [str(program("sextant-mil")), scenario, "--print-config", "--set"]
    command.append(f"control.machine_estimate={tmp_path / 'machine.toml'}")
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert tomllib.loads(printed)["control"]["machine_estimate"]["saturation"]["knee_wb"] == curve["knee_wb"]


def test_a_shaft_that_is_held_is_refused(tmp_path: Path) -> None:
    file = drive_file(tmp_path, "[control.machine_estimate]\ninertia_kg_m2 = 0.089\n")
    with pytest.raises(UserError, match="free to turn") as refused:
        identify.main(shaft_words(file, tmp_path, "machine.inertia_kg_m2=100"))
    assert "\n" not in str(refused.value)


def test_no_load_without_the_leakage_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        identify.parse_arguments(["x.toml", "--only", "no_load"])
    assert "no_load needs impedance" in capsys.readouterr().err


def refusal(file: Path, *words: str) -> str:
    mil = str(program("sextant-mil"))
    with pytest.raises(UserError) as refused:
        identify.main([str(file), "--out", str(file.parent), "--mil", mil, *words])
    said = str(refused.value)
    assert "\n" not in said
    return said


def test_what_does_not_work_is_one_sentence(tmp_path: Path) -> None:
    file = drive_file(tmp_path)
    assert "raise it to" in refusal(file, "--limit-a", "2")
    assert "refuses the drive" in refusal(file, "--set", "plant.u_dc_v=none")
    short = ("--set", "drive.period_us=125", "--set", "control.commissioning.settle_ms=10")
    turning = ("--set", "load.speed_rad_s.value=2")
    assert "the shaft turns at 2 rad/s" in refusal(file, *short, *turning)
    assert "hold it" in refusal(file, "--only", "impedance", *short, *turning)
    tripped = ("--set", "plant.faults.kind=open_phase", "--set", "plant.faults.at_s=0.01")
    assert "the drive tripped with OPEN_PHASE" in refusal(file, *short, *tripped)


def test_a_limit_that_is_set_bounds_the_current_of_the_course(tmp_path: Path) -> None:
    """It lies below the current by which the drive magnetises on its own, 23.1 A."""
    limit = 20.5
    words = [str(ROOT / "configs/ecu_foc.toml"), "--only", "inertia", "--limit-a", str(limit)]
    identify.identified(Path(words[0]), program("sextant-mil"), tmp_path, identify.parse_arguments(words))
    summary = json.loads((tmp_path / "inertia" / "summary.json").read_text(encoding="utf-8"))
    assert summary["metrics"]["peak_current_a"] < 1.02 * limit


def test_a_course_begins_soon_after_the_flux_is_there(tmp_path: Path) -> None:
    """A constant current I magnetises with the rotor's time constant, ψ = L_s I (1 − exp(−t/τ_r)); the time by
    which the drive must be magnetised is many times as long."""
    options = identify.parse_arguments([str(ROOT / "configs/ecu_foc.toml"), "--set", "drive.magnetise_timeout_ms=3000"])
    _, free = identify.plants_of(options.file, program("sextant-mil"), tmp_path, options)
    terminals, given = free.estimate.terminals, free.configuration
    most_wb = (terminals.leakage + terminals.l_magnetising) * given["control.foc.magnetising_current_a"]
    flux_s = -terminals.tau_r * math.log(1 - given["control.flux_reference_wb"] / most_wb)
    settings = turning(free, "no_load", {})
    assert free.magnetising("no_load", settings).flux_s == pytest.approx(flux_s, abs=5e-3)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--limit-a", "17"], r"17 A does not bound the course of inertia, whose flux takes 12\.9 A"),
        (
            ["--set", "plant.driveline.inertia_kg_m2=0.5", "--set", "plant.driveline.stiffness_nm_rad=1000"],
            r"plant\.driveline\.inertia_kg_m2 is 0\.5: the measurement holds the motor's shaft",
        ),
    ],
)
def test_a_limit_or_a_load_that_the_course_cannot_have_is_refused(
    words: list[str], sentence: str, tmp_path: Path
) -> None:
    options = identify.parse_arguments([str(ROOT / "configs/ecu_foc.toml"), "--only", "inertia", *words])
    with pytest.raises(UserError, match=sentence):
        identify.identified(options.file, program("sextant-mil"), tmp_path, options)
