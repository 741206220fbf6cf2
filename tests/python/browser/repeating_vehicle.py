"""A vehicle that repeats its demand every 10 ms, from a thread of the test."""

from background import Background
from sextant_py import bus
from sextant_py.commander import Commander
from sextant_py.contract import Contract

PERIOD_S = 0.01
TORQUE_LIMIT_NM = 150.0


class RepeatingVehicle(Background):
    """A context; it sends nothing before its first demand."""

    def __init__(self, address: str) -> None:
        self._bus = bus.open_bus(bus.parse(address))
        self._commander = Commander(self._bus, Contract(), PERIOD_S, TORQUE_LIMIT_NM, keeps_log=False)
        self._demand: tuple[float, bool] | None = None
        super().__init__()

    def __exit__(self, *details: object) -> None:
        super().__exit__(*details)
        self._bus.shutdown()

    def _run(self) -> None:
        while not self._stop.is_set():
            self._commander.wait()
            if (demand := self._demand) is not None:
                self._commander.send(*demand)

    def demand(self, torque_nm: float = 0.0, enable: bool = False) -> None:
        self._demand = (torque_nm, enable)

    def stop_sending(self) -> None:
        self._demand = None
