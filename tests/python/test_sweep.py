"""scripts/sweep with sextant-mil: results, failures, interruption, and Dask with its processes."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet
import pytest
from programs import program
from sextant_py.paths import ROOT

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
QUICK = f"""scenario = "{SCENARIO}"
[set]
duration_s = 0.25
plant.integrator = "fixed"
expect.torque_ripple_pp_nm.max = 15
[grid]
drive.period_us = [20, 25, 50]
control.flux_reference_wb = [0.9, 1.1]
[plot]
metrics = ["torque_ripple_pp_nm"]
"""
ENDLESS = QUICK.replace("duration_s = 0.25", "duration_s = 100000").replace("[set]", "time_limit_s = 100\n[set]")


def without_progress(said: str) -> str:
    """What a sweep says besides how far it is, which it says every ten seconds: on a busy machine more often."""
    return re.sub(r"^sweep: \d+ of \d+ points, \d+ failed\n", "", said, flags=re.MULTILINE)


@dataclass
class Bench:
    """A sweep file and its directory."""

    directory: Path
    mil: Path

    @property
    def out(self) -> Path:
        return self.directory / "out"

    def write(self, text: str) -> None:
        (self.directory / "sweep.toml").write_text(text, encoding="utf-8")

    def words(self, *options: str) -> list[str]:
        where = ["--out", str(self.out), "--mil", str(self.mil)]
        return [str(ROOT / "scripts" / "sweep"), str(self.directory / "sweep.toml"), *where, *options]

    def run(self, *options: str) -> subprocess.CompletedProcess:
        found = subprocess.run(
            self.words(*options), capture_output=True, text=True, timeout=2400, stdin=subprocess.DEVNULL
        )
        found.stderr = without_progress(found.stderr)
        return found

    def start(self, *options: str) -> subprocess.Popen:
        """In a process group of its own, as a shell starts it."""
        return subprocess.Popen(
            self.words(*options),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            process_group=0,
        )

    def records(self) -> dict[int, dict]:
        file = self.out / "points.jsonl"
        lines = file.read_text(encoding="utf-8").splitlines(keepends=True) if file.exists() else []
        return {record["point"]: record for record in map(json.loads, (line for line in lines if line.endswith("\n")))}

    def rows(self) -> list[dict]:
        return pyarrow.parquet.read_table(self.out / "table.parquet").to_pylist()

    def programs(self) -> list[int]:
        """The runs of sextant-mil that are left."""
        found = []
        for process in Path("/proc").glob("[0-9]*"):
            try:
                command = (process / "cmdline").read_bytes()
            except OSError:
                continue
            # A program, or a script and its shell. The sweep itself names the program further behind.
            if any(word.startswith(os.fsencode(self.mil)) for word in command.split(b"\0")[:2]):
                found.append(int(process.name))
        return found


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    """Its sextant-mil has a path of its own, by which its processes are known."""
    mil = tmp_path / "copy-of-sextant-mil"
    mil.write_bytes(program("sextant-mil").read_bytes())
    mil.chmod(0o755)
    return Bench(tmp_path, mil)


def eventually(condition: Callable[[], object], seconds: float = 480) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.02)


def communicate(process: subprocess.Popen, seconds: float) -> tuple[str, str]:
    """Both its outputs, at its end."""
    printed, said = process.communicate(timeout=seconds)
    return printed, without_progress(said)


def end(process: subprocess.Popen, number: int = signal.SIGTERM) -> tuple[str, str]:
    """The whole group has the signal, as from Ctrl-C at a terminal."""
    os.killpg(process.pid, number)
    return communicate(process, 480)


PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")


def test_examples_of_the_page_for_coupled_keys_and_lists_run(bench: Bench) -> None:
    """Whole, but for the scenario's path and the length of a run."""
    grid, _, coupled, listed = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    head = grid[: grid.index("[grid]")].replace("../scenarios/reversal.toml", str(SCENARIO))
    head = head.replace("duration_s = 1.0", "duration_s = 0.25")
    bench.write(head + coupled + grid[grid.index("[plot]") :])
    found = bench.run("--dry-run")
    assert "grid of 6 points" in found.stdout
    found = bench.run()
    assert found.stderr == ""
    rows = bench.rows()
    assert [(row["machine.r_s_ohm"], row["machine.r_r_ohm"]) for row in rows[::2]] == [
        (0.4, 0.3), (0.48, 0.36), (0.55, 0.41),
    ]  # fmt: skip
    assert [row["control.dtc.torque_band_upper_nm"] for row in rows] == [0.459, 0.918] * 3
    assert all(row["torque_ripple_pp_nm"] > 0 for row in rows)
    assert (bench.out / "torque_ripple_pp_nm.png").is_file()
    (points,) = re.findall(r"^```csv\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    (bench.directory / "points.csv").write_text(points, encoding="utf-8")
    bench.write(listed + head)
    found = bench.run("--restart")
    assert found.stderr == ""
    assert [row["control.controller"] for row in bench.rows()] == ["dtc", "foc", "foc"]
    assert len({row["torque_ripple_pp_nm"] for row in bench.rows()}) == 3


def test_an_unknown_key_of_a_list_is_refused_by_the_list(bench: Bench) -> None:
    (bench.directory / "points.csv").write_text("# two keys\n\nmachine.r_s,drive.period_us\n1,2\n", encoding="utf-8")
    bench.write(f'scenario = "{SCENARIO}"\npoints = "points.csv"\n')
    found = bench.run()
    assert found.returncode == 2
    assert "points.csv:3: machine.r_s: unknown key" in found.stderr
    bench.write(f'scenario = "{SCENARIO}"\n[[coupled]]\ndrive.period_us = [25]\nmachine.r_s = [1]\n')
    assert "sweep.toml:4: machine.r_s: unknown key" in bench.run().stderr


def test_a_grid_becomes_a_table_and_a_picture(bench: Bench) -> None:
    bench.write(QUICK)
    found = bench.run("--csv")
    assert (found.returncode, found.stderr) == (0, "")
    assert found.stdout.splitlines()[-1].startswith("sweep: 6 of 6 points ran: ")
    rows = bench.rows()
    assert [row["point"] for row in rows] == list(range(6))
    assert [row["drive.period_us"] for row in rows] == [20, 20, 25, 25, 50, 50]
    for row in rows:
        # The flux follows its reference: every point ran with its own values.
        assert row["flux_mean_wb"] == pytest.approx(row["control.flux_reference_wb"], rel=0.02)
        assert row["simulated_s"] == pytest.approx(0.25)
        missed = row["torque_ripple_pp_nm"] > 15 or not 1.0 <= row["flux_mean_wb"] <= 1.2
        assert (row["status"] == "ok") != missed
        assert bool(row["reason"]) == missed
    assert {row["status"] for row in rows} == {"ok", "expect_failed"}
    assert "torque_ripple_pp_nm is" in rows[5]["reason"]
    assert (bench.out / "torque_ripple_pp_nm.png").read_bytes().startswith(b"\x89PNG")
    assert len((bench.out / "table.csv").read_text().splitlines()) == 7
    judged = bench.run("--fail-on-expect")  # of the finished points
    assert judged.returncode == 1
    assert "with an [expect] that does not hold" in judged.stderr


def test_a_finished_sweep_runs_nothing(bench: Bench) -> None:
    bench.write(QUICK)
    assert bench.run("--no-plot").returncode == 0
    before = bench.records()
    found = bench.run()
    assert found.returncode == 0, found.stderr
    assert "6 of 6 points are finished" in found.stdout
    assert "to run" not in found.stdout
    assert bench.records() == before
    changed = QUICK.replace("[20, 25, 50]", "[25, 50]")
    bench.write(changed)
    found = bench.run()
    assert found.returncode == 2
    assert "the sweep file changed since" in found.stderr
    assert bench.run("--restart").returncode == 0
    assert len(bench.rows()) == 4


def test_a_file_that_a_point_names_belongs_to_the_sweep(bench: Bench) -> None:
    machine = bench.directory / "machine.toml"
    machine.write_bytes((ROOT / "configs" / "machines" / "paper_3hp.toml").read_bytes())
    bench.write(QUICK.replace("drive.period_us = [20, 25, 50]", 'machine = ["machine.toml"]'))
    assert bench.run("--no-plot").returncode == 0
    machine.write_text(machine.read_text().replace("0.435", "0.5"))
    found = bench.run()
    assert found.returncode == 2
    assert "the scenario or a file that it names changed since" in found.stderr


def test_a_random_sample_prints_its_seed_and_repeats(bench: Bench) -> None:
    ranges = "[random]\nsamples = 20\nseed = 41\n[random.ranges]\nmachine.r_r_ohm = { from = 0.4, to = 1.6 }\n"
    bench.write(QUICK[: QUICK.index("[grid]")] + ranges)
    outcomes = []
    for _ in range(2):
        found = bench.run("--restart")
        assert found.returncode == 0, found.stderr
        assert "seed 41" in found.stdout
        outcomes.append([(row["machine.r_r_ohm"], row["torque_ripple_rms_nm"]) for row in bench.rows()])
    assert outcomes[0] == outcomes[1]
    assert len({ripple for _, ripple in outcomes[0]}) == 20


def wrapped(bench: Bench, where: str, command: str) -> Path:
    """A sextant-mil that does something else first at the points whose call has these words. Returns the real one."""
    folder = bench.mil.with_name("real")
    folder.mkdir()
    real = bench.mil.rename(folder / bench.mil.name)
    bench.mil.write_text(
        f'#!/bin/sh\ncase "$*" in *--print-config*) ;; *{where}*) {command} ;; esac\nexec {real} "$@"\n'
    )
    bench.mil.chmod(0o755)
    return real


def crashing(bench: Bench, where: str) -> None:
    """A sextant-mil that dies of a segmentation fault at the points whose call has these words."""
    wrapped(bench, where, "kill -SEGV $$")


SPEAKS = """import logging
from sextant_py import sweep_cluster
with sweep_cluster.local_client(1) as client:
    for name in ("asyncio", *list(logging.root.manager.loggerDict)):
        if name.startswith(("asyncio", "distributed", "tornado")):
            print(name)
            logging.getLogger(name).error("of %s", name)
"""


@dataclass
class Hold:
    """Points that run until they are released, however fast the machine is."""

    file: Path
    real: Path

    def release(self) -> None:
        self.file.unlink()


def held(bench: Bench, where: str = "") -> Hold:
    """A sextant-mil that waits at the points whose call has these words."""
    file = bench.directory / "hold"
    file.touch()
    return Hold(file, wrapped(bench, where, f"while [ -e {file} ]; do sleep 0.02; done"))


def test_failed_points_have_a_reason_and_stop_nothing(bench: Bench) -> None:
    crashing(bench, "drive.period_us=50")
    bench.write(QUICK.replace("[20, 25, 50]", "[25, 0.1, 50]").replace("[0.9, 1.1]", "[1.05, 1.1]"))
    found = bench.run()
    assert found.returncode == 1
    rows = bench.rows()
    assert [row["status"] for row in rows] == ["ok", "ok", "failed", "failed", "failed", "failed"]
    assert rows[2]["reason"].startswith("--set: drive.period_us: expected a number from 1 to 100000, got 0.1")
    assert rows[4]["reason"].startswith("copy-of-sextant-mil was ended by signal SIGSEGV")
    assert rows[2]["torque_ripple_pp_nm"] is None
    last = found.stderr.splitlines()[-1]
    assert "2 ok, 0 with an [expect] that does not hold, 4 failed; the first is point 2: --set: drive.period_us" in last
    # Once more, only those that failed, and all the better now that nothing crashes.
    before = bench.records()
    kept = {k: before[k] for k in (0, 1)}
    found = bench.run("--retry-failed")
    assert "4 points to run" in found.stdout
    assert {k: bench.records()[k] for k in (0, 1)} == kept


def test_a_point_beyond_its_time_limit_is_ended(bench: Bench) -> None:
    bench.write(ENDLESS.replace("[20, 25, 50]", "[20]"))
    found = bench.run("--time-limit", "0.5")
    assert found.returncode == 1
    assert {row["reason"] for row in bench.rows()} == {"no result within the time limit of 0.5 s"}
    assert bench.programs() == []


def test_a_drive_that_trips_has_failed(bench: Bench) -> None:
    bench.write(QUICK.replace("[grid]", "protection.over_current_a = 30\n[grid]").replace("[20, 25, 50]", "[25]"))
    found = bench.run()
    assert found.returncode == 1
    assert all(row["status"] == "failed" and "the drive tripped with" in row["reason"] for row in bench.rows())


LAST = "drive.period_us=50"  # the last two of the six points


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_sweep_resumes(bench: Bench, number: int) -> None:
    hold = held(bench, LAST)
    bench.write(QUICK)
    sweep = bench.start("--workers", "1")
    eventually(lambda: len(bench.records()) == 4 and bench.programs())
    _, said = end(sweep, number)
    assert sweep.returncode == 130, said
    eventually(lambda: bench.programs() == [])
    kept = bench.records()
    assert sorted(kept) == [0, 1, 2, 3]
    assert "failed" not in {record["status"] for record in kept.values()}
    assert said.splitlines()[-1].startswith("sweep: interrupted; 4 of 6 points are finished and kept in")
    hold.release()
    found = bench.run()
    assert found.returncode == 0, found.stderr
    assert "2 points to run" in found.stdout
    after = bench.records()
    assert {k: after[k] for k in kept} == kept
    assert [row["point"] for row in bench.rows()] == list(range(6))


def test_a_killed_sweep_resumes(bench: Bench) -> None:
    hold = held(bench, LAST)
    bench.write(QUICK)
    sweep = bench.start("--workers", "1")
    eventually(lambda: len(bench.records()) == 4)
    end(sweep, signal.SIGKILL)
    kept = bench.records()
    assert len(kept) == 4
    with (bench.out / "points.jsonl").open("a") as file:
        file.write('{"point": 5, "sta')
    hold.release()
    found = bench.run()
    assert found.returncode == 0, found.stderr
    after = bench.records()
    assert {k: after[k] for k in kept} == kept
    assert len(bench.rows()) == 6


def test_two_sweeps_run_beside_each_other_but_not_in_one_directory(bench: Bench, tmp_path: Path) -> None:
    hold = held(bench, LAST)
    bench.write(QUICK)
    sweep = bench.start("--workers", "1")
    eventually(lambda: bench.records())
    found = bench.run()
    assert found.returncode == 2
    assert "another sweep runs in" in found.stderr
    other = Bench(bench.directory, hold.real)
    found = other.run("--out", str(tmp_path / "other"), "--workers", "1", "--no-plot")
    assert (found.returncode, found.stderr) == (0, "")
    assert sweep.poll() is None
    hold.release()
    _, said = communicate(sweep, 960)
    assert (sweep.returncode, said) == (0, "")


def test_dry_run_prints_the_points(bench: Bench) -> None:
    bench.write(QUICK)
    found = bench.run("--dry-run")
    assert (found.returncode, found.stderr) == (0, "")
    lines = found.stdout.splitlines()
    assert lines[1:4] == [
        "everywhere duration_s=0.25",
        'everywhere plant.integrator="fixed"',
        "everywhere expect.torque_ripple_pp_nm.max=15",
    ]
    assert lines[4] == "0 drive.period_us=20 control.flux_reference_wb=0.9"
    assert len(lines) == 10
    assert not bench.out.exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("drive.period_us", "drive.perod_us", ":7: drive.perod_us: unknown key; the nearest known one is"),
        ("duration_s", "duraton_s", ":3: duraton_s: unknown key"),
        ("duration_s = 0.25", "duration_s = -1", "the scenario is refused: --set: duration_s: expected a number"),
        ('["torque_ripple_pp_nm"]', '["ripple"]', ':10: plot.metrics: no metric is called "ripple"; known are torque_'),
    ],
)
def test_what_the_scenario_does_not_know_is_refused_before_anything_runs(
    bench: Bench, old: str, new: str, words: str
) -> None:
    bench.write(QUICK.replace(old, new))
    found = bench.run()
    assert found.returncode == 2
    assert found.stdout == ""
    assert words in found.stderr
    assert found.stderr.count("\n") == 1
    assert not bench.out.exists()


