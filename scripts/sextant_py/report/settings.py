"""What a person asks of a report, beside the runs."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .. import mil_program
from .pictures import Span


@dataclass(frozen=True)
class Settings:
    signals: tuple[str, ...] = ()  # to draw; empty: torque, flux, speed and current
    span: Span = (None, None)  # to draw [s]
    mil: Path | None = None  # the sextant-mil that knows the defaults

    @cached_property
    def program(self) -> Path:
        """UserError: there is none."""
        return mil_program.find(self.mil)
