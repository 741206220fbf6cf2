"""Inspects the machine for hard real time: says for each point whether it is well, and the command that changes it."""

import argparse
import re
import resource
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from .errors import UserError, run
from .program_arguments import parser_of

EXAMPLES = """examples:
  rt_check                  this machine, for a control thread on any CPU
  rt_check --cpu 1          for realtime.cpu = 1
  rt_check --cpu 1 --strict exit status 1 where anything is to be changed
Nothing is changed by this program. The reasons are in docs/realtime.md."""


@dataclass(frozen=True)
class Finding:
    """One point: what was found, and what to do where that is not well."""

    verdict: str  # ok, change, or unknown where the machine does not tell
    found: str
    remedy: str = ""
    name: str = ""


def cpu_list(text: str) -> set[int]:
    """The CPUs of a list as the kernel writes it, "0-2,5"; words such as "managed_irq" are passed over."""
    cpus: set[int] = set()
    for part in text.strip().split(","):
        if match := re.fullmatch(r"(\d+)(?:-(\d+))?", part.strip()):
            first, last = int(match[1]), int(match[2] or match[1])
            cpus |= set(range(first, last + 1))
    return cpus


class Machine:
    """The files in which a kernel describes itself, below a root."""

    def __init__(self, root: Path, limits: dict[str, int] | None = None) -> None:
        self._root = root
        self._limits = limits

    def text(self, path: str) -> str | None:
        """Content without its end, or None where it cannot be read."""
        try:
            return (self._root / path).read_text().strip()
        except OSError:
            return None

    def paths(self, pattern: str) -> list[Path]:
        return sorted(self._root.glob(pattern))

    def exists(self, path: str) -> bool:
        return (self._root / path).exists()

    def boot_option(self, name: str) -> str | None:
        """Value of an option of the kernel's command line; "" where it has none, None where it is not there."""
        for word in (self.text("proc/cmdline") or "").split():
            key, _, value = word.partition("=")
            if key == name:
                return value
        return None

    def cpus(self) -> set[int]:
        return cpu_list(self.text("sys/devices/system/cpu/online") or "")

    def limit(self, name: str) -> int:
        """A soft limit of this process; -1 for none."""
        if self._limits is not None:
            return self._limits[name]
        return resource.getrlimit({"rtprio": 14, "memlock": resource.RLIMIT_MEMLOCK}[name])[0]

    def may_everything(self) -> bool:
        """Whether the process has CAP_SYS_NICE and CAP_IPC_LOCK."""
        match = re.search(r"^CapEff:\s*([0-9a-f]+)$", self.text("proc/self/status") or "", re.MULTILINE)
        wanted = 1 << 23 | 1 << 14
        return match is not None and int(match[1], 16) & wanted == wanted


def ok(found: str) -> Finding:
    return Finding("ok", found)


def change(found: str, remedy: str) -> Finding:
    return Finding("change", found, remedy)


def unknown(found: str) -> Finding:
    return Finding("unknown", found)


def check_kernel(machine: Machine, cpu: int | None) -> Finding:
    version = machine.text("proc/version") or ""
    if machine.text("sys/kernel/realtime") == "1" or "PREEMPT_RT" in version:
        return ok("PREEMPT_RT")
    model = (
        "PREEMPT_DYNAMIC" if "PREEMPT_DYNAMIC" in version else "PREEMPT" if "PREEMPT" in version else "no preemption"
    )
    return change(
        f"{model}: wake-ups are not bounded", "apt-get install linux-image-rt-amd64, boot it (uname -v says PREEMPT_RT)"
    )


def check_throttling(machine: Machine, cpu: int | None) -> Finding:
    runtime = machine.text("proc/sys/kernel/sched_rt_runtime_us")
    if runtime is None:
        return unknown("sched_rt_runtime_us cannot be read")
    if int(runtime) < 0:
        return ok("off")
    period = int(machine.text("proc/sys/kernel/sched_rt_period_us") or 1_000_000)
    return change(
        f"real-time threads stand still for {(period - int(runtime)) / 1e3:g} ms of each {period / 1e3:g} ms",
        "sysctl kernel.sched_rt_runtime_us=-1",
    )


