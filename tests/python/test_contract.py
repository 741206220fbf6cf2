"""The list of faults: made from the CAN contract, which must agree with itself and with what the drive raises."""

import math
import re
import subprocess
import sys
from pathlib import Path

import can
import pytest
from sextant_py.contract import Contract
from sextant_py.paths import DBC, ROOT

HEADER = "include/sextant/core/fault_list.hpp"
FAULTS = Contract().faults()


def made_by_cmake(dbc: Path, output: Path) -> subprocess.CompletedProcess:
    script = ROOT / "cmake" / "SextantFaults.cmake"
    command = ["cmake", f"-DDBC={dbc}", f"-DOUTPUT={output}", "-P", script]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)


def made_by_cantools(dbc: Path, output: Path) -> subprocess.CompletedProcess:
    command = [sys.executable, ROOT / "src" / "comms" / "generate_can_contract.py", dbc, output]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)


def comments() -> dict[str, str]:
    """What each fault is, by its name in C++."""
    signals = {signal.start - 16: signal for signal in Contract().message("MCU_FaultsActive").signals}
    return {name.lower(): signals[bit].comment for name, bit in FAULTS.items()}


def test_the_enumeration_is_the_list_that_cantools_reads(tmp_path: Path) -> None:
    made = made_by_cmake(DBC, tmp_path)
    assert made.returncode == 0, made.stderr
    header = (tmp_path / HEADER).read_text(encoding="utf-8")
    enumerators = re.findall(r"^  (\w+) = (\d+),  ///< (.*)$", header, re.MULTILINE)
    texts = comments()
    assert enumerators == [(name.lower(), str(bit), texts[name.lower()]) for name, bit in FAULTS.items()]
    assert re.findall(r'^    "(\w+)",$', header, re.MULTILINE) == list(FAULTS)
    assert f"fault_count = {len(FAULTS)};" in header
    table = (tmp_path / "docs" / "faults.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| (\w+) \| (.*) \|$", table, re.MULTILINE)
    assert rows == [(str(bit), name, texts[name.lower()]) for name, bit in FAULTS.items()]


def test_a_changed_list_is_written_anew(tmp_path: Path) -> None:
    dbc = changed(tmp_path, '19 "TRANSMIT_LOST"', '19 "BUS_LOST"', "ActiveTransmitLost", "ActiveBusLost")
    assert made_by_cmake(DBC, tmp_path).returncode == 0
    assert made_by_cmake(dbc, tmp_path).returncode == 0
    assert "bus_lost = 19," in (tmp_path / HEADER).read_text(encoding="utf-8")


def changed(tmp_path: Path, *words: str) -> Path:
    """The contract with words, each replaced by the next one."""
    text = DBC.read_text(encoding="utf-8")
    for old, new in zip(words[::2], words[1::2], strict=True):
        assert old in text
        text = text.replace(old, new)
    dbc = tmp_path / "changed.dbc"
    dbc.write_text(text, encoding="utf-8")
    return dbc


@pytest.mark.parametrize(
    ("words", "objection"),
    [
        (('19 "TRANSMIT_LOST"', '20 "TRANSMIT_LOST"'), "TRANSMIT_LOST of FirstFault has the value 20"),
        (('19 "TRANSMIT_LOST"', '19 "BUS_LOST"'), "fault BUS_LOST has no comment"),
        (("VAL_ 292 FirstFault", "VAL_ 292 FaultTotal"), "has no value table"),
        (("MCU_FaultsActive", "MCU_FaultsPresent"), "no message MCU_FaultsActive"),
    ],
)
def test_a_list_with_a_gap_is_refused(tmp_path: Path, words: tuple[str, str], objection: str) -> None:
    made = made_by_cmake(changed(tmp_path, *words), tmp_path)
    assert made.returncode != 0
    assert objection in re.sub(r"\s+", " ", made.stderr)


@pytest.mark.parametrize(
    ("words", "objection"),
    [
        ((" SG_ ActiveOverrun : 33|1", " SG_ ActiveOverrun : 40|1"), "MCU_FaultsActive has not one bit for each"),
        ((" SG_ LatchedOverrun : 33|1", " SG_ LatchedOverRun : 33|1"), "MCU_FaultsLatched has not one bit for each"),
        (('18 "WATCHDOG"', '18 "DOG"'), "(18, 'DOG'), (18, 'WATCHDOG')"),
    ],
)
def test_bits_beside_the_list_are_refused(tmp_path: Path, words: tuple[str, str], objection: str) -> None:
    made = made_by_cantools(changed(tmp_path, *words), tmp_path / "contract.hpp")
    assert made.returncode != 0
    assert objection in made.stderr


def test_reserved_is_what_nothing_raises() -> None:
    sources = [file for folder in ("include", "src", "apps") for file in (ROOT / folder).glob("**/*.[hc]pp")]
    named = {name for file in sources for name in re.findall(r"\bFault::(\w+)", file.read_text(encoding="utf-8"))}
    assert {name for name, text in comments().items() if not text.startswith("Reserved. ")} == named


def test_there_is_room() -> None:
    """In either message, for 24 faults."""
    for name in ("MCU_FaultsActive", "MCU_FaultsLatched"):
        used = {
            bit
            for signal in Contract().message(name).signals
            for bit in range(signal.start, signal.start + signal.length)
        }
        assert 64 - len(used) >= 24


def test_what_is_not_available_is_no_number() -> None:
    """Of every signal of the contract: the value table says which raw value is none."""
    contract, seen = Contract(), set()
    for message in contract.database.messages:
        for signal in message.signals:
            none = [value for value, name in (signal.choices or {}).items() if str(name) == "NOT_AVAILABLE"]
            for raw in [0, *none]:
                raws = {other.name: raw if other is signal else 0 for other in message.signals}
                data = message.encode(raws, scaling=False, strict=False)
                name, values = contract.decode_numbers(
                    can.Message(arbitration_id=message.frame_id, data=data, is_extended_id=False)
                )
                assert name == message.name
                scaled = message.decode(data, decode_choices=False)
                for other, value in zip(message.signals, values, strict=True):
                    if raw in none and other is signal:
                        assert math.isnan(value)
                        seen.add(signal.name)
                    else:
                        assert value == scaled[other.name], (name, other.name)
    assert seen == {"StatorTemperature", "RotorTemperature", "InverterTemperature"}
