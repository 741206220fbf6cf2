"""Every topic of the telemetry, declared in the wrong ways that a reader may think of."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from cyclonedds.idl import make_idl_enum, make_idl_struct, types
from cyclonedds.idl.annotations import appendable, final, mutable
from sextant_py import dds
from sextant_py.telemetry_types import fields

TOPICS = (dds.TELEMETRY, dds.STATE, dds.STATISTICS)
# Of the many members of RealTimeStatistics each is declared by so many wrong types, others from member to member.
FEW = 4

_NESTED = final(make_idl_struct("Nested", "sextant.Nested", {"value": types.uint8, "other": types.int8}))
_PRIMITIVES = {
    "octet": types.byte,
    "int8": types.int8,
    "uint8": types.uint8,
    "int16": types.int16,
    "uint16": types.uint16,
    "int32": types.int32,
    "uint32": types.uint32,
    "int64": types.int64,
    "uint64": types.uint64,
    "float": types.float32,
    "double": types.float64,
    "boolean": bool,
    "char": types.char,
    "string": str,
    "string<8>": types.bounded_str[8],
    "another enumeration": make_idl_enum("OtherKind", "sextant.OtherKind", {"ONE": 0, "TWO": 1}),
    "a nested struct": _NESTED,
}
_COLLECTIONS = {
    **{f"sequence<{name}>": types.sequence[kind] for name, kind in _PRIMITIVES.items()},
    **{f"sequence<{name}, 3>": types.sequence[kind, 3] for name, kind in _PRIMITIVES.items()},
    **{f"{name}[2]": types.array[kind, 2] for name, kind in _PRIMITIVES.items()},
}


@dataclass(frozen=True)
class Declaration:
    """A topic as somebody declares it."""

    topic: str
    what: str
    members: dict[str, type]
    keys: tuple[str, ...] = ("drive_id",)
    extensibility: Callable[[type], type] = appendable
    name: str = field(default="")

    def kind(self, module: str = "sextant") -> type:
        """The type, in the module that its reader has named."""
        name = self.name or self.topic.partition("/")[2]
        annotations = {key: {"key": True} for key in self.keys if key in self.members}
        return self.extensibility(
            make_idl_struct(name, f"{module}.{name}", self.members, field_annotations=annotations)
        )


def _of_types(topic: str, members: dict[str, type]) -> Iterator[Declaration]:
    """Each member by each other primitive type, and by three collections each, others from member to member."""
    primitives, collections = list(_PRIMITIVES.items()), list(_COLLECTIONS.items())
    for index, (member, right) in enumerate(members.items()):
        wrong = primitives
        if topic == dds.STATISTICS:
            wrong = [primitives[(FEW * index + k) % len(primitives)] for k in range(FEW)]
        wrong = [*wrong, *(collections[(3 * index + k) % len(collections)] for k in range(3))]
        for text, kind in wrong:
            # The library of the readers does not take a struct as a key.
            if kind is not right and (member, kind) != ("drive_id", _NESTED):
                yield Declaration(topic, f"{member} as {text}", {**members, member: kind})


def _of_members(topic: str, members: dict[str, type]) -> Iterator[Declaration]:
    """Members that are missing, renamed, added or elsewhere; a last one that is missing or added is not wrong."""
    *others, last = members
    for member in members:
        without = {key: kind for key, kind in members.items() if key != member}
        renamed = {(f"{key}_" if key == member else key): kind for key, kind in members.items()}
        if member != last:
            yield Declaration(topic, f"without {member}", without)
        yield Declaration(topic, f"{member} renamed", renamed)
    for text, kind in {**_PRIMITIVES, **_COLLECTIONS}.items():
        before_last = {**{other: members[other] for other in others}, "added": kind, last: members[last]}
        yield Declaration(topic, f"{text} added", before_last)
    yield Declaration(topic, "members backwards", dict(reversed(members.items())))
    yield Declaration(topic, "no member but the key", {"drive_id": members["drive_id"]})


def _of_structure(topic: str, members: dict[str, type]) -> Iterator[Declaration]:
    """Keys, extensibility, nesting, and the types of the other topics."""
    yield Declaration(topic, "without a key", members, keys=())
    for member in list(members)[1:3]:
        yield Declaration(topic, f"{member} as second key", members, keys=("drive_id", member))
        yield Declaration(topic, f"{member} as the only key", members, keys=(member,))
    for extend in (final, mutable):
        yield Declaration(topic, extend.__name__, members, extensibility=extend)
        more = {**members, "added": types.uint8}
        yield Declaration(topic, f"{extend.__name__}, uint8 added", more, extensibility=extend)
    inner = Declaration(topic, "", members, name=f"{topic.partition('/')[2]}Inner").kind()
    yield Declaration(topic, "nested in a struct", {"drive_id": types.uint32, "inner": inner})
    yield Declaration(topic, "a sequence of it", {"drive_id": types.uint32, "inner": types.sequence[inner]})
    for other in TOPICS:
        if other != topic:
            name = other.partition("/")[2]
            yield Declaration(topic, f"as {name}", fields(name), name=name)


def every() -> list[Declaration]:
    """All of them; the natural mistake first, an octet read as uint8."""
    first = Declaration(
        dds.TELEMETRY, "as many read it: sector as uint8", {**fields("DriveTelemetry"), "sector": types.uint8}
    )
    declarations = [first]
    for topic in TOPICS:
        members = fields(topic.partition("/")[2])
        for ways in (_of_types, _of_members, _of_structure):
            declarations += ways(topic, members)
    return declarations
