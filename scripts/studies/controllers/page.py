"""The page of the bench of control methods, from its results."""

from collections.abc import Callable, Iterable
from pathlib import Path

from studies.page import figure, filled, table
from studies.published import published

from . import cost, figures
from .cases import BEST, DETUNED, LOW_SPEED, OPTIMA, REFERENCE, SWITCHING_HZ
from .measure import Record, Results

TEMPLATE = Path(__file__).with_name("page.md")
Value = Callable[[str], object]
SHORT = ("sampling", "switching", "start")  # what --quick measures


def _by_method(results: Results, rows: Iterable[tuple[str, Value]]) -> str:
    return table(("", *results.methods), ((title, *(value(m) for m in results.methods)) for title, value in rows))


def _of(results: Results, section: str, what: tuple, *metrics: tuple) -> Value:
    """Of a method its metrics in one case of a section, each by name, digits and scale."""

    def value(method: str) -> str:
        found = ((results.metric(section, method, what, name), *form) for name, *form in metrics)
        return "/".join(figure(*one) for one in found)

    return value


def _worst(records: Iterable[Record], of: str | Callable[[Record], float | None], digits: int = 2) -> str:
    """The largest magnitude of a metric, or of a figure of the records."""
    values = [r.metrics.get(of) if isinstance(of, str) else of(r) for r in records]
    return figure(max((abs(value) for value in values if value is not None), default=None), digits)


def _section(results: Results, section: str) -> str:
    """At the reference point, and the worst over all points whose torque is available."""

    def of(*metric: object) -> Value:
        return _of(results, section, REFERENCE, metric)

    def worst(name: str, digits: int) -> Value:
        return lambda m: _worst((r for r in results.of(section, m) if not r.reason and is_available(r)), name, digits)

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
    return abs(torque) < (published(record.metrics, speed, torque) or 0.0)


def _starts(results: Results) -> str:
    metrics = (("response_time_ms", 1), ("peak_current_a", 1))
    return _by_method(results, ((f"{limit} A", _of(results, "start", (limit,), *metrics)) for limit in (20, 40)))


def _detuned(results: Results) -> str:
    """Each wrong parameter with ideal sensors, and exact ones with real sensors."""
    cases = [(name, "ideal") for name in DETUNED] + [(next(iter(DETUNED)), "real")]
    metrics = (("torque_bias_nm",), ("torque_ripple_rms_nm",))
    return _by_method(
        results, ((f"{one[0]}, {one[1]} sensors", _of(results, "detuned", one, *metrics)) for one in cases)
    )


def _low_speed(results: Results) -> list[tuple[str, Value]]:
    """Over the points up to LOW_SPEED with torque, and 10 s at standstill."""

    def worst(of: str | Callable[[Record], float]) -> Value:
        def points(method: str) -> Iterable[Record]:
            return (r for r in results.of("sampling", method) if abs(r.what[0]) <= LOW_SPEED and is_available(r))

        return lambda m: _worst(points(m), of)

    standstill = _of(results, "standstill", (), ("torque_ripple_rms_nm",))
    return [
        ("low speed: torque ripple, RMS, worst [N·m]", worst("torque_ripple_rms_nm")),
        ("low speed: stator flux, worst deviation [%]", worst(lambda r: 100 * flux_error(r))),
        ("15 N·m at standstill for 10 s: ripple, RMS [N·m]", standstill),
    ]


def flux_error(record: Record) -> float:
    """Largest deviation of the stator flux from its middle, as a share of it."""
    least, most = record.metrics["flux_min_wb"], record.metrics["flux_max_wb"]
    return (most - least) / (most + least)


def _sensorless(results: Results) -> str:
    """The worst of each method over the points."""

    def worst(method: str, name: str) -> str:
        return _worst(results.of("sensorless", method), name)

    return "; ".join(
        f"`{m}` is off by at most {worst(m, 'torque_bias_nm')} N·m, with a ripple of at most "
        f"{worst(m, 'torque_ripple_rms_nm')} N·m RMS"
        for m in BEST
        if m in results.methods
    )


def _cycle(results: Results) -> str:
    metrics = {
        "torque error, RMS [N·m]": ("torque_error_rms_nm", 3),
        "switching frequency [kHz]": ("switching_frequency_hz", 1, 1e-3),
        "energy from the link [kJ]": ("energy_from_link_j", 1, 1e-3),
        "energy into the link [kJ]": ("energy_to_link_j", 1, 1e-3),
        "copper loss [kJ]": ("energy_copper_j", 1, 1e-3),
    }
    return _by_method(results, ((title, _of(results, "cycle", ("constant",), one)) for title, one in metrics.items()))


def _flux(results: Results) -> str:
    def row(method: str, optimum: str) -> tuple:
        def of(*metric: object) -> str:
            return _of(results, "cycle", (optimum,), metric)(method)

        error, switching = of("torque_error_rms_nm", 3), of("switching_frequency_hz", 1, 1e-3)
        return f"`{method}`, `{optimum}`", of("energy_copper_j", 1, 1e-3), error, switching

    methods = (m for m in results.methods if len(results.of("cycle", m)) == len(OPTIMA))
    heads = ("", "copper loss [kJ]", "torque error, RMS [N·m]", "switching [kHz]")
    return table(heads, (row(method, optimum) for method in methods for optimum in OPTIMA))


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
