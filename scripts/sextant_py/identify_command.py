"""Commands a drive through a course of `identify`, as a vehicle does: hand-shake, enable, torque over time, disable.

Leaving in whatever way, a context of `sextant.Vcu` ends with a disable, which turns the gates off.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from .control_unit import Vcu
from .errors import EndedError
from .identify_run import Steps, tripped
from .reports import FOLLOWING_STATES, RUNNING_STATES
from .vcu import Progress

READY_S = 30.0  # for the hand-shake
REST_S = 30.0  # for a shaft that comes to rest
LEAST_SPEED = 0.06  # step of the speed on the bus [rad/s]
FLUX_LATER_S = 2.0  # beyond the time after which the drive itself takes missing flux for a fault
BRAKE_S = 20.0  # longest time in which the drive brakes the shaft
BRAKED = 0.03  # of the fastest speed, at which it has ended
RPM = 2 * math.pi / 60


@dataclass(frozen=True)
class Course:
    """What is asked of a drive from when it has flux."""

    name: str
    duration_s: float
    torque: Steps  # none of a shaft that stays at rest
    slowest: float  # speed from which on a shaft counts as turning [rad/s]
    flux_s: float  # after which the drive takes missing flux for a fault

    def torque_at(self, time_s: float) -> float:
        """[N·m]"""
        return next((value for begin_s, value in reversed(self.torque) if begin_s <= time_s), 0.0)

    @property
    def most_torque(self) -> float:
        """[N·m]"""
        return max((abs(value) for _, value in self.torque), default=0.0)


@dataclass(frozen=True)
class Commanded:
    vcu: Vcu
    course: Course
    progress: Progress
    check: Callable[[], None]  # raises where the drive's program has ended

    def run(self) -> None:
        """The whole course, on a shaft that rests. Where the drive leaves torque, or is not there, it ends with a
        sentence."""
        self.vcu.make_ready(READY_S, progress=self.check)
        self._wait_for_rest()
        begin_s = self._wait_for_flux()
        passed = fastest = 0.0
        while (passed := self._step(self.course.torque_at(passed)) - begin_s) < self.course.duration_s:
            self._check_state(passed)
            fastest = max(fastest, abs(self.speed))
            self._show(f"{100 * passed / self.course.duration_s:3.0f} % of {self.course.duration_s:.1f} s")
        if self.course.torque:
            self._brake(fastest)

    @property
    def speed(self) -> float:
        """As the drive reports it. [rad/s]"""
        return RPM * float(self.vcu.latest.get("MCU_Motion", {}).get("Speed", 0.0))

    def _step(self, torque_nm: float, enable: bool = True) -> float:
        """One command; when it was due. [s]"""
        due_ns = self.vcu.wait()
        self.vcu.send(torque_nm, enable)
        self.check()
        return 1e-9 * due_ns

    def _wait_for_rest(self) -> None:
        slowest = max(LEAST_SPEED, self.course.slowest)
        end_s = self._step(0.0, enable=False) + REST_S
        while abs(self.speed) > slowest:
            self._show(f"waits for the shaft, which turns at {self.speed:.3g} rad/s")
            if self._step(0.0, enable=False) > end_s:
                raise EndedError(
                    f"the shaft turns at {self.speed:.3g} rad/s before the course of {self.course.name}, which begins "
                    f"with one that stands still (below {slowest:.2g} rad/s): hold it, or let it come to rest."
                )

    def _wait_for_flux(self) -> float:
        """Enables the drive; when the torque followed. [s]"""
        now_s = self._step(0.0)
        end_s = now_s + self.course.flux_s + FLUX_LATER_S
        while self.vcu.state not in FOLLOWING_STATES:
            self._check_fault("")
            self._show("builds up the flux")
            now_s = self._step(0.0)
            if now_s > end_s:
                raise EndedError(
                    f"the drive did not follow the enable of the course of {self.course.name} within "
                    f"{self.course.flux_s + FLUX_LATER_S:.3g} s; it reports {self.vcu.state}."
                )
        return now_s

    def _brake(self, fastest: float) -> None:
        """The free shaft to rest, or to where a late torque turns it the other way: the next course need not wait. The
        torque falls with the speed, so that a light shaft rests within the steps of the commands. [rad/s]"""
        begin = self.speed
        braked = max(LEAST_SPEED, self.course.slowest, BRAKED * fastest)
        passed_s = 0.0
        begin_s = self._step(0.0)
        while math.copysign(self.speed, self.speed * begin) > braked and passed_s < BRAKE_S:
            passed_s = self._step(-self.course.most_torque * max(-1.0, min(1.0, self.speed / fastest))) - begin_s
            self._check_state(self.course.duration_s + passed_s)
            self._show("brakes the shaft")

    def _check_fault(self, when: str) -> None:
        if self.vcu.state == "FAULT":
            raise tripped(self.vcu.first_fault or "a fault", self.course.name, when)

    def _check_state(self, passed: float) -> None:
        name = self.course.name
        self._check_fault(f" at {passed:.3f} s")
        if not self.vcu.is_there:
            raise EndedError(f"the drive's status frames timed out {passed:.2f} s into the course of {name}.")
        if self.vcu.state not in RUNNING_STATES:
            raise EndedError(f"the drive left the course of {name} after {passed:.2f} s; it reports {self.vcu.state}.")

    def _show(self, what: str) -> None:
        self.progress.show(f"{self.course.name} {what}  drive: {self._standing()}")

    def _standing(self) -> str:
        """What the drive reports, for a person."""
        electrical = self.vcu.latest.get("MCU_Electrical")
        if not electrical:
            return str(self.vcu.state)
        said = f"{self.vcu.state}, {electrical['PhaseCurrentRms']:.1f} A RMS, link {electrical['DcVoltage']:.1f} V"
        return f"{said}, {self.speed:.3g} rad/s" if self.course.torque else said
