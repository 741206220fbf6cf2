"""A vehicle control unit for one drive: `sextant.Vcu`. scripts/vcu and the dashboard command by it."""

import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import can

from . import bus as can_bus
from . import lockstep_bus
from .commander import COMMAND, Clock, Commander
from .contract import Contract
from .errors import EndedError, UserError
from .lockstep_bus import LockstepBus
from .reports import FOLLOWING_STATES, STATUS, Reports
from .sweep_reader import set_words
from .wrong_frames import WRONG

PERIOD_S = 0.01
PERIODS_S = (0.001, 1.0)
DISABLE_FRAMES = 10


class FrameLog:
    """A bus and its clock in one: frames go to a log of candump's format, with the times at which they are due."""

    def __init__(self, path: Path) -> None:
        self._now_ns = 0
        try:
            self._writer = can.CanutilsLogWriter(path)
        except OSError as error:
            raise UserError(f"the log {path} cannot be written: {error.strerror}.") from None

    def now_ns(self) -> int:
        return self._now_ns

    def wait_until(self, due_ns: int) -> None:
        self._now_ns = max(due_ns, self._now_ns)

    def send(self, frame: can.Message) -> None:
        frame.timestamp = self._now_ns / 1e9
        self._writer.on_message_received(frame)

    def shutdown(self) -> None:
        self._writer.stop()


def _torque_limit(contract: Contract, wanted_nm: float | None) -> float:
    smallest_nm, largest_nm = contract.limits(COMMAND, "TorqueLimit")
    limit_nm = largest_nm if wanted_nm is None else wanted_nm
    if not smallest_nm <= limit_nm <= largest_nm:
        raise UserError(f"the torque limit {limit_nm:g} N·m is not {smallest_nm:g} to {largest_nm:g} N·m.")
    return limit_nm


