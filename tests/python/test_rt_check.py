"""The inspection of a machine for hard real time, against machines made of files."""

import subprocess
from pathlib import Path

import pytest
from sextant_py import rt_check
from sextant_py.paths import ROOT

# A machine on which nothing is to be changed, for a control thread on CPU 3.
GOOD = {
    "proc/version": "Linux version 6.1.0-rt SMP PREEMPT_RT Debian",
    "proc/cmdline": "root=/dev/sda1 isolcpus=managed_irq,domain,2-3 nohz_full=2-3 rcu_nocbs=2,3",
    "proc/sys/kernel/sched_rt_runtime_us": "-1",
    "proc/sys/kernel/sched_rt_period_us": "1000000",
    "proc/self/status": "Name:\tpython\nCapEff:\t0000000000000000\n",
    "proc/irq/7/effective_affinity_list": "0",
    "proc/irq/8/effective_affinity_list": "1-2",
    "proc/stat": "cpu  100 0 100 9800 0 0 0 0 0 0",
    "proc/cpuinfo": "flags\t\t: fpu tsc constant_tsc nonstop_tsc",
    "proc/swaps": "Filename\tType\tSize\tUsed\tPriority",
    "sys/kernel/realtime": "1",
    "sys/devices/system/cpu/online": "0-3",
    "sys/devices/system/cpu/cpu3/cpufreq/scaling_governor": "performance",
    "sys/devices/system/cpu/cpu0/cpuidle/state0/latency": "0",
    "sys/devices/system/cpu/cpu3/cpuidle/state0/latency": "0",
    "sys/devices/system/cpu/cpu3/cpuidle/state0/name": "POLL",
    "sys/devices/system/cpu/cpu3/cpuidle/state0/disable": "0",
    "sys/devices/system/cpu/cpu3/cpuidle/state1/latency": "85",
    "sys/devices/system/cpu/cpu3/cpuidle/state1/name": "C6",
    "sys/devices/system/cpu/cpu3/cpuidle/state1/disable": "1",
    "sys/devices/system/cpu/cpu3/topology/thread_siblings_list": "3",
    "sys/devices/system/clocksource/clocksource0/current_clocksource": "tsc",
    "sys/kernel/mm/transparent_hugepage/enabled": "always madvise [never]",
}
GOOD_LIMITS = {"rtprio": 98, "memlock": -1}

# What is changed, which point must notice, what it says and what it recommends.
BAD = [
    (
        {"sys/kernel/realtime": None, "proc/version": "Linux version 6.18 SMP PREEMPT_DYNAMIC"},
        "kernel",
        "PREEMPT_DYNAMIC",
        "linux-image-rt-amd64",
    ),
    (
        {"proc/sys/kernel/sched_rt_runtime_us": "950000"},
        "throttling",
        "50 ms of each 1000 ms",
        "sysctl kernel.sched_rt_runtime_us=-1",
    ),
    ({"proc/cmdline": "isolcpus=3 rcu_nocbs=3"}, "isolation", "nohz_full do not name it", '"nohz_full=3"'),
    ({"proc/cmdline": ""}, "isolation", "CPU 3 is shared", '"isolcpus=3 nohz_full=3 rcu_nocbs=3"'),
    ({"proc/irq/7/effective_affinity_list": "3"}, "interrupts", "1 arrive at CPU 3: 7", "echo 0 > /proc/irq/$i"),
    (
        {"sys/devices/system/cpu/cpu3/cpufreq/scaling_governor": "powersave"},
        "frequency",
        "powersave",
        "cpupower frequency-set -g performance",
    ),
    ({"sys/devices/system/cpu/cpu3/cpuidle/state1/disable": "0"}, "idle states", "C6 (85 µs)", "cpupower idle-set"),
    (
        {"sys/devices/system/cpu/cpu3/topology/thread_siblings_list": "1,3"},
        "hyper-threads",
        "shares its core with 1",
        "cpu1/online",
    ),
    (
        {"sys/devices/system/clocksource/clocksource0/current_clocksource": "hpet"},
        "clock",
        "each reading is a system call",
        "echo tsc >",
    ),
    ({"proc/stat": "cpu  100 0 100 9700 0 0 0 100 0 0"}, "hypervisor", "1.00 %", "pinned"),
    ({"proc/cpuinfo": "flags\t\t: fpu hypervisor tsc"}, "hypervisor", "a virtual machine", "pinned"),
    ({"proc/swaps": "Filename\n/dev/sda2 partition 1 0 -2"}, "swap", "1 area", "swapoff -a"),
    (
        {"sys/kernel/mm/transparent_hugepage/enabled": "[always] madvise never"},
        "huge pages",
        "always",
        "echo madvise >",
    ),
]


