"""kanefe: Kane's method for rigid bodies coupled to finite-element flexible bodies.

Importing the package loads nothing heavy: each public name is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from kanefe._version import __version__

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody as FlexibleBody
    from kanefe.errors import FileError as FileError
    from kanefe.errors import KanefeError as KanefeError
    from kanefe.errors import MeshError as MeshError
    from kanefe.errors import MissingDependency as MissingDependency
    from kanefe.errors import ModelError as ModelError
    from kanefe.errors import SimulationError as SimulationError
    from kanefe.errors import SimulationWarning as SimulationWarning
    from kanefe.fe_model.damping import ModalDamping as ModalDamping
    from kanefe.fe_model.damping import RayleighDamping as RayleighDamping
    from kanefe.fe_model.interface import Interface as Interface
    from kanefe.fe_model.load_pattern import NodalPattern as NodalPattern
    from kanefe.fe_model.model import FiniteElementModel as FiniteElementModel
    from kanefe.imports import read_abaqus as read_abaqus
    from kanefe.imports import read_ansys as read_ansys
    from kanefe.imports import read_matrices as read_matrices
    from kanefe.imports import read_matrix_market as read_matrix_market
    from kanefe.imports import read_nastran as read_nastran
    from kanefe.imports import read_sid as read_sid
    from kanefe.imports import write_matrices as write_matrices
    from kanefe.imports import write_sid as write_sid
    from kanefe.imports.from_matrices import model_from_matrices as model_from_matrices
    from kanefe.integrate.events import Event as Event
    from kanefe.integrate.status import RunStatus as RunStatus
    from kanefe.joints import CoordinateForce as CoordinateForce
    from kanefe.joints import Cylindrical as Cylindrical
    from kanefe.joints import Fixed as Fixed
    from kanefe.joints import Free as Free
    from kanefe.joints import Motion as Motion
    from kanefe.joints import Planar as Planar
    from kanefe.joints import Prismatic as Prismatic
    from kanefe.joints import Revolute as Revolute
    from kanefe.joints import Screw as Screw
    from kanefe.joints import Spherical as Spherical
    from kanefe.joints import Translation as Translation
    from kanefe.joints import Universal as Universal
    from kanefe.linear import Campbell as Campbell
    from kanefe.linear import Equilibrium as Equilibrium
    from kanefe.linear import FrequencyResponse as FrequencyResponse
    from kanefe.linear import Linearisation as Linearisation
    from kanefe.linear import Modes as Modes
    from kanefe.linear import campbell as campbell
    from kanefe.linear import equilibrium as equilibrium
    from kanefe.linear import linearise as linearise
    from kanefe.reduction import CraigBampton as CraigBampton
    from kanefe.reduction import Enriched as Enriched
    from kanefe.reduction import FreeInterface as FreeInterface
    from kanefe.reduction import Krylov as Krylov
    from kanefe.reduction import LoadCase as LoadCase
    from kanefe.reduction import flexible_body as flexible_body
    from kanefe.result import Result as Result
    from kanefe.result import load_result as load_result
    from kanefe.system import System as System

_HOMES = {
    "Campbell": "linear",
    "CoordinateForce": "joints",
    "CraigBampton": "reduction",
    "Cylindrical": "joints",
    "Enriched": "reduction",
    "Event": "integrate.events",
    "Equilibrium": "linear",
    "FileError": "errors",
    "FiniteElementModel": "finite_element_model",
    "Fixed": "joints",
    "FlexibleBody": "flexible",
    "Free": "joints",
    "FreeInterface": "reduction",
    "FrequencyResponse": "linear",
    "Interface": "interface",
    "KanefeError": "errors",
    "Krylov": "reduction",
    "Linearisation": "linear",
    "LoadCase": "reduction",
    "MeshError": "errors",
    "MissingDependency": "errors",
    "ModalDamping": "damping",
    "ModelError": "errors",
    "Modes": "linear",
    "Motion": "joints",
    "NodalPattern": "load_pattern",
    "Planar": "joints",
    "Prismatic": "joints",
    "RayleighDamping": "damping",
    "Result": "results",
    "Revolute": "joints",
    "Screw": "joints",
    "RunStatus": "integrate.status",
    "SimulationError": "errors",
    "SimulationWarning": "errors",
    "Spherical": "joints",
    "System": "system",
    "Translation": "joints",
    "Universal": "joints",
    "campbell": "linear",
    "equilibrium": "linear",
    "flexible_body": "reduction",
    "linearise": "linear",
    "load_result": "results",
    "model_from_matrices": "given_matrices",
    "read_abaqus": "imports",
    "read_ansys": "imports",
    "read_matrices": "imports",
    "read_matrix_market": "imports",
    "read_nastran": "imports",
    "read_sid": "imports",
    "write_matrices": "imports",
    "write_sid": "imports",
}

__all__ = [*_HOMES, "__version__"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'kanefe' has no attribute {name!r}")
    value = getattr(import_module(f"kanefe.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
