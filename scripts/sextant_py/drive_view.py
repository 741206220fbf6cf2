"""One drive for a person who watches a terminal: a panel, or a line."""

import math
import textwrap
import time
from functools import cache
from typing import Any

from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from .contract import Contract
from .dds import Drive
from .reports import FOLLOWING_STATES
from .sparkline import STEP_S, Sparkline
from .telemetry_contract import rejections
from .tracking import Tracking

TIMEOUT_S = 1.0
BAR_WIDTH = 41
SPARK_WIDTH = 40
LABEL_WIDTH = 11
FRAME_WIDTH = 6  # of a panel: its border, and the space between label and value
NARROWEST = 20  # of the values of a panel; below it they are cut off
STYLES = {"TORQUE": "bold green", "MAGNETISING": "cyan", "READY": "cyan", "DERATED": "yellow", "FAULT": "bold red"}


def rounded_up(value: float) -> float:
    """The next of 1, 2, 5, 10, 20, … that is not below the value."""
    decade = 10.0 ** math.floor(math.log10(max(value, 1.0)))
    return next(step * decade for step in (1, 2, 5, 10) if step * decade >= value)


def torque_bar(smallest: float, mean: float, largest: float, reference: float, full_scale: float, width: int) -> str:
    """One line from -full_scale to +full_scale [N·m]: the band, █ the mean, ◆ the reference, │ zero."""

    def cell(torque: float) -> int:
        share = (min(max(torque / full_scale, -1.0), 1.0) + 1.0) / 2.0
        return round(share * (width - 1))

    cells = ["·"] * width
    cells[width // 2] = "│"
    for index in range(cell(smallest), cell(largest) + 1):
        cells[index] = "─"
    cells[cell(reference)] = "◆"
    cells[cell(mean)] = "█"
    return "".join(cells)


@cache
def faults_by_bit() -> dict[int, str]:
    return {bit: name for name, bit in Contract().faults().items()}


def fault_names(bits: int) -> list[str]:
    return [faults_by_bit().get(bit, f"BIT_{bit}") for bit in range(64) if bits >> bit & 1]


def missed_by(statistics: Any) -> list[str]:
    """Overruns by cause, those that there were."""
    causes = {
        "machine": statistics.overruns_machine,
        "late wake-up": statistics.overruns_late_wake,
        "gap in a stage": statistics.overruns_stage_gap,
        "own execution": statistics.overruns_own_execution,
    }
    found = [f"{name} {count}" for name, count in causes.items() if count] or ["not yet judged"]
    return [f"{part}," for part in found[:-1]] + found[-1:]


def packed(parts: list[str], width: int) -> list[str]:
    """The parts in order, as many on a line as fit into the width."""
    lines = [parts[0]]
    for part in parts[1:]:
        if len(lines[-1]) + 1 + len(part) <= width:
            lines[-1] += f" {part}"
        else:
            lines.append(part.strip())
    return lines


class DriveView:
    def __init__(self) -> None:
        self._peak_nm = 1.0
        self._tracking = Tracking()
        self._torque = Sparkline(SPARK_WIDTH)
        self._speed = Sparkline(SPARK_WIDTH)
        self._seen_ns = -1

    def _track(self, t: Any) -> None:
        if t.t_ns == self._seen_ns:
            return
        self._seen_ns = t.t_ns
        self._torque.add(t.t_ns / 1e9, t.torque_mean_nm)
        self._speed.add(t.t_ns / 1e9, t.speed_rad_s)
        if t.state.name in FOLLOWING_STATES:
            self._tracking.add(t.t_ns / 1e9, t.torque_requested_nm, t.torque_mean_nm)
        else:
            self._tracking.pause()

    def _deviation(self) -> str | None:
        """In how far the drive does not follow the request, now."""
        off_nm = self._tracking.deviation_nm
        return f"NOT FOLLOWING: {off_nm:+.1f} N·m beside the request" if off_nm else None

    def panel(self, drive: Drive, width: int) -> Panel:
        """As wide as the terminal, width [columns]."""
        table = Table.grid(padding=(0, 2))
        table.add_column(justify="right", style="dim", no_wrap=True, min_width=LABEL_WIDTH)
        table.add_column(no_wrap=True, overflow="ellipsis")
        self._width = max(width - LABEL_WIDTH - FRAME_WIDTH, NARROWEST)
        if drive.telemetry is not None:
            self._track(drive.telemetry)
            self._add_telemetry(table, drive.telemetry)
        if drive.state is not None:
            self._add_state(table, drive.state)
        if drive.statistics is not None:
            self._add_statistics(table, drive.statistics)
        self._add(table, "telemetry", f"{drive.received} samples read,", f"{drive.lost} passed over")
        return Panel(table, title=self._title(drive), title_align="left")

    def _add(self, table: Table, label: str, *parts: str, style: str = "") -> None:
        """A row of parts that stay together, on as many lines as the width asks for."""
        for line in packed(list(parts), self._width):
            table.add_row(label, Text(line, style))
            label = ""

    def _add_course(self, table: Table, course: Sparkline) -> None:
        """The last seconds, as many as fit, with the values of the lowest and the highest level."""
        if course.count < 2:
            return
        _, low, high = course.text(SPARK_WIDTH)
        ends = f"{low:+.1f} … {high:+.1f}"
        columns = min(SPARK_WIDTH, self._width - len(ends) - 10)
        if columns >= len(ends):
            self._add(table, "", f"{course.text(columns)[0]} {ends} in {columns * STEP_S:.0f} s", style="dim")

    def _title(self, drive: Drive) -> Text:
        state = drive.telemetry.state.name if drive.telemetry is not None else "?"
        title = Text.assemble(f" drive {drive.drive_id}  ", (state, STYLES.get(state, "bold")), " ")
        age_s = time.monotonic() - drive.received_s
        if age_s > TIMEOUT_S:
            title.append(f" no samples for {age_s:.0f} s ", style="bold red")
        return title

    def _add_telemetry(self, table: Table, t: Any) -> None:
        self._peak_nm = max(self._peak_nm, abs(t.torque_min_nm), abs(t.torque_max_nm), abs(t.torque_reference_nm))
        scale = rounded_up(self._peak_nm)
        ends = f"{-scale:+5g} ", f" {scale:+g} N·m"
        width = min(BAR_WIDTH, max(self._width - len("".join(ends)), 3))
        bar = torque_bar(t.torque_min_nm, t.torque_mean_nm, t.torque_max_nm, t.torque_reference_nm, scale, width)
        self._add(table, "torque", bar.join(ends))
        self._add(table, "", f"{t.torque_mean_nm:+8.2f} N·m mean ", f"{t.torque_min_nm:+8.2f} … {t.torque_max_nm:+.2f}")
        self._add(table, "", f"{t.torque_reference_nm:+8.2f} N·m reference,", f"{t.torque_requested_nm:+.2f} requested")
        self._add_course(table, self._torque)
        if deviation := self._deviation():
            self._add(table, "", deviation, style="bold red")
        flux, current = f"{t.flux_min_wb:8.4f} … {t.flux_max_wb:.4f}", f"{t.current_min_a:8.2f} … {t.current_max_a:.2f}"
        self._add(table, "stator flux", f"{t.flux_mean_wb:8.4f} Wb mean  ", flux)
        self._add(table, "current", f"{t.current_mean_a:8.2f} A mean   ", current)
        self._add(table, "speed", f"{t.speed_rad_s:+8.2f} rad/s    ", f"{t.speed_rad_s * 30 / math.pi:+8.1f} rpm")
        self._add_course(table, self._speed)
        self._add(table, "DC link", f"{t.u_dc_v:8.1f} V        ", f"{t.i_dc_a:+8.2f} A  ", f"{t.power_w / 1e3:+.3f} kW")

    def _add_state(self, table: Table, s: Any) -> None:
        self._add(table, "reason", *textwrap.wrap(s.reason or "-", self._width))
        self._add(table, "lockout", *(("yes:", "no enable before a valid disable") if s.lockout else ("no",)))
        latched, active = fault_names(s.faults_latched), fault_names(s.faults_active)
        style = "bold red" if latched or active else ""
        for label, what, names in (("faults", "active", active), ("", "latched", latched)):
            self._add(table, label, f"{what} {', '.join(names) or 'none'}", style=style)

    def _add_statistics(self, table: Table, r: Any) -> None:
        period = f"{r.period_ns / 1e3:g} µs × {r.wake_every_periods} a wake-up,"
        lost = f"{r.periods_missed} missed,", f"{r.overruns} overruns"
        self._add(table, "real time", period, f"{r.periods} periods,", *lost)
        percentiles = f"wake-up latency p50 {r.wake_latency_p50_us:.1f},", f"p99 {r.wake_latency_p99_us:.1f},"
        self._add(table, "", *percentiles, f"max {r.wake_latency_max_us:.1f} µs")
        percentiles = f"execution p50 {r.execution_p50_us:.1f},", f"p99 {r.execution_p99_us:.1f},"
        self._add(table, "", *percentiles, f"max {r.execution_max_us:.1f} µs")
        stages = (
            f"read {r.read_p99_9_us:.2f},",
            f"drive {r.drive_p99_9_us:.2f},",
            f"push {r.push_p99_9_us:.2f} µs (p99.9)",
        )
        self._add(table, "", *stages)
        if r.overruns:
            self._add(table, "missed by", *missed_by(r))
        rights = f"SCHED_{r.policy.name}" if r.real_time_scheduling else "no real-time priority"
        memory = f"memory {'locked' if r.memory_locked else 'not locked'},", f"{r.page_faults} page faults"
        self._add(table, "", f"{rights},", f"wait {r.wait.name.lower()},", *memory)
        if r.r_s_ohm:
            in_use = (
                f"R_s {r.r_s_ohm:.4g} Ω ± {100 * r.r_s_deviation:.0f} %,",
                f"R_r {r.r_r_ohm:.4g} Ω ± {100 * r.r_r_deviation:.0f} %,",
                f"L_m {r.l_m_h:.4g} H ± {100 * r.l_m_deviation:.0f} %",
            )
            self._add(table, "parameters", *in_use)
        if r.winding_temperature_k:
            self._add(table, "winding", f"{r.winding_temperature_k - 273.15:.0f} °C")
        if r.periods_unchecked:
            self._add(table, "unchecked", f"{r.periods_unchecked} control periods")
        self._add(table, "commands", f"{r.commands_received} accepted,", f"{r.commands_rejected} rejected")
        if causes := [f"{text} {count}" for name, text in rejections().items() if (count := getattr(r, name))]:
            self._add(table, "rejected", *(f"{cause}," for cause in causes[:-1]), causes[-1])

    def line(self, drive: Drive) -> str:
        t, s, r = drive.telemetry, drive.state, drive.statistics
        parts = [f"drive {drive.drive_id}"]
        if t is not None:
            self._track(t)
            parts += [
                t.state.name,
                f"torque {t.torque_mean_nm:+.2f} N·m ({t.torque_min_nm:+.2f} … {t.torque_max_nm:+.2f}) of"
                f" {t.torque_reference_nm:+.2f}",
                f"flux {t.flux_mean_wb:.3f} Wb",
                f"current {t.current_mean_a:.1f} A",
                f"speed {t.speed_rad_s:+.1f} rad/s",
                f"DC link {t.u_dc_v:.0f} V",
            ]
        if r is not None:
            parts.append(f"{r.periods_missed} periods missed")
        if s is not None and s.faults_latched:
            parts.append(f"FAULTS {', '.join(fault_names(s.faults_latched))}")
        if deviation := self._deviation():
            parts.append(deviation)
        if time.monotonic() - drive.received_s > TIMEOUT_S:
            parts.append(f"no samples for {time.monotonic() - drive.received_s:.0f} s")
        return "  ".join(parts)