def make_machine(root: Path, changes: dict[str, str | None], limits: dict[str, int] = GOOD_LIMITS) -> rt_check.Machine:
    for path, text in {**GOOD, **changes}.items():
        if text is None:
            continue
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text + "\n")
    return rt_check.Machine(root, limits)


def verdicts(machine: rt_check.Machine, cpu: int | None = 3) -> dict[str, str]:
    return {finding.name: finding.verdict for finding in rt_check.inspect(machine, cpu)}


def test_nothing_is_to_be_changed_on_a_good_machine(tmp_path: Path) -> None:
    assert set(verdicts(make_machine(tmp_path, {})).values()) == {"ok"}


@pytest.mark.parametrize(("changes", "name", "found", "remedy"), BAD)
def test_one_point_notices(tmp_path: Path, changes: dict[str, str | None], name: str, found: str, remedy: str) -> None:
    wrong = [f for f in rt_check.inspect(make_machine(tmp_path, changes), 3) if f.verdict != "ok"]
    assert [f.name for f in wrong] == [name]
    assert wrong[0].verdict == "change"
    assert found in wrong[0].found
    assert remedy in wrong[0].remedy


@pytest.mark.parametrize("limits", [{"rtprio": 0, "memlock": -1}, {"rtprio": 98, "memlock": 8 << 20}])
def test_missing_rights_are_found_unless_the_process_may_everything(tmp_path: Path, limits: dict[str, int]) -> None:
    machine = make_machine(tmp_path, {}, limits)
    assert verdicts(machine)["rights"] == "change"
    (tmp_path / "proc/self/status").write_text("CapEff:\t000001ffffffffff\n")
    assert verdicts(machine)["rights"] == "ok"


def test_an_absent_cpu_is_named(tmp_path: Path) -> None:
    finding = rt_check.check_isolation(make_machine(tmp_path, {}), 9)
    assert (finding.verdict, finding.found) == ("change", "there is no CPU 9")
    assert "0, 1, 2, 3" in finding.remedy


def test_what_the_machine_does_not_tell_is_unknown(tmp_path: Path) -> None:
    (tmp_path / "proc").mkdir()
    found = verdicts(rt_check.Machine(tmp_path, GOOD_LIMITS))
    for name in ("throttling", "frequency", "idle states", "hypervisor", "clock"):
        assert found[name] == "unknown"


@pytest.mark.parametrize(
    ("text", "cpus"), [("0-2,5", {0, 1, 2, 5}), ("managed_irq,domain,3", {3}), ("", set()), ("7", {7})]
)
def test_cpu_lists(text: str, cpus: set[int]) -> None:
    assert rt_check.cpu_list(text) == cpus


def run(*arguments: str | Path) -> subprocess.CompletedProcess:
    command = [ROOT / "scripts" / "rt_check", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=480)


def test_the_program_fails_only_when_it_is_strict(tmp_path: Path) -> None:
    make_machine(tmp_path, {"proc/swaps": "Filename\n/dev/sda2 partition 1 0 -2"})
    found = run("--root", tmp_path, "--cpu", "3")
    assert found.returncode == 0, found.stderr
    assert "change   swap" in found.stdout
    assert "→ swapoff -a" in found.stdout
    assert run("--root", tmp_path, "--cpu", "3", "--strict").returncode == 1


def test_this_machine_can_be_inspected() -> None:
    found = run()
    assert (found.returncode, found.stderr) == (0, "")
    assert len([line for line in found.stdout.splitlines() if line.startswith(("ok ", "change ", "unknown "))]) == 12


def test_a_root_without_proc_is_refused(tmp_path: Path) -> None:
    found = run("--root", tmp_path)
    assert found.returncode == 2
    assert found.stderr.startswith("rt_check: ")
    assert found.stderr.count("\n") == 1