def check_isolation(machine: Machine, cpu: int | None) -> Finding:
    cpus = machine.cpus()
    if cpu is not None and cpu not in cpus:
        there = ", ".join(map(str, sorted(cpus)))
        return change(f"there is no CPU {cpu}", f"set realtime.cpu to one of {there}")
    if len(cpus) < 2:
        return change("one CPU for everything", "use a machine with two CPUs or more")
    wanted = {cpu} if cpu is not None else {max(cpus)}
    number = next(iter(wanted))
    missing = [
        option
        for option in ("isolcpus", "nohz_full", "rcu_nocbs")
        if not wanted <= cpu_list(machine.boot_option(option) or "")
    ]
    if not missing:
        return ok(f"CPU {number} runs nothing else")
    options = " ".join(f"{option}={number}" for option in missing)
    return change(
        f"CPU {number} is shared: {', '.join(missing)} do not name it",
        f'add "{options}" to GRUB_CMDLINE_LINUX in /etc/default/grub, update-grub, reboot; realtime.cpu = {number}',
    )


def check_interrupts(machine: Machine, cpu: int | None) -> Finding:
    if cpu is None:
        return unknown("say --cpu to see which interrupts arrive there")
    bound = []
    for path in machine.paths("proc/irq/[0-9]*/effective_affinity_list"):
        try:
            if cpu in cpu_list(path.read_text()):
                bound.append(path.parent.name)
        except OSError:
            continue
    if not bound:
        return ok(f"none arrives at CPU {cpu}")
    rest = sorted(machine.cpus() - {cpu}) or [0]
    return change(
        f"{len(bound)} arrive at CPU {cpu}: {', '.join(bound[:8])}{' …' if len(bound) > 8 else ''}",
        f"systemctl stop irqbalance; for i in {' '.join(bound)};"
        f" do echo {rest[0]} > /proc/irq/$i/smp_affinity_list; done (those that refuse belong to the CPU)",
    )


def check_governor(machine: Machine, cpu: int | None) -> Finding:
    pattern = f"sys/devices/system/cpu/cpu{'[0-9]*' if cpu is None else cpu}/cpufreq/scaling_governor"
    governors = {path.read_text().strip() for path in machine.paths(pattern)}
    if not governors:
        return unknown("no cpufreq here (a virtual machine, or the firmware decides)")
    if governors == {"performance"}:
        return ok("performance")
    return change(f"governor {', '.join(sorted(governors))}", "cpupower frequency-set -g performance")


def check_idle_states(machine: Machine, cpu: int | None) -> Finding:
    deep = []
    for path in machine.paths(f"sys/devices/system/cpu/cpu{0 if cpu is None else cpu}/cpuidle/state[0-9]*"):
        latency = int((path / "latency").read_text())
        if latency > 10 and (path / "disable").read_text().strip() == "0":
            deep.append(f"{(path / 'name').read_text().strip()} ({latency} µs)")
    if not machine.paths("sys/devices/system/cpu/cpu0/cpuidle/state[0-9]*"):
        return unknown("no cpuidle here (a virtual machine: the host decides)")
    if not deep:
        return ok("none takes more than 10 µs to leave")
    return change(
        f"slow to leave: {', '.join(deep)}",
        "cpupower idle-set -D 10, or keep a process that holds /dev/cpu_dma_latency open with the value 0",
    )


def check_huge_pages(machine: Machine, cpu: int | None) -> Finding:
    path = "sys/kernel/mm/transparent_hugepage/enabled"
    match = re.search(r"\[(\w+)\]", machine.text(path) or "")
    if match is None:
        return ok("not transparent")
    if match[1] in ("madvise", "never"):
        return ok(match[1])
    return change(f"{match[1]}: the kernel moves memory about", f"echo madvise > /{path}")


def check_swap(machine: Machine, cpu: int | None) -> Finding:
    areas = (machine.text("proc/swaps") or "").splitlines()[1:]
    if not areas:
        return ok("none")
    return change(f"{len(areas)} area(s): what is not locked may be written out", "swapoff -a")


