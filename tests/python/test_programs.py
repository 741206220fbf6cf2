"""The programs with bad input: one clear sentence on stderr, an exit status that is not zero, nothing half-written."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from programs import ProgramProcess, program
from sextant_py.paths import LOOPBACK, ROOT

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
ECU_CONFIG = ROOT / "configs" / "ecu.toml"
CRASH_WORDS = ("terminate called", "what():", "Aborted", "Segmentation", "Sanitizer", "Traceback", "filesystem error")
NOBODY = 65534
REFUSED = 2  # exit status of every program that cannot run


def run(
    name: str | Path, *arguments: object, before: tuple[str, ...] = (), **environment: str
) -> subprocess.CompletedProcess:
    return subprocess.run(
        [*before, name if isinstance(name, Path) else program(name), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=240,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8"), **environment},
    )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("sextant-mil", ("--help",)),
        ("sextant-mil", (ROOT / "configs/scenarios/constant_torque.toml", "--print-config")),
        ("sextant-ecu", (ECU_CONFIG, "--virtual-time", "--duration", "0.01")),
        ("sextant-ecu", ("--version",)),
        ("sextant-plant", ("--print-config",)),
        ("sextant-telemetry", ("--describe",)),
    ],
)
def test_a_full_standard_output_is_told(name: str, words: tuple[object, ...]) -> None:
    with Path("/dev/full").open("w") as full:
        found = subprocess.run(
            [program(name), *map(str, words)], stdout=full, stderr=subprocess.PIPE, text=True, timeout=240, cwd=ROOT
        )
    assert found.returncode == 1
    start = f"{name}: the standard output cannot be written: "
    assert found.stderr in (start + "No space left on device\n", start + "its file system may be full\n")


def test_a_standard_output_that_was_closed_before_is_none() -> None:
    command = f"{program('sextant-telemetry')} --describe >&-"
    found = subprocess.run(["bash", "-c", command], stderr=subprocess.PIPE, text=True, timeout=240)
    assert (found.returncode, found.stderr) == (0, "")


def test_lines_of_the_log_count_on_the_clock_of_the_recordings(live: tuple[str, ...]) -> None:
    begin = time.monotonic()
    found = run("sextant-ecu", *live)
    end = time.monotonic()
    lines = [re.match(r"\d\d:\d\d:\d\d\.\d{3} (\d+\.\d{6}) \w+ ", line) for line in found.stderr.splitlines()]
    times = [float(line[1]) for line in lines if line]
    assert times, found.stderr
    assert times == sorted(times)
    assert begin < times[0] <= times[-1] < end


def check_refusal(found: subprocess.CompletedProcess, name: str, *words: str) -> None:
    assert found.returncode == REFUSED, found
    assert found.stdout == ""
    lines = found.stderr.splitlines()
    assert len(lines) == 1, found.stderr
    assert lines[0].startswith(f"{name}: "), found.stderr
    for word in words:
        assert word in found.stderr, found.stderr
    assert not [word for word in CRASH_WORDS if word in found.stderr]


@pytest.fixture
def live(bus_address: str, domain: int) -> tuple[str, ...]:
    """Arguments with which sextant-ecu would run, briefly."""
    return (str(ECU_CONFIG), "--can", bus_address, "--duration", "0.2", "--set", f"dds.domain={domain}")


@pytest.fixture
def for_anyone() -> Iterator[Path]:
    """Copies of the programs and of configs that any user reaches; the checkout may lie in somebody's private home."""
    with tempfile.TemporaryDirectory() as directory:
        place = Path(directory)
        shutil.copytree(ROOT / "configs", place / "configs")
        for name in ("sextant-ecu", "sextant-telemetry", "sextant-mil"):
            shutil.copy(program(name), place)
        subprocess.run(["chmod", "-R", "a+rX", place], check=True)
        yield place


