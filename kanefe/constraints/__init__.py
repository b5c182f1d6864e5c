"""Loop joints and couplers: scalar constraint equations beside the tree of joints."""

from kanefe.constraints.rows import (
    Constraint,
    CouplerRow,
    DirectionRow,
    DistanceRow,
    PointRow,
    RollingRow,
    Row,
    ScrewRow,
)

__all__ = [
    "Constraint",
    "CouplerRow",
    "DirectionRow",
    "DistanceRow",
    "PointRow",
    "RollingRow",
    "Row",
    "ScrewRow",
]