class Vcu:
    """A vehicle control unit: it sends torque commands to a drive over CAN, with counter and CRC, and has what the
    drive reports. A context, at whose end the drive gets disable frames.

        with sextant.Vcu("socketcan:can0") as vcu:
            vcu.enable()
            vcu.demand(20.0, enable=True)
            vcu.run(2.0)
            print(vcu.state, vcu.torque_nm)

    A frame leaves each period while `run`, `run_until`, `enable`, `make_ready` or `disable` run, and between these
    none: after command.timeout_ms the drive ramps to zero torque. Within `with vcu.repeating():` a thread sends them.

    What is wrong outside of the program, and what the drive refuses, is a UserError with one sentence.
    """

    def __init__(
        self,
        bus: str | None = None,
        *,
        identifier_offset: int | None = None,
        period_s: float = PERIOD_S,
        torque_limit_nm: float | None = None,
        log: str | Path | None = None,
        lockstep: str | Path | LockstepBus | None = None,
        overrides: Mapping[str, Any] | None = None,
        keeps_sent: bool = False,
    ) -> None:
        """
        bus: "socketcan:INTERFACE" or "udp_multicast:GROUP:PORT"; default: that of configs/ecu.toml
        identifier_offset: the drive's can.identifier_offset; default: that of configs/ecu.toml, or of lockstep
        period_s: from frame to frame, 1 ms to 1 s [s]
        torque_limit_nm: TorqueLimit of each frame, default: the contract's largest [N·m]
        log: a file in place of a bus, for `sextant-ecu --virtual-time FILE`: no time passes, and no drive replies
        lockstep: the configuration of a drive in virtual time, which goes on with each frame, or a LockstepBus; no bus
        overrides: keys of that configuration and their values
        keeps_sent: keep (time [ns], torque [N·m], enable, counter) of each frame in `sent`
        """
        shortest_s, longest_s = PERIODS_S
        if not shortest_s <= period_s <= longest_s:
            raise UserError(f"the period of commands must be {shortest_s:g} to {longest_s:g} s, not {period_s:g} s.")
        if sum(end is not None for end in (bus, log, lockstep)) > 1:
            raise UserError("a vehicle control unit has a bus, a log or a drive in lockstep, one of them.")
        if overrides and lockstep is None:
            raise UserError("overrides are those of a drive in lockstep.")
        words = set_words(overrides or {})
        if identifier_offset is not None:
            offset = identifier_offset
        elif lockstep is not None:
            offset = lockstep_bus.identifier_offset(Path(lockstep), words)
        else:
            offset = can_bus.default_identifier_offset()
        self.contract = Contract(identifier_offset=offset)
        limit_nm = _torque_limit(self.contract, torque_limit_nm)
        self.period_s = period_s
        self._demand = (0.0, False, False)
        self._repeater: threading.Thread | None = None
        self.is_there = False
        self._clock: Clock | FrameLog | LockstepBus = Clock()
        if log is not None:
            self._bus: Any = FrameLog(Path(log))
            self.address, self._clock = str(log), self._bus
        elif lockstep is not None:
            self._bus = lockstep if isinstance(lockstep, LockstepBus) else LockstepBus(Path(lockstep), words)
            self.address, self._clock = str(lockstep), self._bus
        else:
            address = can_bus.parse(bus or can_bus.default_address())
            self._bus, self.address = can_bus.open_bus(address), str(address)
        self._replies = log is None
        self._is_live = isinstance(self._clock, Clock)
        self._commander = Commander(self._bus, self.contract, period_s, limit_nm, keeps_sent, self._clock)
        self.reports = Reports(self._bus, self.contract)
        if self._is_live:
            self.reports.start()
        elif lockstep is not None:
            self._bus.deliver = self.reports.accept

    def __enter__(self) -> Self:
        return self

    def __exit__(self, problem: type[BaseException] | None, *_: object) -> None:
        try:
            if self.frames and (self._is_live or problem is None):
                self.disable()
        finally:
            self.close()

    def close(self) -> None:
        """Closes the bus, without a further frame: the drive ramps to zero torque by its own timeouts."""
        self.reports.stop()
        self._bus.shutdown()

    # What the drive reports

    @property
    def latest(self) -> dict[str, dict[str, Any]]:
        """The signals of the newest frame of each message, by their names in sextant.dbc."""
        return self.reports.latest

    @property
    def state(self) -> str | None:
        """DriveState; None before the first status frame."""
        return self.reports.state()

    @property
    def torque_nm(self) -> float | None:
        """TorqueEstimated [N·m]; None before the first status frame."""
        status = self.latest.get(STATUS)
        return float(status["TorqueEstimated"]) if status else None

    @property
    def is_ready(self) -> bool:
        """Whether an enable is accepted."""
        return self.reports.ready()

    @property
    def first_fault(self) -> str | None:
        """The first fault since the last reset; None without one."""
        name = str(self.latest.get("MCU_Faults", {}).get("FirstFault", "NONE"))
        return None if name == "NONE" else name

    @property
    def faults_active(self) -> set[str]:
        """The faults that are present."""
        return self._faults("MCU_FaultsActive")

    @property
    def faults_latched(self) -> set[str]:
        """The faults since the last reset."""
        return self._faults("MCU_FaultsLatched")

    def _faults(self, message: str) -> set[str]:
        values = self.latest.get(message, {})
        return {name for name, signal in self.contract.fault_signals(message).items() if values.get(signal.name)}

    @property
    def report(self) -> str:
        """What a drive in lockstep has said at its end, with the digest of the run; empty before, and of others."""
        return getattr(self._bus, "report", "")

    # What was sent

    @property
    def frames(self) -> int:
        """Frames that the bus has taken."""
        return self._commander.frames

    @property
    def sent(self) -> list[tuple[int, float, bool, int]]:
        return self._commander.sent

    @property
    def unsent(self) -> int:
        """Frames that the bus has refused."""
        return self._commander.unsent

    @property
    def missed(self) -> int:
        """Periods in which this program did not run."""
        return self._commander.missed

    # Commands

    def demand(self, torque_nm: float = 0.0, enable: bool = False, fault_reset: bool = False) -> None:
        """What each frame from now on says."""
        self._check_torque(torque_nm)
        self._demand = (float(torque_nm), bool(enable), bool(fault_reset))

    def spoil(self, kind: str, frames: int = 1) -> None:
        """The next frames are wrong in one way: `crc`, `data_id`, `repeated`, `jumped`, `reserved`, `range`, `length`,
        `lost` or `late` (docs/python.md). The frames after them are right again, as after `spoil_none`."""
        if kind not in WRONG:
            raise UserError(f'"{kind}" is no kind of wrong frame; known are {", ".join(WRONG)}.')
        if frames < 1:
            raise UserError(f"{frames} wrong frames cannot be sent: 1 or more can, and spoil_none makes them right.")
        self._commander.spoil(kind, frames)

    def spoil_none(self) -> None:
        """The next frames are right, whatever `spoil` has asked for."""
        self._commander.spoil_none()

    def wait(self) -> int:
        """Sleeps until the next frame is due; when that was [ns]. Periods that have passed are left out and counted."""
        due_ns = self._commander.wait()
        self.is_there = not self.reports.timed_out(self.period_s)
        return due_ns

    def send(self, torque_nm: float, enable: bool, fault_reset: bool = False) -> None:
        """One frame at once, of the contract's range, beside what is demanded."""
        self._check_torque(torque_nm)
        self._commander.send(torque_nm, enable, fault_reset)

    def step(self) -> None:
        """One period: waits, and sends what is demanded."""
        self.wait()
        self.send(*self._demand)

    def run(self, duration_s: float) -> None:
        """Sends what is demanded for so long, whatever the drive reports."""
        for _ in range(self._periods(duration_s)):
            self._pass_period()

    def run_until(self, condition: Callable[["Vcu"], bool], timeout_s: float = 10.0) -> None:
        """Sends what is demanded until the condition holds; a UserError where it does not within the timeout."""
        for _ in range(self._periods(timeout_s)):
            if condition(self):
                return
            self._pass_period()
        if not condition(self):
            raise EndedError(f"what was waited for did not come within {timeout_s:g} s; the drive {self._standing()}.")

    def _periods(self, duration_s: float) -> int:
        if not 0 <= duration_s < math.inf:
            raise UserError(f"a time of {duration_s:g} s is neither 0 s nor a finite longer one.")
        return round(duration_s / self.period_s)

    def _check_torque(self, torque_nm: float) -> None:
        smallest_nm, largest_nm = self.contract.limits(COMMAND, "TorqueRequest")
        if not smallest_nm <= torque_nm <= largest_nm:
            wrong = 'spoil("range") sends one beyond it on purpose'
            raise UserError(
                f"the torque {torque_nm:g} N·m leaves the contract's {smallest_nm:g} to {largest_nm:g} N·m; {wrong}."
            )

    def _pass_period(self) -> None:
        if self._repeater is None:
            self.step()
        else:
            time.sleep(self.period_s)

    @contextmanager
    def repeating(self) -> Iterator[Self]:
        """A context in which a thread sends what is demanded, each period, whatever the caller does meanwhile."""
        if self._repeater is not None or not self._is_live:
            raise UserError("a vehicle control unit repeats its demand once, and on a bus.")
        ended = threading.Event()

        def repeat() -> None:
            while not ended.is_set():
                self.step()

        self._repeater = threading.Thread(target=repeat, name="vcu", daemon=True)
        self._repeater.start()
        try:
            yield self
        finally:
            ended.set()
            self._repeater.join()
            self._repeater = None

    def make_ready(
        self, timeout_s: float = 10.0, reset_faults: bool = False, progress: Callable[[], None] = lambda: None
    ) -> None:
        """The hand-shake: disable frames until the drive accepts an enable. `progress` is called each period."""
        if not self._replies:
            raise UserError("a log has no drive that could get ready; demand a disable and run for 0.1 s.")
        periods_left = self._periods(timeout_s)
        while not self.is_ready:
            if periods_left == 0:
                self._refuse_handshake(timeout_s)
            periods_left -= 1
            self.check_contract()
            in_fault = self.state == "FAULT"
            if in_fault and not reset_faults:
                raise EndedError(
                    f"the drive is in FAULT ({self.reports.first_fault()}); --reset-faults (reset_faults=True) asks it"
                    " to clear them."
                )
            self.demand(0.0, False, fault_reset=in_fault)
            self._pass_period()
            progress()
        self.demand()

    def enable(self, timeout_s: float = 10.0, reset_faults: bool = False) -> None:
        """The hand-shake, then an enable with 0 N·m, until the torque follows; a UserError where it does not."""
        self.make_ready(timeout_s, reset_faults)
        self.demand(0.0, True)
        self.run_until(lambda vcu: vcu.state in (*FOLLOWING_STATES, "FAULT"), timeout_s)
        if self.state == "FAULT":
            raise EndedError(f"the drive went to FAULT ({self.reports.first_fault()}) when it was enabled.")

    def disable(self) -> None:
        """Disable frames, which are right ones."""
        self.spoil_none()
        self.demand()
        for _ in range(DISABLE_FRAMES):
            self._pass_period()

    def check_contract(self) -> None:
        """A UserError where the drive has said that its frames mean something else."""
        if other := self.reports.other_contract():
            raise EndedError(other)

    def _standing(self) -> str:
        if self.state is None or not self.is_there:
            return "sends no status frames"
        fault = f" ({self.reports.first_fault()})" if self.state == "FAULT" else ""
        return f"reports {self.state}{fault}"

    def _refuse_handshake(self, timeout_s: float) -> None:
        reports = self.reports
        if reports.refused and not self.latest.get(STATUS):
            raise EndedError(f"{reports.refused} status frames came, but none with a valid CRC and data ID.")
        if not self.is_there:
            raise EndedError(
                f"no status frame from a drive with the identifier offset {self.contract.identifier_offset} within"
                f" {timeout_s:g} s; is sextant-ecu running on this bus, and is --identifier-offset (identifier_offset)"
                " its can.identifier_offset?"
            )
        lockout = self.latest[STATUS]["Lockout"]
        raise EndedError(
            f"the drive did not become ready within {timeout_s:g} s: it reports {self.state}"
            f"{' and lockout' if lockout else ''}."
        )
