"""Materials: how things break, weigh and look."""
from __future__ import annotations

from ctypes import byref, sizeof
from dataclasses import dataclass
from typing import Any

from . import _library as lib

MATERIALS = lib.material_names()  #: the names that material() knows


@dataclass(frozen=True)
class Material:
    """Handbook values of a material, and how it breaks. SI units."""

    name: str
    density: float  #: kg/m^3
    friction: float
    restitution: float
    tensile: float  #: strength, Pa, as the next two
    compressive: float
    shear: float
    fracture_toughness: float  #: K_IC, Pa m^1/2
    fracture_energy: float  #: J/m^2, that a blow spends on new surface
    pattern: str  #: of make_sites(), as the next four
    pattern_jitter: float
    pattern_spread: float
    pattern_slenderness: float
    pattern_axis: tuple[float, float, float]
    roughness: float  #: of fracture(), as the next two
    rough_grain: tuple[float, float, float]
    rough_detail: int
    exterior: tuple[float, float, float]  #: linear colour of the original surface
    interior: tuple[float, float, float]  #: linear colour of cuts


def material(name: str) -> Material:
    """The material of a name: one of MATERIALS."""
    found = lib.MaterialStruct(struct_size=sizeof(lib.MaterialStruct))
    lib.call("material_get", name.encode(), byref(found))
    values: dict[str, Any] = {}
    for field, *_ in found._fields_[1:]:
        value = getattr(found, field)
        values[field] = (value.decode() if isinstance(value, bytes) else value if isinstance(value, (int, float))
                         else tuple(value))
    return Material(**values)
