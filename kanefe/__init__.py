"""kanefe: Kane's method for rigid bodies coupled to finite-element flexible bodies.

Importing the package loads nothing heavy: each public name is imported when it is first used.
"""

from typing import TYPE_CHECKING

from kanefe._public import SERVED, lazy
from kanefe._version import __version__
from kanefe.storage.forks import renew_locks_in_children

if TYPE_CHECKING:
    from kanefe import fatigue as fatigue
    from kanefe import studies as studies
    from kanefe.batches import simulate_many as simulate_many
    from kanefe.bodies.exact.strain_basis import BSpline as BSpline
    from kanefe.bodies.exact.strain_basis import Legendre as Legendre
    from kanefe.bodies.flexible import FlexibleBody as FlexibleBody
    from kanefe.bodies.segmented import SegmentedBody as SegmentedBody
    from kanefe.certified import *  # noqa: F403
    from kanefe.contact import *  # noqa: F403
    from kanefe.contact import shapes as shapes
    from kanefe.environment import *  # noqa: F403
    from kanefe.equations.model import Model as Model
    from kanefe.errors import AccuracyWarning as AccuracyWarning
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
    from kanefe.fe_model.mapped_field import MappedField as MappedField
    from kanefe.fe_model.mapped_field import MappedHistory as MappedHistory
    from kanefe.fe_model.model import Cells as Cells
    from kanefe.fe_model.model import FiniteElementModel as FiniteElementModel
    from kanefe.fe_model.model import MassField as MassField
    from kanefe.fe_model.place_field import LoadShape as LoadShape
    from kanefe.fe_model.places import InBox as InBox
    from kanefe.fe_model.places import InCylinder as InCylinder
    from kanefe.fe_model.places import Near as Near
    from kanefe.fe_model.places import OnPlane as OnPlane
    from kanefe.frames import euler_angles as euler_angles
    from kanefe.frames import rotation_about as rotation_about
    from kanefe.imports import read_abaqus as read_abaqus
    from kanefe.imports import read_ansys as read_ansys
    from kanefe.imports import read_calculix as read_calculix
    from kanefe.imports import read_matrices as read_matrices
    from kanefe.imports import read_matrix_market as read_matrix_market
    from kanefe.imports import read_nastran as read_nastran
    from kanefe.imports import read_sid as read_sid
    from kanefe.imports import write_matrices as write_matrices
    from kanefe.imports import write_sid as write_sid
    from kanefe.imports import write_superelement as write_superelement
    from kanefe.imports.from_matrices import model_from_matrices as model_from_matrices
    from kanefe.imports.own_elements import FiniteElements as FiniteElements
    from kanefe.imports.own_elements import model_from_elements as model_from_elements
    from kanefe.instants.instant import Instant as Instant
    from kanefe.integrate.events.event import Event as Event
    from kanefe.integrate.methods.table import methods as methods
    from kanefe.integrate.status import RunStatus as RunStatus
    from kanefe.joints import *  # noqa: F403
    from kanefe.joints.base import AxisJoint as AxisJoint
    from kanefe.linear.equilibrium.equilibria import equilibrium as equilibrium
    from kanefe.linear.equilibrium.rest import Equilibrium as Equilibrium
    from kanefe.linear.frequency_response import FrequencyResponse as FrequencyResponse
    from kanefe.linear.linearisation import Linearisation as Linearisation
    from kanefe.linear.linearisation import linearise as linearise
    from kanefe.linear.modes.floquet_modes import FloquetModes as FloquetModes
    from kanefe.linear.modes.floquet_modes import floquet as floquet
    from kanefe.linear.modes.modes import Modes as Modes
    from kanefe.linear.over_speed.campbell_diagram import Campbell as Campbell
    from kanefe.linear.over_speed.campbell_diagram import campbell as campbell
    from kanefe.linear.over_speed.stability_maps import stability_map as stability_map
    from kanefe.linear.over_speed.stability_over_speed import StabilityMap as StabilityMap
    from kanefe.linear.paths.equilibrium_path import equilibrium_path as equilibrium_path
    from kanefe.linear.paths.path_of_equilibria import CriticalPoint as CriticalPoint
    from kanefe.linear.paths.path_of_equilibria import EquilibriumPath as EquilibriumPath
    from kanefe.linear.sampled.sampled_loop import SampledLoop as SampledLoop
    from kanefe.linear.sampled.sampled_loop import sampled_loop as sampled_loop
    from kanefe.linear.scene_damping import SceneDamping as SceneDamping
    from kanefe.linear.stability.buckling_modes import Buckling as Buckling
    from kanefe.linear.stability.buckling_modes import buckling as buckling
    from kanefe.linear.stability.stability_limit import StabilityLimit as StabilityLimit
    from kanefe.linear.stability.stability_limit import stability_limit as stability_limit
    from kanefe.loads import *  # noqa: F403
    from kanefe.records.record import Record as Record
    from kanefe.records.record_file import load_records as load_records
    from kanefe.reduction import CraigBampton as CraigBampton
    from kanefe.reduction import FreeInterface as FreeInterface
    from kanefe.reduction import Krylov as Krylov
    from kanefe.reduction import LoadCase as LoadCase
    from kanefe.reduction import PatchCase as PatchCase
    from kanefe.reduction import flexible_body as flexible_body
    from kanefe.result import Result as Result
    from kanefe.result import load_result as load_result
    from kanefe.results.accuracy import Accuracy as Accuracy
    from kanefe.robots import *  # noqa: F403
    from kanefe.scene.scene import Frame as Frame
    from kanefe.screening import ScreenedRun as ScreenedRun
    from kanefe.screening import screen as screen
    from kanefe.stepping.simulation import Simulation as Simulation
    from kanefe.studies.study import Study as Study
    from kanefe.studies.table import StudyTable as StudyTable
    from kanefe.system import System as System
    from kanefe.tree.scene_state import SceneState as SceneState

SERVED.update(
    body_card="kanefe.views.cards.body_card",
    body_report="kanefe.report.body",
    draw_rao="kanefe.views.rao_picture",
    write_linear="kanefe.fmu.export",
)
renew_locks_in_children()
_names, __getattr__, __dir__ = lazy(__file__, globals())
__all__ = [*_names, "__version__"]
