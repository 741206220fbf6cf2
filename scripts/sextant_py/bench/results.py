"""out/bench.json: the figures by stage, kept from run to run, so that one stage can be measured again."""

import json
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py.errors import UserError

from .figure import Figure

FORMAT = 1


@dataclass
class StageResult:
    title: str
    figures: list[Figure]
    seconds: float = 0.0
    load: float = 0.0  # load average when it began


@dataclass
class Results:
    stages: dict[str, StageResult] = field(default_factory=dict)

    @staticmethod
    def read(file: Path) -> "Results":
        """Throws UserError where the file is no result of a benchmark."""
        try:
            data = json.loads(file.read_text(encoding="utf-8"))
            if data["format"] != FORMAT:
                raise UserError(f"{file} has format {data['format']}, not {FORMAT}; measure again with scripts/bench.")
            return Results(
                {
                    name: StageResult(
                        stage["title"],
                        [Figure.from_json(figure) for figure in stage["figures"]],
                        stage.get("seconds", 0.0),
                        stage.get("load", 0.0),
                    )
                    for name, stage in data["stages"].items()
                }
            )
        except OSError as error:
            raise UserError(f"{file} cannot be read: {error.strerror}.") from error
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise UserError(f"{file} is no result of scripts/bench ({type(error).__name__}: {error}).") from error

    def write(self, file: Path) -> None:
        stages = {
            name: {
                "title": stage.title,
                "seconds": round(stage.seconds, 1),
                "load": round(stage.load, 2),
                "figures": [figure.to_json() for figure in stage.figures],
            }
            for name, stage in self.stages.items()
        }
        file.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"format": FORMAT, "stages": stages}, indent=1, ensure_ascii=False, allow_nan=True)
        file.write_text(text + "\n", encoding="utf-8")

    def add(self, other: "Results") -> None:
        """A stage of `other` takes the place of ours."""
        self.stages.update(other.stages)

    def in_order(self, names: list[str]) -> list[tuple[str, StageResult]]:
        """Known stages first, in their order; then what came from elsewhere."""
        known = [name for name in names if name in self.stages]
        return [(name, self.stages[name]) for name in [*known, *(n for n in self.stages if n not in names)]]