def test_a_scenario_that_needs_a_point_to_stand(bench: Bench) -> None:
    """Shorter than its window of metrics: only with the grid's values is it a scenario."""
    text = QUICK.replace("duration_s = 0.25", "duration_s = 0.1").replace("[0.9, 1.1]", "[1.1]")
    bench.write(text.replace("[plot]", "metrics.window_from_s = [0.5, 0.05]\n[plot]"))
    found = bench.run()
    assert found.returncode == 1
    assert [row["status"] == "failed" for row in bench.rows()] == [True, False] * 3
    assert "the window of the metrics begins after the run has ended" in bench.rows()[0]["reason"]


def test_programs_that_are_none(bench: Bench) -> None:
    bench.write(QUICK)
    found = Bench(bench.directory, bench.directory / "none").run()
    assert (found.returncode, found.stderr) == (2, f"sweep: --mil: {bench.directory}/none is not a program.\n")
    for wrong in (["--workers", "0"], ["--time-limit", "-1"], ["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"]):
        found = bench.run(*wrong)
        assert found.returncode == 2
        assert wrong[0] in found.stderr.splitlines()[-1]


@dataclass
class Cluster:
    """A Dask scheduler and its workers, each a process of its own that has nothing of this tree."""

    address: str
    scheduler: subprocess.Popen
    workers: dict[str, subprocess.Popen]