def test_the_arguments_are_good(live: tuple[str, ...]) -> None:
    found = run("sextant-ecu", *live)
    assert found.returncode == 0, found.stderr
    assert "control periods" in found.stdout


def kernel_has_can() -> bool:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return False
    return True


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("carrier_pigeon:1", ['"carrier_pigeon:1"', "socketcan:", "udp_multicast:"]),
        ("", ['""', "socketcan:"]),
        ("udp_multicast:1.2.3.4:43113", ['"1.2.3.4"', "224.0.0.0"]),
        ("udp_multicast:nowhere:43113", ['"nowhere"', "multicast group"]),
        ("udp_multicast:239.74.163.2:99999", ["port from 1 to 65535"]),
        ("udp_multicast:239.74.163.2", ["port from 1 to 65535"]),
    ],
)
def test_malformed_bus_address(address: str, words: list[str]) -> None:
    check_refusal(run("sextant-ecu", ECU_CONFIG, "--can", address), "sextant-ecu", *words)


def test_can_interface_that_does_not_exist() -> None:
    words = ['"can7"', "ip link"] if kernel_has_can() else ["no CAN sockets", "udp_multicast:"]
    check_refusal(run("sextant-ecu", ECU_CONFIG, "--can", "socketcan:can7"), "sextant-ecu", *words)


def test_dds_configuration_that_cannot_be_read(live: tuple[str, ...]) -> None:
    found = run("sextant-ecu", *live, "--set", "dds.config_uri=file:///no/such.xml")
    check_refusal(found, "sextant-ecu", "DDS cannot start", "/no/such.xml")


def test_dds_configuration_of_the_environment_that_cannot_be_read(live: tuple[str, ...]) -> None:
    found = run("sextant-ecu", *live, CYCLONEDDS_URI="file:///no/such.xml")
    check_refusal(found, "sextant-ecu", "DDS cannot start", "/no/such.xml")


@pytest.mark.parametrize(
    ("inner", "word"),
    [
        ("<Nonsense/>", "Nonsense: unknown element"),
        ('<General><Interfaces><NetworkInterface name="nope0"/></Interfaces></General>', "nope0"),
    ],
)
def test_dds_that_cannot_start(inner: str, word: str, live: tuple[str, ...]) -> None:
    found = run("sextant-ecu", *live, CYCLONEDDS_URI=f"<CycloneDDS><Domain>{inner}</Domain></CycloneDDS>")
    check_refusal(found, "sextant-ecu", "DDS cannot start", word)


@pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: rights can only be given up by one who has them")
def test_missing_rights_where_they_are_required(live: tuple[str, ...], for_anyone: Path) -> None:
    less = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", "--inh-caps=-all")
    limits = ("prlimit", "--rtprio=0", "--memlock=0")
    config = for_anyone / "configs" / "ecu.toml"
    required = ("--set", "realtime.required=true")
    found = run(for_anyone / "sextant-ecu", config, *live[1:], *required, before=(*less, *limits))
    check_refusal(found, "sextant-ecu", "realtime.required", "SCHED_FIFO", "CAP_SYS_NICE")


@pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: rights can only be given up by one who has them")
def test_missing_rights_are_reported_where_they_are_not_required(live: tuple[str, ...], for_anyone: Path) -> None:
    less = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", "--inh-caps=-all")
    config = for_anyone / "configs" / "ecu.toml"
    limits = ("prlimit", "--rtprio=0", "--memlock=0")
    found = run(for_anyone / "sextant-ecu", config, *live[1:], before=(*less, *limits))
    assert found.returncode == 0, found.stderr
    assert "SCHED_FIFO priority 80 was refused" in found.stderr


def test_an_absent_cpu_where_rights_are_required(live: tuple[str, ...]) -> None:
    found = run("sextant-ecu", *live, "--set", "realtime.required=true", "--set", "realtime.cpu=1000")
    check_refusal(found, "sextant-ecu", "realtime.required", "CPU 1000 was refused", "a CPU that this machine has")


