"""scripts/identify: parameters from the impedance at standstill, against a machine in the T circuit that is simulated
here."""

import math
import random
import secrets
import tomllib
from pathlib import Path

import numpy as np
import pytest
from machines import Machine, published, random_machines
from scipy.linalg import expm
from sextant_py.errors import UserError
from sextant_py.identify_files import Results, told, write_files
from sextant_py.identify_fit import Setup
from sextant_py.identify_impedance import Block, Timing, fit
from sextant_py.identify_machine import InverseGamma, TCircuit


def circuit_of(machine: Machine) -> TCircuit:
    return TCircuit(machine.r_s, machine.r_r, machine.l_ls, machine.l_lr, machine.l_m)


def steady_phasors(circuit: TCircuit, cycle: int, timing: Timing) -> tuple[complex, complex]:
    """Current and voltage over a cycle of a sine of 10 V: currents of the T circuit at standstill, whose periodic
    state is that which one cycle of constant voltages, period by period, leads back to itself."""
    inductance = np.array([[circuit.l_ls + circuit.l_m, circuit.l_m], [circuit.l_m, circuit.l_lr + circuit.l_m]])
    inverse = np.linalg.inv(inductance)
    a = -inverse @ np.diag([circuit.r_s, circuit.r_r])
    both = np.zeros((3, 3))
    both[:2, :2], both[:2, 2] = a, inverse[:, 0]
    step, before = expm(both * timing.period_s), expm(both * (timing.period_s - timing.lead_s))
    angles = 2 * math.pi * np.arange(cycle) / cycle
    acting = 10 * np.sin(angles - timing.delay_periods * 2 * math.pi / cycle)

    def course(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        read = np.zeros(cycle)
        for k in range(cycle):  # the reading of the next period, at or before its beginning
            read[(k + 1) % cycle] = (before @ np.append(state, acting[k]))[0]
            state = (step @ np.append(state, acting[k]))[:2]
        return read, state

    _, forced = course(np.zeros(2))
    whole = np.linalg.matrix_power(step[:2, :2], cycle)
    read, _ = course(np.linalg.solve(np.eye(2) - whole, forced))
    weights = 2 / cycle * np.exp(-1j * angles)
    # x = a sin + b cos has the phasor a + jb.
    return complex(1j * (read @ weights)), complex(1j * (10 * np.sin(angles) @ weights))


def blocks_of(circuit: TCircuit, timing: Timing, noise: float = 0.0, seed: int = 0) -> list[Block]:
    made = np.random.default_rng(seed)
    gamma = circuit.terminals
    corner = (gamma.r_s + gamma.r_rotor) / gamma.leakage
    blocks = []
    for omega in np.geomspace(1 / gamma.tau_r, min(2 * corner, 0.05 / timing.period_s), 4):
        cycle = round(2 * math.pi / omega / timing.period_s)
        current, voltage = steady_phasors(circuit, cycle, timing)
        for _ in range(4):
            off = noise * complex(made.standard_normal(), made.standard_normal())
            blocks.append(Block(cycle, current * (1 + off), voltage, 2 * abs(current), 500))
    return blocks


def test_impedances_without_noise_give_back_the_machine_from_a_wrong_estimate() -> None:
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    drawn = random.Random(seed)
    powers = [10 ** drawn.uniform(-0.8, 2.3) for _ in range(3)]
    for machine in [*published(), *random_machines(np.random.default_rng(seed), powers)]:
        circuit = circuit_of(machine)
        period = drawn.choice([125e-6, 250e-6])
        timing = Timing(period, drawn.choice([0, 1]), drawn.choice([0.0, period / 2]))
        true = circuit.terminals
        start = InverseGamma(*(value * drawn.uniform(0.6, 1.6) for value in vars(true).values()))
        slope = 0.1 * circuit.r_s
        found = fit(blocks_of(circuit, timing), timing, start, slope_ohm=0.0)
        for name, value in vars(true).items():
            assert getattr(found.machine, name) == pytest.approx(value, rel=1e-5), machine.name
        told = fit(blocks_of(circuit, timing), timing, start, slope_ohm=slope)
        assert told.machine.r_s == pytest.approx(circuit.r_s - slope, rel=1e-4)


def test_the_stated_deviation_covers_the_error() -> None:
    """Of many measurements with noise; a known resistance makes R_R no worse."""
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    circuit, timing = circuit_of(published()[0]), Timing(125e-6, 1)
    true = circuit.terminals
    clean = blocks_of(circuit, timing)
    made = np.random.default_rng(seed)
    errors = {"leakage": [], "r_rotor": [], "l_magnetising": []}
    for _ in range(100):
        noisy = [
            Block(
                one.cycle, one.current_a * (1 + 3e-3 * complex(*made.standard_normal(2))), one.voltage_v,
                one.mean_current_a, one.link_v,
            )
            for one in clean
        ]  # fmt: skip
        found = fit(noisy, timing, true)
        for name, own in errors.items():
            own.append((getattr(found.machine, name) / getattr(true, name) - 1) / getattr(found.deviations, name))
    for name, own in errors.items():
        # Half of normal errors lie within 0.67 deviations; the larger of two estimates of the noise states it.
        assert 0.3 < np.median(np.abs(own)) < 0.85, name


def test_terminals_and_the_t_circuit_with_its_split_are_one_machine() -> None:
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    made = np.random.default_rng(seed)
    for machine in random_machines(made, 10 ** made.uniform(-1, 2.3, 50)):
        circuit = circuit_of(machine)
        back = circuit.terminals.t_circuit(circuit.l_ls / circuit.l_lr)
        assert list(vars(back).values()) == pytest.approx(list(vars(circuit).values()), rel=1e-9)
        other = circuit.terminals.t_circuit(1.0)
        assert other.l_ls == pytest.approx(other.l_lr)
        assert list(vars(other.terminals).values()) == pytest.approx(list(vars(circuit.terminals).values()), rel=1e-9)


def test_one_tone_is_refused() -> None:
    circuit, timing = circuit_of(published()[0]), Timing(125e-6)
    with pytest.raises(UserError, match="2 frequencies are needed"):
        fit(blocks_of(circuit, timing)[:4], timing, circuit.terminals)


def test_a_slope_resistance_above_what_the_tones_show_is_refused() -> None:
    circuit, timing = circuit_of(published()[0]), Timing(125e-6)
    with pytest.raises(UserError, match=r"drive\.inverter\.slope_ohm"):
        fit(blocks_of(circuit, timing), timing, circuit.terminals, slope_ohm=1.1 * circuit.r_s)


def test_a_drive_is_told_what_the_files_hold(tmp_path: Path) -> None:
    """Of the sines alone, the stator resistance too."""
    circuit, timing = circuit_of(published()[0]), Timing(125e-6)
    found = fit(blocks_of(circuit, timing), timing, circuit.terminals)
    results = Results(Setup(timing.period_s, circuit.terminals.leakage), impedance=found)
    (file,) = write_files(tmp_path, Path("x.toml"), results)
    written = tomllib.loads(file.read_text(encoding="utf-8"))
    keys = told(results)
    assert set(keys) == {f"control.machine_estimate.{key}" for key in written}
    assert written.pop("circuit") == keys["control.machine_estimate.circuit"] == "T"
    for key, value in written.items():
        assert keys[f"control.machine_estimate.{key}"] == pytest.approx(value, rel=1e-4)
