"""Units from the ends of signal names."""

_UNITS = {
    "_rad_s": "rad/s",
    "_rad_s2": "rad/s²",
    "_rad": "rad",
    "_nm": "N·m",
    "_wb": "Wb",
    "_a": "A",
    "_v": "V",
    "_w": "W",
    "_ns": "ns",
    "_us": "µs",
    "_ms": "ms",
    "_s": "s",
}


def unit_of(name: str) -> str:
    """The unit of a signal, "" for a pure number."""
    for ending in sorted(_UNITS, key=len, reverse=True):
        if name.endswith(ending):
            return _UNITS[ending]
    return ""