def test_throttling_where_rights_are_required(live: tuple[str, ...]) -> None:
    runtime = Path("/proc/sys/kernel/sched_rt_runtime_us")
    if not runtime.exists() or runtime.read_text().strip() == "-1":
        pytest.skip("NOT TESTED: real-time throttling is off here")
    found = run("sextant-ecu", *live, "--set", "realtime.required=true")
    check_refusal(found, "sextant-ecu", "real-time throttling is on", "sysctl kernel.sched_rt_runtime_us=-1")


def test_a_stop_in_between_does_not_shorten_a_run(live: tuple[str, ...]) -> None:
    duration_s = 1.5
    begin = time.monotonic()
    command = [program("sextant-ecu"), *live[:3], "--duration", str(duration_s), *live[5:]]
    environment = {**os.environ, "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8")}
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment) as drive:
        assert any(b"control periods of" in line for line in drive.stderr), "it never started"
        for how in (signal.SIGSTOP, signal.SIGCONT):
            time.sleep(0.1)
            drive.send_signal(how)
        assert drive.wait(20) == 0
    assert time.monotonic() - begin >= duration_s


@pytest.mark.parametrize("wait", ["sleep", "hybrid", "spin"])
def test_hard_mode_runs_and_tells_its_stages(live: tuple[str, ...], wait: str) -> None:
    hard = ROOT / "configs" / "ecu_hard.toml"
    settings = ("realtime.required=false", "realtime.cpu=-1", f"realtime.wait={wait}")
    found = run("sextant-ecu", hard, *live[1:], *(word for text in settings for word in ("--set", text)))
    assert found.returncode == 0, found.stderr
    assert "no bound on its time" not in found.stderr
    rows = {line[:18].strip(): line.split()[-5:] for line in found.stdout.splitlines()}
    for stage in ("wake-up latency", "execution time", "read", "commands", "drive", "write", "push"):
        figures = [float(figure) for figure in rows[stage]]
        assert figures == sorted(figures), "percentiles grow"
    assert float(rows["execution time"][0]) >= float(rows["read"][0]) > 0


def test_cvode_without_slack_is_warned_of(live: tuple[str, ...]) -> None:
    settings = ("--set", "realtime.wake_every_periods=1", "--set", "plant.integrator=cvode")
    found = run("sextant-ecu", *live, *settings, "--set", "drive.period_us=200")
    assert found.returncode == 0, found.stderr
    assert 'plant.integrator = "cvode" has no bound on its time' in found.stderr


@pytest.mark.parametrize("name", ["sextant-ecu", "sextant-mil", "sextant-plant", "sextant-telemetry"])
def test_help_has_examples(name: str) -> None:
    said = run(name, "--help").stdout
    assert re.search(r"^Examples?:", said, re.MULTILINE)
    assert name in said.split("Example")[1]


@pytest.mark.parametrize("name", ["sextant-ecu", "sextant-mil", "sextant-plant", "sextant-telemetry"])
def test_help_has_the_same_exit_statuses(name: str) -> None:
    table = run(name, "--help").stdout.split("Exit status", 1)[1]
    rows = {int(status): word for status, word in re.findall(r"^ +(\d+) +(\w+) ", table, re.MULTILINE)}
    assert rows[REFUSED] == "refused"
    if name == "sextant-mil":
        assert (rows[3], rows[4]) == ("tripped", "no_torque")
    else:
        assert table.count("\n    0  done ") == table.count("\n    1  failed ") == 1
    if name == "sextant-ecu":
        assert (rows[3], rows[4]) == ("tripped", "no_torque")


@pytest.mark.parametrize(
    ("name", "file"),
    [("sextant-ecu", ECU_CONFIG), ("sextant-mil", SCENARIO), ("sextant-plant", ROOT / "configs" / "plant.toml")],
)
def test_a_wrong_key_has_the_same_status_in_every_program(name: str, file: Path) -> None:
    check_refusal(run(name, file, "--set", "no_such_key=1"), name, "no_such_key", "unknown key")
    check_refusal(run(name, file, "--no-such-option"), name, "--no-such-option")


