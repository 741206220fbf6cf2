"""Stage: what the live drive does with its time, beside cyclictest and an empty loop; its deadlines, and the lockstep
run. TABLE has every figure with its target, by the part that measures it; a part returns values and notes by figure."""

import statistics
from collections.abc import Callable

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from . import gates, live_runs
from .figure import Figure, NotMeasurableError, spread
from .gates import Values
from .histogram import Histogram
from .lab import Lab, Stage
from .plots import draw_latency

WAKE_ROUNDS, WAKE_SECONDS = 6, 5
EXECUTION_ROUNDS, EXECUTION_SECONDS = 7, 2
EXECUTION_LINES = 197  # a period touches 76 cache lines of data and 121 of code (docs/performance.md)
TICK_LEAD_US = 6  # as in configs/ecu_hard.toml
SPIN_SECONDS = 60
LOCKSTEP_RUNS, LOCKSTEP_SECONDS = 3, 10
SPIN = {"drive__period_us": 25, "realtime__wait": "spin"}
WAITS = {"hybrid": "hard mode as shipped (hybrid wait)", "sleep": "hard mode asleep (wait = sleep)"}
REFERENCE = "cyclictest"
WAY = "command to gate, "  # and the bus
EXECUTIONS = {
    "ours": "execution time of a 25 µs period",
    "stamped": "the same with time stamps by stage, as shipped",
    "empty": "execution time of an empty loop",
    "busy": "execution time of a loop that computes as long in registers",
    "lines": "execution time of a loop that touches as many cache lines",
}
EXECUTION = "execution time of a 25 µs period with plant, spin mode /"
CVODE = "a 25 µs period that integrates with CVODE, following commands"

TABLE: dict[str, dict[str, Figure]] = {
    "wake-ups": {
        f"{wait} {percent:g}": Figure(f"wake-up latency at 250 µs, {name} / cyclictest, {text}", "x", at_most=1.1)
        for wait, name in WAITS.items()
        for percent, text in ((50.0, "median"), (99.0, "99 %"))
    },
    "execution": {
        "ours": Figure(f"{EXECUTION} (empty loop + benchmarked step), 99.9 %", "x"),
        "stamped": Figure(f"{EXECUTION} (empty loop + benchmarked step), 99.9 %, with time stamps by stage", "x"),
        "busy": Figure(f"{EXECUTION} a loop that computes as long in registers, 99.9 %", "x"),
        "lines": Figure(f"{EXECUTION} a loop that touches as many cache lines ({EXECUTION_LINES}), 99.9 %", "x"),
    },
    "spin mode": {
        "own": Figure(f"overruns without a detected gap, spin mode at 25 µs for {SPIN_SECONDS} s", at_most=0),
        "all": Figure(f"overruns, spin mode at 25 µs for {SPIN_SECONDS} s"),
        "lost": Figure("part of the periods missed by them", "%"),
    },
    **{
        f"commands by {bus}": {
            "way": Figure(
                f"CAN frame received to first gate pattern / (one period + own wake-ups), 99 %, {bus}", "x", at_most=1.0
            ),
            "hand-over": Figure(
                f"of it the receive thread's part / wake-up of cyclictest in its place, 99 %, {bus}", "x"
            ),
        }
        for bus in ("vcan", "udp multicast")
    },
    "CVODE": {
        "longest": Figure(f"longest execution time of {CVODE}", "µs"),
        "late": Figure("part of these executions longer than the period", "%"),
        "lost": Figure("part of the periods missed in that run", "%"),
    },
    "gates of a killed drive": {
        "killed": Figure(
            "HIL: from SIGKILL of the drive at torque until its plant has turned the gates off, as timed out",
            *("ms", 10.0),
        )
    },
    "gates of a drive that hangs": {  # 5 ms from detection on, and the watchdog compares every 2 ms
        "hung": Figure(
            "HIL: from the end of the watchdog's time to gates off, while the drive's control thread hangs", "ms", 7.0
        )
    },
    "gates behind a wire that is cut": {
        "cut": Figure(
            "HIL over UDP: from a cut of the wire until the plant has turned the gates off, as timed out",
            *("ms", 20.0),
        )
    },
    "deadlines": {
        "reached": Figure(
            "live drive: from the reception of a command to the first millisecond with its torque,"
            f" {gates.FROM_NM:g} to {gates.TO_NM:g} N·m",
            *("ms", 10.0),
        ),
        "gone": Figure("live drive: age of the last command at which its torque is gone", "ms", 60.0),
        "lost": Figure("live drive: age of the last command at the first millisecond in FAULT", "ms", 205.0, 200.0),
        "left": Figure("live drive: from SIGTERM at torque to the end of the process", "ms", 100.0),
    },
    "lockstep": {
        "speed": Figure(
            "lockstep HIL at 25 µs, both processes on two processors: virtual / real time", "x", at_least=2.0
        ),
        "digests": Figure("lockstep HIL: digests that differ from the first run's", at_most=0),
    },
}


