"""The list of telemetry signals: IDL, records and JSON agree, incomplete ones are refused, old and new meet."""

import re
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from cyclonedds.idl import types
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from programs import program
from sextant_py import dds, telemetry_contract, telemetry_types
from sextant_py.errors import UserError
from sextant_py.paths import IDL, ROOT, TELEMETRY
from sextant_py.telemetry_contract import enumerations, enumerators, signals

TOPICS = (dds.TELEMETRY, dds.STATE, dds.STATISTICS)
PATIENCE_S = 120.0


def made_by_cmake(idl: Path, output: Path) -> subprocess.CompletedProcess:
    script = ROOT / "cmake" / "SextantTelemetry.cmake"
    command = ["cmake", f"-DIDL={idl}", f"-DOUTPUT={output}", "-P", script]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)


@pytest.mark.parametrize(
    ("struct", "header", "member_list", "publishers"),
    [
        ("DriveTelemetry", "core/telemetry_record.hpp", "TELEMETRY_MEMBERS", ("drive_id", "sequence", "dropped")),
        ("DriveState", "comms/real_time_sample.hpp", "DRIVE_STATE_MEMBERS", ("drive_id", "sequence")),
        ("RealTimeStatistics", "comms/real_time_sample.hpp", "REAL_TIME_MEMBERS", ("drive_id", "sequence")),
        ("DriveWaveform", "comms/waveform_batch.hpp", "WAVEFORM_MEMBERS", ("drive_id", "sequence", "dropped")),
    ],
)
def test_idl_records_and_json_have_the_same_list(
    tmp_path: Path, struct: str, header: str, member_list: str, publishers: tuple[str, ...]
) -> None:
    made = made_by_cmake(IDL, tmp_path)
    assert made.returncode == 0, made.stderr
    text = (tmp_path / "include" / "sextant" / header).read_text(encoding="utf-8")
    lines = re.search(rf"#define SEXTANT_{member_list}\(X\)((?: \\\n[^\n]*\))+)\n", text)[1]
    of_record = [(signal.name, signal.unit, signal.text) for signal in signals(struct) if signal.name not in publishers]
    assert re.findall(r'X\((\w+), "(.*)", "(.*)"\)', lines) == of_record
    if struct != "DriveState":
        assert re.findall(r"^  \S+(?: \d+>)? (\w+)\{\};  ///< (.*) \[(.*)\]$", text, re.MULTILINE) == [
            (name, what, unit) for name, unit, what in of_record
        ]
    page = (tmp_path / "docs" / "telemetry.md").read_text(encoding="utf-8")
    table = page.partition(f"## sextant/{struct}\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.*) \| (.*) \| (.*) \|$", table, re.MULTILINE)
    assert rows == [(signal.name, signal.type, signal.unit, signal.text) for signal in signals(struct)]


def test_enumerators_are_those_of_cpp(tmp_path: Path) -> None:
    assert made_by_cmake(IDL, tmp_path).returncode == 0
    headers = "".join(file.read_text(encoding="utf-8") for file in tmp_path.glob("include/sextant/*/*.hpp"))
    listed = re.findall(r"X\(\w+, (\w+), ([A-Z0-9_]+)\)", headers)
    assert sorted(upper for _, upper in listed) == sorted(name for one in enumerations() for name in enumerators(one))
    assert all(lower.upper() == upper for lower, upper in listed)


def test_a_statistic_says_which_it_is() -> None:
    texts = {signal.name: (signal.unit, signal.text) for signal in signals("DriveTelemetry")}
    assert texts["torque_mean_nm"] == ("N·m", "estimated torque where control periods begin, mean over the interval")
    assert texts["torque_max_nm"] == ("N·m", "estimated torque where control periods begin, maximum over the interval")
    texts = {signal.name: (signal.unit, signal.text) for signal in signals("RealTimeStatistics")}
    assert texts["execution_p99_9_us"] == ("µs", "execution time of one wake-up, 99.9 % quantile over the interval")


@pytest.mark.parametrize(
    ("old", "new", "objection"),
    [
        (r"    float power_w; .*", "    float power_w;", "DriveTelemetry.power_w has no unit and text"),
        (r"    float power_w; .*", "    float power_w;  // the power", "DriveTelemetry.power_w has no unit and text"),
        (r"    float torque_mean_nm; .*\n", "", "DriveTelemetry.torque_min_nm has no unit and text"),
        (
            r"estimated torque where control periods begin, mean over",
            "estimated torque over",
            "DriveTelemetry.torque_min_nm has no unit and text",
        ),
        (
            r"requested_nm; {2,}// \[N·m\] r",
            'requested_nm; // [N·m] "r',
            "DriveTelemetry.torque_requested_nm: the text must be without",
        ),
        (r"    octet sector; ", "    uint8 sector; ", 'DriveTelemetry.sector has the type "uint8"'),
        (r"    octet sector; ", "    octet sector[2]; ", "which is not a member"),
        (r"struct RealTimeStatistics", "struct Statistics", "has no struct RealTimeStatistics"),
        (r"enum WaitKind", "enum WaitMode", "has no enumeration WaitKind"),
        (r"SPIN, HYBRID", "SPIN, hybrid", 'WaitKind has "hybrid", which is not an enumerator'),
        (r"SPIN, HYBRID", "SPIN HYBRID", 'WaitKind has "SPIN HYBRID", which is not an enumerator'),
        (r"SPIN, HYBRID", "SPIN, HYBRID,", 'WaitKind has "", which is not an enumerator'),
        (r"SPIN, HYBRID", "SPIN, /* both */ HYBRID", 'WaitKind has "/* both */ HYBRID", which is not an enumerator'),
    ],
)
def test_an_incomplete_list_is_refused(tmp_path: Path, old: str, new: str, objection: str) -> None:
    text, count = re.subn(old, new, IDL.read_text(encoding="utf-8"))
    assert count == 1
    idl = tmp_path / "changed.idl"
    idl.write_text(text, encoding="utf-8")
    made = made_by_cmake(idl, tmp_path)
    assert made.returncode != 0
    assert objection in re.sub(r"\s+", " ", made.stderr)
    assert idl.name in made.stderr


