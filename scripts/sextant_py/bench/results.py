"""out/bench.json, kept from run to run, so that one stage can be measured again; and the page made of it."""

import json
import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py import page
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from .figure import PUBLISHED, Figure

FORMAT = 2
PAGE = ROOT / "docs" / "performance.md"
IMAGES = ROOT / "docs" / "images"
PLOTS = {"growth": "growth.png", "live": "latency.png"}  # by stage, in the folder beside the results
PERCENTILES = ("p50_us", "p99_us", "p99.9_us", "p99.99_us")
LATENCY = (
    "\n\n![Wake-up latency beside cyclictest, and command to gate](images/latency.png)\n\n"
    "*Left: the part of the wake-ups later than so many microseconds. Right: the same for the time from the arrival"
    " of a command's frame, as the kernel stamped it, to the first gate pattern decided with it.*"
)


@dataclass
class StageResult:
    title: str
    figures: list[Figure]
    seconds: float = 0.0
    load: float = 0.0  # load average when it began
    distributions: dict[str, dict[str, float]] = field(default_factory=dict)

    def to_json(self) -> dict:
        return vars(self) | {"figures": [figure.to_json() for figure in self.figures]}

    @staticmethod
    def from_json(data: dict) -> "StageResult":
        return StageResult(**data | {"figures": [Figure.from_json(figure) for figure in data["figures"]]})


Stages = dict[str, StageResult]


def read(file: Path) -> Stages:
    """Throws UserError where the file is no result of a benchmark."""
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
        if data["format"] != FORMAT:
            raise UserError(f"{file} has format {data['format']}, not {FORMAT}; measure again with scripts/bench.")
        return {name: StageResult.from_json(stage) for name, stage in data["stages"].items()}
    except OSError as error:
        raise UserError(f"{file} cannot be read: {error.strerror}.") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{file} is no result of scripts/bench ({type(error).__name__}: {error}).") from error


def write(file: Path, stages: Stages) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    content = {"format": FORMAT, "stages": {name: stage.to_json() for name, stage in stages.items()}}
    file.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def terminal(stages: Stages) -> str:
    lines = []
    for name, stage in stages.items():
        lines += ["", f"{name}: {stage.title}"]
        for f in stage.figures:
            verdict = "" if f.verdict == PUBLISHED else f.verdict
            note = f"  ({f.note})" if f.note else ""
            lines.append(f"  {f.measure:<86} {f.shown:>12} {f.target:>10}  {verdict}{note}")
    return "\n".join(lines[1:])


def tables(stages: Stages) -> dict[str, str]:
    """By mark of the page: figures with a target, figures without, and the distributions."""
    with_target, without, distributions = [], [], []
    for name, stage in stages.items():
        for f in stage.figures:
            stage_name = f"`{name}`"
            measure = f"{f.measure} ({f.note})" if f.note else f.measure
            target, shown = (text.replace(" x", " ×") for text in (f.target, f.shown))
            if f.target:
                with_target.append((measure, target, shown, f.verdict, stage_name))
            else:
                without.append((measure, shown if f.verdict == PUBLISHED else f.verdict, stage_name))
        for text, summary in stage.distributions.items():
            values = [f"{summary[key]:.3g}" for key in PERCENTILES]
            distributions.append((text, summary["count"], *values, f"{summary['max_us']:.4g}"))
    head = ("[µs]", "samples", "median", "99 %", "99.9 %", "99.99 %", "longest")
    found = {
        "judged figures": page.table(("measure", "target", "figure", "verdict", "stage"), with_target, (0, 3, 4)),
        "published figures": page.table(("measure", "figure", "stage"), without, (0, 2)),
    }
    return found | ({"latency": page.table(head, distributions) + LATENCY} if distributions else {})


def write_page(file: Path, stages: Stages, plots: Path) -> None:
    """The tables of all stages, and where it is the committed page, its pictures. Throws UserError, and writes nothing,
    where the page has figures of a stage that was not measured: they would be lost."""
    text = file.read_text(encoding="utf-8")
    lost = sorted(set(re.findall(r"\| `(\w+)` \|$", text, re.MULTILINE)) - set(stages))
    if lost:
        raise UserError(
            f"{file} has figures of stages that were not measured here, {', '.join(lost)}, and would lose them;"
            " run scripts/bench --write-page without --only."
        )
    for mark, content in tables(stages).items():
        text = page.put(text, mark, content)
    file.write_text(text, encoding="utf-8")
    for stage, plot in PLOTS.items():
        if file == PAGE and stage in stages and (plots / plot).exists():
            shutil.copyfile(plots / plot, IMAGES / plot)
