"""Size and colours of a picture."""

from collections.abc import Mapping
from dataclasses import dataclass, field

WIDTH_IN, PANEL_IN = 11.0, 2.6
NARROW_IN = 6.0  # below it the entries of a legend stand under each other


@dataclass(frozen=True)
class Look:
    width_in: float = WIDTH_IN
    panel_in: float = PANEL_IN  # height of a panel of lines
    style: Mapping[str, object] = field(default_factory=dict)  # of matplotlib, beside that of every picture
    colours: Mapping[str, str] = field(default_factory=dict)  # what is drawn instead of a colour of `styles`

    @property
    def is_narrow(self) -> bool:
        return self.width_in < NARROW_IN

    @property
    def share(self) -> float:
        """The width, of that of a common picture."""
        return self.width_in / WIDTH_IN

    def colour(self, common: str) -> str:
        return self.colours.get(common, common)


COMMON = Look()