def test_a_publisher_without_a_drive_is_refused() -> None:
    check_refusal(run("sextant-telemetry"), "sextant-telemetry", "start sextant-ecu")


BAD_SETTINGS = [
    ("command.torque_limit_nm=-4", ["command.torque_limit_nm", "got -4"]),
    ("command.torque_limit_nm=nan", ["command.torque_limit_nm", "got nan"]),
    ("command.torque_limit_nm=plenty", ["command.torque_limit_nm", "a number", "plenty"]),
    ("command.nonsense=4", ["command.nonsense", "unknown key"]),
    ("nonsense", ["key=value", '"nonsense"']),
    ("=", ["key=value"]),
    ("", ["key=value"]),
    ("control.controller=guess", ["control.controller", "dtc"]),
]


@pytest.mark.parametrize(("setting", "words"), BAD_SETTINGS)
def test_bad_setting_of_the_drive(setting: str, words: list[str], live: tuple[str, ...]) -> None:
    check_refusal(run("sextant-ecu", *live, "--set", setting), "sextant-ecu", *words)


@pytest.mark.parametrize(("setting", "words"), BAD_SETTINGS)
def test_bad_setting_of_a_scenario(setting: str, words: list[str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    check_refusal(run("sextant-mil", SCENARIO, "--out", out, "--set", setting), "sextant-mil", *words)
    assert not out.exists()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, ["bad.toml", "No such file"]),
        ("drive_id = ", ["bad.toml:1"]),
        ("drive_id = 1\nspeed = 3\n", ["bad.toml:2", "speed", "unknown key"]),
        ('machine = "missing.toml"\n', ["missing.toml"]),
    ],
)
def test_bad_configuration_file(content: str | None, words: list[str], tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    if content is not None:
        if "machine" not in content:
            shutil.copytree(ROOT / "configs" / "machines", tmp_path / "machines")
            content = content + 'machine = "machines/paper_3hp.toml"\n' if content.endswith("\n") else content
        path.write_text(content)
    check_refusal(run("sextant-ecu", path), "sextant-ecu", *words)


def test_configuration_that_is_a_directory(tmp_path: Path) -> None:
    check_refusal(run("sextant-ecu", tmp_path), "sextant-ecu", "directory")
    check_refusal(run("sextant-mil", tmp_path), "sextant-mil", "directory")


@pytest.mark.parametrize("name", ["sextant-ecu", "sextant-mil"])
def test_configuration_that_is_a_device(name: str) -> None:
    check_refusal(run(name, "/dev/zero"), name, "/dev/zero", "cannot be read: it is a device")


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("sextant-ecu", ["--frobnicate"], ["--frobnicate", "--help"]),
        ("sextant-ecu", ["--duration", "-3"], ["--duration", "-3"]),
        ("sextant-ecu", ["--duration", "1e300"], ["--duration", "1e300"]),
        ("sextant-ecu", ["--duration", "soon"], ["--duration", "soon"]),
        ("sextant-ecu", ["--set"], ["--set"]),
        ("sextant-mil", [], ["scenarios"]),
        ("sextant-mil", [SCENARIO, "--integrator", "euler"], ["euler", "cvode", "fixed"]),
        ("sextant-mil", [SCENARIO, "--out"], ["--out"]),
    ],
)
def test_bad_command_line(name: str, arguments: list[str], words: list[str], tmp_path: Path) -> None:
    check_refusal(run(name, *arguments), name, *words)