class LiveLab:
    """The lab and the distributions that its parts leave for the page, by what they are."""

    def __init__(self, lab: Lab) -> None:
        self.lab = lab
        self.shapes: dict[str, Histogram] = {}

    def wakes(self) -> Values:
        rounds: list[dict[str, Histogram]] = []
        for number in range(WAKE_ROUNDS):
            timings = {w: live_runs.ecu(self.lab, f"wake_{w}", WAKE_SECONDS, realtime__wait=w) for w in WAITS}
            one = {wait: Histogram.from_json(timing["wake_latency"]) for wait, timing in timings.items()}
            rounds.append(one | {REFERENCE: live_runs.cyclictest(self.lab, WAKE_SECONDS, 250)})
            self.lab.say(f"wake-ups, round {number + 1} of {WAKE_ROUNDS}")
        for wait, name in {REFERENCE: REFERENCE, **WAITS}.items():
            self.shapes[name] = sum((one[wait] for one in rounds), Histogram())
        found = {}
        for wait in WAITS:
            for percent in (50.0, 99.0):
                ratios = [one[wait].percentile_ns(percent) / one[REFERENCE].percentile_ns(percent) for one in rounds]
                found[f"{wait} {percent:g}"] = (statistics.median(ratios), spread(ratios))
        return found

    def execution(self) -> Values:
        """The empty loop and the benchmarked step stand below the line; what is only like ours in one respect, too."""
        rounds = []
        for number in range(EXECUTION_ROUNDS):
            rounds.append(self.execution_round())
            self.lab.say(f"execution times, round {number + 1} of {EXECUTION_ROUNDS}")
        for side, name in EXECUTIONS.items():
            self.shapes[name] = sum((histograms[side] for histograms, _ in rounds), Histogram())

        def compared(above: str, below: str, with_step: bool) -> tuple[float, str]:
            up, down = ([each[side].percentile_ns(99.9) for each, _ in rounds] for side in (above, below))
            steps = [step_ns if with_step else 0.0 for _, step_ns in rounds]
            ratios = [u / (d + s) for u, d, s in zip(up, down, steps, strict=True)]
            up_ns, down_ns, step_ns = map(statistics.median, (up, down, steps))
            under = f"({down_ns:.0f} + {step_ns:.0f} ns)" if with_step else f"{down_ns:.0f} ns"
            return statistics.median(ratios), f"{up_ns:.0f} ns / {under}; {spread(ratios)}"

        found = {side: compared(side, "empty", True) for side in ("ours", "stamped")}
        return found | {side: compared("ours", side, False) for side in ("busy", "lines")}

    def execution_round(self) -> tuple[dict[str, Histogram], float]:
        """Everything of one round is measured within the same seconds; with the CPU time of the benchmarked step."""

        def drive(name: str, **values: object) -> Histogram:
            return Histogram.from_json(live_runs.ecu(self.lab, name, EXECUTION_SECONDS, **SPIN, **values)["execution"])

        def loop(**options: float) -> Histogram:
            timing = live_runs.empty_loop(self.lab, EXECUTION_SECONDS, 25, "spin", tick_lead_us=TICK_LEAD_US, **options)
            return Histogram.from_json(timing["execution"])

        ours, empty = drive("execution_spin", realtime__stage_statistics="false"), loop()
        busy_ns = max(0.0, ours.percentile_ns(50.0) - empty.percentile_ns(50.0))
        step = self.lab.google("^peer_loop/fixed", "sextant_loop_bench", repetitions=3)
        sides = {"ours": ours, "stamped": drive("execution_stamped"), "empty": empty}
        sides |= {"busy": loop(busy_ns=busy_ns), "lines": loop(lines=EXECUTION_LINES)}
        return sides, step.value("peer_loop/fixed", "cpu_ns")

    def spin(self) -> Values:
        timing = live_runs.ecu(self.lab, "spin", SPIN_SECONDS, **SPIN)
        name = f"wake-up latency, spin mode at 25 µs, {SPIN_SECONDS} s"
        self.shapes[name] = Histogram.from_json(timing["wake_latency"])
        causes = [f"{cause}: {count}" for cause, count in timing["overruns_by_cause"].items() if count]
        note = "; ".join([f"{timing['overruns']} overruns", *([", ".join(causes)] if causes else [])])
        own, every = timing["overruns_without_gap"], timing["overruns"]
        return {"own": (own, note), "all": (every, ""), "lost": (lost_percent(timing), "")}

    def commands(self, bus: str) -> Values:
        # To the host a guest is one more program: what SCHED_FIFO is worth inside begins with what it is outside.
        guest = () if live_runs.refusal_of_real_time() else ("chrt", "--rr", "5")
        vcan = (*guest, str(ROOT / "scripts" / "with_vcan"), "--time-limit", "300", "--")
        address, inside = ("socketcan:vcan0", vcan) if bus == "vcan" else (live_runs.BUS, ())
        return self.evaluate_commands(bus, live_runs.commanded(self.lab, f"command_{bus.split()[0]}", address, inside))

    def evaluate_commands(self, bus: str, timing: dict) -> Values:
        """Of one commanded run. What is allowed comes from elsewhere than what is evaluated: the wake-up of the control
        thread from its deadlines, that of the receive thread from cyclictest in its place."""
        early = timing["ended_early"]
        keys = ("command_to_gate", "command_hand_over", "wake_latency")
        way, hand_over, wake = (Histogram.from_json(timing[key]) for key in keys)
        reference: Histogram = timing["reference"]
        if hand_over.count == 0:
            raise UserError(f"no command was accepted: {early or 'none came'}")
        if way.count == 0:
            raise UserError(f"of {hand_over.count} accepted commands none was seen in a gate pattern")
        if reference.count == 0:
            raise NotMeasurableError("cyclictest counted nothing beside it")
        of_guest = {"uml": " of a User Mode Linux guest", "qemu": " of an emulated guest"}.get(timing["where"], "")
        for text, histogram in (
            (WAY.rstrip(", "), way),
            ("of it until the receive thread has handed it over", hand_over),
            ("cyclictest in the receive thread's place beside it", reference),
            ("wake-up of the control thread beside it", wake),
        ):
            self.shapes[f"{text}, {bus}{of_guest}"] = histogram
        # A command comes at any time. But what stops a guest stops the vehicle in it as well.
        met = wake.by_time(timing["period_us"] * 1000) if timing["where"] == "native" else wake
        sides = (way, hand_over, reference, met)
        way_us, hand_over_us, reference_us, wake_us = (side.percentile_ns(99.0) * 1e-3 for side in sides)
        note = f"{way.count} frames; {way_us:.0f} / ({timing['period_us']} + {reference_us:.0f} + {wake_us:.1f}) µs"
        note += f"; {early}" if early else ""
        if timing["where"] == "qemu":  # its times are not a machine's
            raise NotMeasurableError(f"in a guest with an emulated processor, asleep at 1 ms: {note}")
        of_it = f"{hand_over_us:.0f} / {reference_us:.0f} µs; socket, checks and decoding are in it"
        allowed_us = timing["period_us"] + reference_us + wake_us
        return {"way": (way_us / allowed_us, note), "hand-over": (hand_over_us / reference_us, of_it)}

    def cvode(self) -> Values:
        """The adaptive integrator in a live period of 25 µs, while commands are followed. Its time has no bound, so
        that the longest counts; the catching up after a stop of the machine is in it."""
        words = live_runs.settings(**SPIN, plant__integrator="cvode")
        timing = live_runs.commanded(self.lab, "cvode", live_runs.BUS, (), *words)
        execution = self.shapes[f"execution time of {CVODE}"] = Histogram.from_json(timing["execution"])
        p50_us, p99_9_us = (execution.percentile_ns(percent) * 1e-3 for percent in (50.0, 99.9))
        note = f"{execution.count} wake-ups; median {p50_us:.3g} µs, 99.9 % {p99_9_us:.3g} µs"
        note += f"; {timing['ended_early']}" if timing["ended_early"] else ""
        late = 100.0 * execution.part_above(25_000)
        return {"longest": (execution.max_ns * 1e-3, note), "late": (late, ""), "lost": (lost_percent(timing), "")}

    def lockstep(self) -> Values:
        runs = [live_runs.lockstep(self.lab, number, LOCKSTEP_SECONDS) for number in range(LOCKSTEP_RUNS)]
        factors, digests = [factor for factor, _ in runs], sorted({digest for _, digest in runs})
        speed = (statistics.median(factors), spread(factors))
        return {"speed": speed, "digests": (len(digests) - 1, " ".join(digests))}