def dask(program_name: str, *options: str, cwd: Path) -> subprocess.Popen:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with (cwd / "dask.log").open("a") as log:
        return subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{program_name}", "--no-dashboard", *options],
            cwd=cwd, env=environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL,
        )  # fmt: skip


@pytest.fixture
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    directory = tmp_path_factory.mktemp("dask")
    file = directory / "scheduler.json"
    scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file), cwd=directory)
    workers = {}
    try:
        eventually(lambda: file.exists() and file.read_text().rstrip().endswith("}"))
        address = json.loads(file.read_text())["address"]
        for name in ("first", "second"):
            options = ("--name", name, "--nthreads", "1", "--no-nanny", "--death-timeout", "480")
            workers[name] = dask("worker", address, *options, cwd=directory)
        from distributed import Client

        with Client(address, timeout=240) as client:
            client.wait_for_workers(2, timeout=480)
        yield Cluster(address, scheduler, workers)
    finally:
        for process in (*workers.values(), scheduler):
            process.kill()
            process.wait()


def test_a_scheduler_and_two_workers(bench: Bench, cluster: Cluster) -> None:
    hold = held(bench)
    bench.write(QUICK)
    sweep = bench.start("--scheduler", cluster.address)
    eventually(lambda: len(bench.programs()) == 2)
    hold.release()
    printed, said = communicate(sweep, 960)
    assert sweep.returncode == 0, said
    assert f"2 at a time on scheduler {cluster.address}" in printed
    assert {record["worker"] for record in bench.records().values()} == {"first", "second"}
    assert len(bench.rows()) == 6
    assert all(row["simulated_s"] == pytest.approx(0.25) for row in bench.rows())


