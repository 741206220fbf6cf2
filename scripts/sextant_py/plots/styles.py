"""Colours and dashes of the lines of a panel, the same in pictures and pages."""

from dataclasses import dataclass

from .panels import Line

COLOURS = (
    *("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd"),
    *("#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf"),
)
DASHES = 4  # solid, dashed, dotted, dashed and dotted
SOLID, DASHED, DOTTED = range(3)
REFERENCE, REQUESTED = "#d95f02", "#7f7f7f"


@dataclass(frozen=True)
class Style:
    colour: str
    dash: int = SOLID


def numbered(number: int) -> Style:
    return Style(COLOURS[number % len(COLOURS)], number // len(COLOURS) % DASHES)


def of_lines(lines: list[Line]) -> tuple[list[Style], list[tuple[str, Style]]]:
    """The style of each line, and the entries of the legend. Several signals of several files: a signal has a colour, a
    file a dash, and the legend has the signals and the files rather than each pair."""
    signals, files = (
        list(dict.fromkeys(parts)) for parts in zip(*((line.name, line.file) for line in lines), strict=True)
    )
    if len(signals) > 1 and 1 < len(files) <= DASHES and len(signals) <= len(COLOURS):
        colour = {name: COLOURS[number] for number, name in enumerate(signals)}
        dash = {name: number for number, name in enumerate(files)}
        entries = [(name, Style(colour[name])) for name in signals]
        entries += [(name, Style(REQUESTED, dash[name])) for name in files]
        return [Style(colour[line.name], dash[line.file]) for line in lines], entries
    styles, number = [], 0
    for line in lines:
        role = line.role if len(files) == 1 else ""
        if role:
            styles.append(Style(REFERENCE, DASHED) if role == "reference" else Style(REQUESTED, DOTTED))
        else:
            styles.append(numbered(number))
            number += 1
    return styles, [(line.label, style) for line, style in zip(lines, styles, strict=True)]