def lost_percent(timing: dict) -> float:
    return 100.0 * timing["periods_missed"] / max(1, timing["periods"] + timing["periods_missed"])


def figures_of(part: str, measure: Callable[[], Values]) -> list[Figure]:
    """Every figure of a part; where it fails, the others of the stage still count."""
    try:
        found = measure()
    except Exception as error:
        return [row.failed(error) for row in TABLE[part].values()]
    return [row.of(*found[key]) for key, row in TABLE[part].items()]


def live(lab: Lab) -> list[Figure]:
    own = LiveLab(lab)
    parts: dict[str, Callable[[], Values]] = {
        "wake-ups": own.wakes,
        "execution": own.execution,
        "spin mode": own.spin,
        "commands by vcan": lambda: own.commands("vcan"),
        "commands by udp multicast": lambda: own.commands("udp multicast"),
        "CVODE": own.cvode,
        "gates of a killed drive": lambda: gates.killed(lab),
        "gates of a drive that hangs": lambda: gates.hung(lab),
        "gates behind a wire that is cut": lambda: gates.cut(lab),
        "deadlines": lambda: gates.deadlines(lab),
        "lockstep": own.lockstep,
    }
    figures: list[Figure] = []
    for name in TABLE:
        lab.say(name)
        figures += figures_of(name, parts[name])
    lab.distributions = {name: histogram.summary() for name, histogram in own.shapes.items() if histogram.count}
    draw_latency(
        {name: own.shapes[name] for name in (REFERENCE, *WAITS.values()) if name in own.shapes},
        {name.removeprefix(WAY): shape for name, shape in own.shapes.items() if name.startswith(WAY)},
        lab.out / "latency.png",
    )
    return figures


LIVE_STAGE = Stage("live", "the live drive: wake-ups, execution times, commands, gates, deadlines, lockstep", 400, live)