def test_interrupted_workers_end_their_points(bench: Bench, cluster: Cluster) -> None:
    bench.write(ENDLESS)
    sweep = bench.start("--scheduler", cluster.address)
    eventually(lambda: len(bench.programs()) == 2)
    _, said = end(sweep, signal.SIGINT)
    assert sweep.returncode == 130, said
    eventually(lambda: bench.programs() == [])
    bench.write(QUICK)
    assert bench.run("--restart", "--scheduler", cluster.address).returncode == 0


def test_a_worker_that_dies_does_not_stop_the_rest(bench: Bench, cluster: Cluster) -> None:
    hold = held(bench, LAST)
    bench.write(QUICK)
    sweep = bench.start("--scheduler", cluster.address)
    eventually(lambda: len(bench.records()) == 4 and len(bench.programs()) == 2)
    cluster.workers["first"].kill()
    hold.release()
    _, said = communicate(sweep, 960)
    assert sweep.returncode == 0, said
    assert len(bench.rows()) == 6


def test_a_scheduler_that_dies_leaves_what_is_finished(bench: Bench, cluster: Cluster) -> None:
    hold = held(bench, LAST)
    bench.write(QUICK)
    sweep = bench.start("--scheduler", cluster.address)
    eventually(lambda: len(bench.records()) == 4)
    cluster.scheduler.kill()
    _, said = communicate(sweep, 480)
    assert sweep.returncode == 1
    assert said == "sweep: the Dask scheduler is gone; the finished points are kept and the same command resumes.\n"
    kept = bench.records()
    hold.release()
    assert bench.run().returncode == 0
    assert {k: bench.records()[k] for k in kept} == kept


def test_dask_says_nothing_of_its_own() -> None:
    """Not even of a long garbage collection or a failed callback: each logger by itself."""
    found = subprocess.run(
        [sys.executable, "-c", SPEAKS], capture_output=True, text=True, timeout=480, cwd=ROOT / "scripts", check=True
    )
    assert "distributed.gc" in found.stdout.split()
    assert found.stderr == ""


def test_no_scheduler(bench: Bench, udp_port: int) -> None:
    bench.write(QUICK)
    for address in (f"tcp://127.0.0.1:{udp_port}", "nonsense", "tcp://"):
        found = bench.run("--scheduler", address)
        assert found.returncode == 2
        assert found.stderr.startswith(f"sweep: --scheduler: no Dask scheduler answers at {address}")
        assert found.stderr.count("\n") == 1