@pytest.mark.parametrize(
    ("before", "seed"),
    [
        (r"    octet sector;", "    octet sector[2];  // [1] the sector"),
        (r"    INIT, STANDBY", "    init,"),
        (r"    boolean memory_locked;", "    boolean memory_lock;"),
    ],
)
def test_a_refusal_names_the_line(tmp_path: Path, before: str, seed: str) -> None:
    lines = IDL.read_text(encoding="utf-8").splitlines()
    at = next(index for index, line in enumerate(lines) if line.startswith(before))
    idl = tmp_path / "changed.idl"
    idl.write_text("\n".join([*lines[:at], seed, *lines[at:]]) + "\n", encoding="utf-8")
    made = made_by_cmake(idl, tmp_path)
    assert made.returncode != 0
    assert f"changed.idl:{at + 1}:" in re.sub(r"\s+", "", made.stderr)


def test_comments_digits_and_empty_lines_are_read(tmp_path: Path) -> None:
    text = IDL.read_text(encoding="utf-8")
    changed = text.replace(
        "    INIT, STANDBY, ", "    // states of the FSM, {in} order\n    INIT, MODE_2, // SPARE\n\n    "
    )
    changed = changed.replace("    octet sector;", "\n    octet sector;")
    assert len(changed.splitlines()) == len(text.splitlines()) + 4
    idl = tmp_path / "changed.idl"
    idl.write_text(changed, encoding="utf-8")
    made = made_by_cmake(idl, tmp_path)
    assert made.returncode == 0, made.stderr
    header = (tmp_path / "include" / "sextant" / "core" / "telemetry_record.hpp").read_text(encoding="utf-8")
    states = re.findall(r"X\(DriveState, (\w+), (\w+)\)", header)
    assert states[:3] == [("init", "INIT"), ("mode_2", "MODE_2"), ("ready", "READY")]
    assert "X(sector, " in header


def test_the_json_is_what_the_publisher_describes() -> None:
    done = subprocess.run([program("sextant-telemetry"), "--describe"], capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    assert TELEMETRY.read_text(encoding="utf-8") == done.stdout, (
        f"write it anew: sextant-telemetry --describe > {TELEMETRY.relative_to(ROOT)}"
    )


def test_a_contract_that_is_not_there_or_no_json_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "telemetry.json"
    monkeypatch.setattr(telemetry_contract, "TELEMETRY", file)
    with pytest.raises(UserError, match=r"telemetry\.json cannot be read"):
        telemetry_contract._contract.__wrapped__()
    file.write_text("{", encoding="utf-8")
    with pytest.raises(UserError, match=r"telemetry\.json is no JSON"):
        telemetry_contract._contract.__wrapped__()
    with pytest.raises(UserError, match="has no struct Nothing"):
        telemetry_contract.signals("Nothing")


def read_from_a_writer_of(kind: type, topic: str, domain: int, **values: object) -> Any:
    """A sample of that type as the reader of this version takes it, with t_ns of 7."""
    node = dds.Node(domain)
    qos = dds.streaming_qos(1) if topic == dds.TELEMETRY else dds.latched_qos()
    writer = DataWriter(node.participant, Topic(node.participant, topic, kind), qos)
    telemetry = dds.Telemetry(domain)
    subscription = {dds.TELEMETRY: telemetry.stream, dds.STATE: telemetry.states}.get(topic, telemetry.statistics)
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        writer.write(telemetry_types.sample(kind, drive_id=1, t_ns=7, **values))
        telemetry.node.poll()
        if samples := subscription.poll():
            return samples[0]
        time.sleep(0.01)
    pytest.fail(subscription.diagnosis())


@pytest.mark.parametrize("topic", TOPICS)
def test_a_drive_of_an_earlier_version_is_read(domain: int, topic: str) -> None:
    name = topic.partition("/")[2]
    fields = telemetry_types.fields(name)
    last = list(fields)[-1]
    read = read_from_a_writer_of(telemetry_types.struct(name, without=(last,)), topic, domain)
    whole = telemetry_types.sample(telemetry_types.struct(name), drive_id=1, t_ns=7)
    assert {field: getattr(read, field) for field in fields} == {field: getattr(whole, field) for field in fields}
    assert not getattr(read, last)


@pytest.mark.parametrize("topic", TOPICS)
def test_a_drive_of_a_later_version_is_read(domain: int, topic: str) -> None:
    name = topic.partition("/")[2]
    later = telemetry_types.declared(name, {**telemetry_types.fields(name), "added": types.float32})
    read = read_from_a_writer_of(later, topic, domain, added=2.5)
    assert (read.t_ns, read.added) == (7, 2.5)