def test_missing_scenario_costs_the_others_nothing(tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = run("sextant-mil", SCENARIO, tmp_path / "missing.toml", "--out", out)
    check_refusal(found, "sextant-mil", "missing.toml", "No such file")
    assert not out.exists()


@pytest.mark.parametrize("jobs", ["0", "257", "1.5", "x", "nan", "-1"])
def test_a_number_of_jobs_that_is_none(jobs: str, tmp_path: Path) -> None:
    found = run("sextant-mil", SCENARIO, "--jobs", jobs, "--out", tmp_path / "out")
    said = (
        f"sextant-mil: --jobs: expected a whole number from 1 to 256, got {jobs}; sextant-mil --help lists the options"
    )
    assert (found.returncode, found.stderr) == (REFUSED, said + "\n")


@pytest.fixture
def hdf5_for_one_thread(tmp_path: Path) -> dict[str, str]:
    """An environment in which the HDF5 library says of itself that it is for one thread."""
    source, library = tmp_path / "one_thread.c", tmp_path / "one_thread.so"
    source.write_text("int H5is_library_threadsafe(_Bool* is_safe) { *is_safe = 0; return 0; }\n", encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
    return {"LD_PRELOAD": str(library)}


def test_traces_are_not_written_from_several_threads_where_hdf5_is_for_one(
    hdf5_for_one_thread: dict[str, str], tmp_path: Path
) -> None:
    other = tmp_path / "other.toml"
    other.write_text(f'base = "{SCENARIO}"\nname = "other"\n', encoding="utf-8")
    words = (SCENARIO, other, "--set", "duration_s=0.25", "--out", tmp_path / "out")
    found = run("sextant-mil", *words, "--jobs", "2", **hdf5_for_one_thread)
    check_refusal(
        found,
        "sextant-mil",
        "--jobs 2: the HDF5 library of this machine cannot write from several threads: give --no-trace",
    )
    assert not (tmp_path / "out").exists()
    for more in (("--jobs", "2", "--no-trace"), ("--jobs", "1"), ()):
        assert run("sextant-mil", *words, *more, **hdf5_for_one_thread).returncode != REFUSED, more


def test_out_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    found = run("sextant-mil", SCENARIO, "--out", tmp_path / "file" / "out")
    check_refusal(found, "sextant-mil", "file/out cannot be made", "Not a directory", "--out")


@pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: needs another user")
def test_out_that_may_not_be_written(for_anyone: Path) -> None:
    out = for_anyone / "out"
    out.mkdir(mode=0o755)
    less = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")
    scenario = for_anyone / SCENARIO.relative_to(ROOT)
    found = run(for_anyone / "sextant-mil", scenario, "--out", out, before=less)
    check_refusal(found, "sextant-mil", "out", "Permission denied")
    assert list(out.iterdir()) == []


@pytest.fixture
def long_run(tmp_path: Path) -> Iterator[ProgramProcess]:
    """A simulation of hours that has begun, with its results in tmp_path/out."""
    out = tmp_path / "out"
    command = [program("sextant-mil"), SCENARIO, "--set", "duration_s=10000", "--out", out]
    with ProgramProcess(command, tmp_path / "said") as process:
        deadline_s = time.monotonic() + 60
        while not (out / "trace.h5").is_file():
            assert process.is_running(), process.text()
            assert time.monotonic() < deadline_s, "it never started"
            time.sleep(0.02)
        yield process


def test_an_interrupted_run_leaves_its_summary(long_run: ProgramProcess, tmp_path: Path) -> None:
    long_run.send_signal(signal.SIGINT)
    assert long_run.wait(60) == 128 + signal.SIGINT
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["verdict"] == "interrupted"
    assert "interrupted at" in long_run.text()


def test_a_second_signal_ends_a_run_at_once(long_run: ProgramProcess, tmp_path: Path) -> None:
    for how in (signal.SIGSTOP, signal.SIGINT, signal.SIGTERM, signal.SIGCONT):
        long_run.send_signal(how)
    assert long_run.wait(60) == -signal.SIGTERM
    assert not (tmp_path / "out" / "summary.json").exists()
