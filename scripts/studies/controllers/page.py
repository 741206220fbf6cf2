"""The page of the bench of control methods, from its results."""

from collections.abc import Callable
from pathlib import Path

from studies.page import filled, table

from . import cost, figures
from .cases import BEST, DETUNED, LOW_SPEED, OPTIMA, REFERENCE, SWITCHING_HZ
from .measure import Record, Results

TEMPLATE = Path(__file__).with_name("page.md")
Value = Callable[[str], object]
SHORT = ("sampling", "switching", "start")  # what --quick measures


def figure(value: float | None, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _by_method(results: Results, rows: list[tuple[str, Value]]) -> str:
    return table(("", *results.methods), ((title, *(value(m) for m in results.methods)) for title, value in rows))


def _section(results: Results, section: str) -> str:
    """At the reference point, and the worst over all points whose torque is available."""

    def of(name: str, digits: int, scale: float = 1.0) -> Value:
        def value(method: str) -> str:
            found = results.metric(section, method, REFERENCE, name)
            return figure(None if found is None else found * scale, digits)

        return value

    def worst(name: str, digits: int) -> Value:
        def value(method: str) -> str:
            records = [r for r in results.of(section, method) if not r.reason and is_available(r)]
            values = [abs(r.metrics[name]) for r in records if r.metrics.get(name) is not None]
            return figure(max(values), digits) if values else "–"

        return value

    rows: list[tuple[str, Value]] = [
        ("torque ripple, RMS [N·m]", of("torque_ripple_rms_nm", 2)),
        ("torque ripple, RMS, worst [N·m]", worst("torque_ripple_rms_nm", 2)),
        ("bias of the mean torque, worst [N·m]", worst("torque_bias_nm", 3)),
        ("95 % of the step after [ms]", of("response_time_ms", 2)),
        ("switching frequency [kHz]", of("switching_frequency_hz", 1, 1e-3)),
        ("current THD [%]", of("current_thd_percent", 2)),
    ]
    if section == "switching":
        return _by_method(results, [("control period [µs]", lambda m: f"{results.periods_us[m]:g}"), *rows])
    return _by_method(results, [*rows, *_low_speed(results)])


def is_available(record: Record) -> bool:
    """The command was within the published torque, so that the reference is the command."""
    speed, torque = record.what
    side = "torque_motoring_nm" if speed * torque >= 0 else "torque_regenerating_nm"
    published = record.metrics.get(side)
    return published is not None and abs(torque) < published


def _starts(results: Results) -> str:
    rows = [
        (
            f"{limit} A",
            lambda m, limit=limit: "/".join(
                figure(results.metric("start", m, (limit,), name), 1) for name in ("response_time_ms", "peak_current_a")
            ),
        )
        for limit in (20, 40)
    ]
    return _by_method(results, rows)


def _detuned(results: Results) -> str:
    """Each wrong parameter with ideal sensors, and exact ones with real sensors."""
    cases = [(name, "ideal") for name in DETUNED] + [(next(iter(DETUNED)), "real")]
    rows = [
        (
            f"{name}, {sensors} sensors",
            lambda m, what=(name, sensors): "/".join(
                figure(results.metric("detuned", m, what, metric), 2)
                for metric in ("torque_bias_nm", "torque_ripple_rms_nm")
            ),
        )
        for name, sensors in cases
    ]
    return _by_method(results, rows)


def _low_speed(results: Results) -> list[tuple[str, Value]]:
    """Over the points up to LOW_SPEED with torque, and 10 s at standstill."""

    def worst(method: str, of: Callable[[Record], float]) -> str:
        points = [r for r in results.of("sampling", method) if abs(r.what[0]) <= LOW_SPEED and is_available(r)]
        return figure(max(map(of, points), default=None))

    return [
        ("low speed: torque ripple, RMS, worst [N·m]", lambda m: worst(m, ripple)),
        ("low speed: stator flux, worst deviation [%]", lambda m: worst(m, lambda r: 100 * flux_error(r))),
        (
            "15 N·m at standstill for 10 s: ripple, RMS [N·m]",
            lambda m: figure(results.metric("standstill", m, (), "torque_ripple_rms_nm")),
        ),
    ]


def ripple(record: Record) -> float:
    return record.metrics["torque_ripple_rms_nm"]


def flux_error(record: Record) -> float:
    """Largest deviation of the stator flux from its middle, as a share of it."""
    least, most = record.metrics["flux_min_wb"], record.metrics["flux_max_wb"]
    return (most - least) / (most + least)


def _sensorless(results: Results) -> str:
    """The worst of each method over the points."""

    def worst(method: str, name: str) -> str:
        values = (r.metrics.get(name) for r in results.of("sensorless", method))
        return figure(max((abs(value) for value in values if value is not None), default=None))

    return "; ".join(
        f"`{m}` is off by at most {worst(m, 'torque_bias_nm')} N·m, with a ripple of at most "
        f"{worst(m, 'torque_ripple_rms_nm')} N·m RMS"
        for m in BEST
        if m in results.methods
    )


def _cycle(results: Results) -> str:
    def of(name: str, digits: int, scale: float = 1.0) -> Value:
        return lambda method: _scaled(results, method, "constant", name, digits, scale)

    return _by_method(
        results,
        [
            ("torque error, RMS [N·m]", of("torque_error_rms_nm", 3)),
            ("switching frequency [kHz]", of("switching_frequency_hz", 1, 1e-3)),
            ("energy from the link [kJ]", of("energy_from_link_j", 1, 1e-3)),
            ("energy into the link [kJ]", of("energy_to_link_j", 1, 1e-3)),
            ("copper loss [kJ]", of("energy_copper_j", 1, 1e-3)),
        ],
    )


def _scaled(results: Results, method: str, optimum: str, name: str, digits: int, scale: float) -> str:
    found = results.metric("cycle", method, (optimum,), name)
    return figure(None if found is None else found * scale, digits)


def _flux(results: Results) -> str:
    methods = [m for m in results.methods if len(results.of("cycle", m)) == len(OPTIMA)]
    rows = []
    for method in methods:
        for optimum in OPTIMA:
            rows.append((
                f"`{method}`, `{optimum}`",
                _scaled(results, method, optimum, "energy_copper_j", 1, 1e-3),
                _scaled(results, method, optimum, "torque_error_rms_nm", 3, 1),
                _scaled(results, method, optimum, "switching_frequency_hz", 1, 1e-3),
            ))  # fmt: skip
    heads = ("", "copper loss [kJ]", "torque error, RMS [N·m]", "switching [kHz]")
    return table(heads, rows)


def _cost(results: Results) -> str:
    counts = cost.instructions()

    def of(which: str) -> Value:
        return lambda m: f"{counts[m][which]:,.0f}" if m in counts else "–"

    return _by_method(
        results,
        [
            ("CPU time [ns]", lambda m: figure(results.step_ns.get(m), 0)),
            ("Cortex-M4F, instructions, mean", of("mean")),
            ("Cortex-M4F, instructions, most", of("max")),
        ],
    )


def tables(results: Results) -> dict[str, str]:
    return {
        "sampling": _section(results, "sampling"),
        "switching": _section(results, "switching"),
        "start": _starts(results),
        "detuned": _detuned(results),
        "sensorless": _sensorless(results),
        "flux": _flux(results),
        "cost": _cost(results),
        "cycle": _cycle(results),
    }


def text(results: Results) -> str:
    """For the terminal."""
    shown = {name: one for name, one in tables(results).items() if name in SHORT}
    return "\n\n".join(f"{name}\n{one}" for name, one in shown.items())


def write(results: Results, docs: Path) -> list[Path]:
    images = docs / "images"
    pictures = figures.draw(results, images)
    failed = [r for r in results.records if r.reason]
    content = filled(
        TEMPLATE,
        dict(
            version=results.version,
            commit=results.commit,
            speed=REFERENCE[0],
            torque=REFERENCE[1],
            kilohertz=SWITCHING_HZ // 1000,
            low=LOW_SPEED,
            runs=len(results.records),
            failed="; ".join(f"{r.method}, {r.section} {r.what}: {r.reason}" for r in failed) or "none",
            **tables(results),
        ),
    )
    page = docs / "controllers.md"
    page.write_text(content, encoding="utf-8")
    return [*pictures, page]
