"""Define a scene by its tables and dotted keys.

Values are in SI after validation; a table that is None is absent from the model.
"""

import math
from types import MappingProxyType
from typing import Any, get_args

from pydantic.fields import FieldInfo

from tailslap.errors import InputError, Missing
from tailslap.scene import model_tables as model
from tailslap.scene import vehicle_tables as vehicles
from tailslap.scene.types import Name, SceneTable, needed

LISTED = ("trailer", "axle", "strip")
"""Names of lists of tables, [[NAME]]."""


class Scene(SceneTable):
    """One impact, with the models that represent it."""

    name: Name = needed("name of the scene and of its result folder")
    vehicle: vehicles.Vehicle
    trailer: tuple[vehicles.Trailer, ...] = ()
    impact: vehicles.Impact | None = None
    start: vehicles.StartTable | None = None
    corner: vehicles.CornerTable = vehicles.CornerTable()
    contact: vehicles.Contact | None = None
    axle: tuple[vehicles.Axle, ...] = ()
    body: vehicles.Body | None = None
    strip: tuple[vehicles.StripTable, ...] = ()
    sensor: vehicles.Sensor | None = None
    strike: vehicles.StrikeTable = vehicles.StrikeTable()
    plate: model.Plate | None = None
    material: model.MaterialTable | None = None
    damping: model.Damping | None = None
    verify: model.Verify = model.Verify()
    time: model.Time = model.Time()
    output: model.Output | None = None
    wall: model.Wall | None = None
    parapet: model.Parapet | None = None

    @property
    def units(self) -> tuple[vehicles.Vehicle, ...]:
        """The vehicle and its trailers, front to rear."""
        return (self.vehicle, *self.trailer)

    @property
    def starts_later(self) -> bool:
        """True if [start] defines the whole initial state of Stage 2.

        [impact] is then not used.
        """
        start = self.start or vehicles.StartTable()
        return None not in (start.angle, start.omega, start.corner_speed)

    @property
    def needed_plate(self) -> model.Plate:
        """The plate of a finite-element run.

        Raises InputError where the scene has none.
        """
        if self.plate is None:
            raise InputError("plate", Missing, "this table is required for a finite-element run")
        return self.plate

    @property
    def needed_contact(self) -> vehicles.Contact:
        """The contact of a whole impact.

        Raises InputError where the scene has none.
        """
        if self.contact is None:
            raise InputError("contact", Missing, "this table is required for a whole impact")
        return self.contact

    @property
    def crushes(self) -> bool:
        """True if what touches the wall crushes."""
        return bool(self.strip) or self.needed_contact.of_corners

    @property
    def has_points(self) -> bool:
        """True if a corner or a point touches the wall."""
        return bool(self.of_corners) or any(strip.at[0] == strip.at[1] for strip in self.strip)

    @property
    def of_corners(self) -> tuple[int, ...]:
        """Numbers from 1 of the units without strips, whose corners touch."""
        return tuple(u for u in range(1, 1 + len(self.units)) if all(strip.unit != u for strip in self.strip))

    @property
    def meshed_wall(self) -> model.Wall | None:
        """The wall, if it has a mesh."""
        return self.wall if self.wall and self.wall.elements else None

    @property
    def kept_fields(self) -> int:
        """Number of instants at which fields are stored."""
        return self.output.fields if self.output else 0

    @property
    def corner_friction(self) -> float:
        """Coefficient of friction in Stage 2.

        corner.friction, by default impact.friction; 0 for a reaction without friction.
        """
        if self.corner.frictionless:
            return 0.0
        friction = self.corner.friction
        friction = self.impact.friction if friction is None and self.impact else friction
        return math.nan if friction is None else friction


def table_of(field: FieldInfo) -> type[SceneTable] | None:
    """Return the table that a key holds, None for a value.

    Of a list of tables it is that of the elements.
    """
    kinds = (field.annotation, *get_args(field.annotation))
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, SceneTable)), None)


def values_of(table: type[SceneTable]) -> dict[str, FieldInfo]:
    """Return the keys of a table that are no tables themselves."""
    return {name: field for name, field in table.model_fields.items() if table_of(field) is None}


def _tables(table: type[SceneTable], prefix: str = "") -> dict[str, type[SceneTable]]:
    """Return the tables in a table by dotted name.

    Each table comes before those in it.
    """
    tables: dict[str, type[SceneTable]] = {}
    for name, field in table.model_fields.items():
        if inner := table_of(field):
            tables |= {f"{prefix}{name}": inner, **_tables(inner, f"{prefix}{name}.")}
    return tables


TABLES = _tables(Scene)
"""Tables of a scene by dotted name; of a list of tables, its element."""


def value_at(scene: Any, key: str) -> Any:
    """Return the value of a dotted key, e.g. "trailer.0.mass".

    It is None in an omitted table.
    """
    for name in key.split("."):
        if scene is not None:
            scene = scene[int(name)] if isinstance(scene, tuple) else getattr(scene, name)
    return scene


MEANINGS = MappingProxyType(
    {"name": Scene.model_fields["name"].description or ""}
    | {
        f"{name}.{k}": field.description or ""
        for name, table in TABLES.items()
        for k, field in values_of(table).items()
    }
)
"""Meaning of each key of a scene, by its dotted name."""