def check_limits(machine: Machine, cpu: int | None) -> Finding:
    if machine.may_everything():
        return ok("CAP_SYS_NICE and CAP_IPC_LOCK")
    rtprio, memlock = machine.limit("rtprio"), machine.limit("memlock")
    if (rtprio < 0 or rtprio >= 80) and memlock < 0:
        return ok("limits rtprio and memlock suffice")
    memory = "unlimited" if memlock < 0 else f"{memlock >> 10} KiB"
    return change(
        f"limits rtprio {rtprio}, memlock {memory}",
        'add "@realtime - rtprio 99" and "@realtime - memlock unlimited" to /etc/security/limits.d/realtime.conf,'
        " join the group realtime and log in again; or setcap cap_sys_nice,cap_ipc_lock+ep sextant-ecu",
    )


def check_steal(machine: Machine, cpu: int | None) -> Finding:
    fields = (machine.text("proc/stat") or "").splitlines()[:1]
    numbers = [int(word) for word in fields[0].split()[1:]] if fields else []
    virtual = " hypervisor" in (machine.text("proc/cpuinfo") or "")
    if len(numbers) < 8:
        return unknown("/proc/stat does not tell stolen time")
    share = numbers[7] / max(1, sum(numbers[:8]))
    if not virtual and numbers[7] == 0:
        return ok("none")
    return change(
        f"a virtual machine; {100 * share:.2f} % of the time since boot was stolen",
        "use a machine of its own, or ask the host for CPUs that are pinned and not shared",
    )


def check_clock(machine: Machine, cpu: int | None) -> Finding:
    folder = "sys/devices/system/clocksource/clocksource0"
    source = machine.text(f"{folder}/current_clocksource")
    if source is None:
        return unknown("the clock source cannot be read")
    if source in ("tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"):
        return ok(f"{source}: read without a system call")
    return change(f"{source}: each reading is a system call", f"echo tsc > /{folder}/current_clocksource")


def check_siblings(machine: Machine, cpu: int | None) -> Finding:
    number = max(machine.cpus(), default=0) if cpu is None else cpu
    siblings = cpu_list(machine.text(f"sys/devices/system/cpu/cpu{number}/topology/thread_siblings_list") or "")
    others = sorted(siblings - {number})
    if not others:
        return ok(f"CPU {number} is a core of its own")
    return change(
        f"CPU {number} shares its core with {', '.join(map(str, others))}",
        "; ".join(f"echo 0 > /sys/devices/system/cpu/cpu{other}/online" for other in others),
    )


CHECKS: dict[str, Callable[[Machine, int | None], Finding]] = {
    "kernel": check_kernel,
    "throttling": check_throttling,
    "rights": check_limits,
    "isolation": check_isolation,
    "interrupts": check_interrupts,
    "hyper-threads": check_siblings,
    "frequency": check_governor,
    "idle states": check_idle_states,
    "clock": check_clock,
    "hypervisor": check_steal,
    "swap": check_swap,
    "huge pages": check_huge_pages,
}


def inspect(machine: Machine, cpu: int | None) -> list[Finding]:
    return [replace(check(machine, cpu), name=name) for name, check in CHECKS.items()]


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "rt_check", "Says what keeps this machine from hard real time, and the command that changes it.", EXAMPLES
    )
    parser.add_argument("--cpu", type=int, help="the CPU of the control thread (realtime.cpu)")
    parser.add_argument("--strict", action="store_true", help="fail where anything is to be changed")
    parser.add_argument("--root", type=Path, default=Path("/"), help="where proc and sys are (default: /)")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if not (options.root / "proc").is_dir():
        raise UserError(f"{options.root} holds no proc; --root names the folder that holds proc and sys.")
    findings = inspect(Machine(options.root), options.cpu)
    for finding in findings:
        print(f"{finding.verdict:<8} {finding.name:<14} {finding.found}")
        if finding.remedy:
            print(f"{'':<23} → {finding.remedy}")
    wrong = sum(finding.verdict == "change" for finding in findings)
    print(f"{wrong} of {len(findings)} points to change." if wrong else "Nothing to change.")
    return 1 if options.strict and wrong else 0


if __name__ == "__main__":
    run("rt_check", main)
