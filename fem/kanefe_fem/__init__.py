"""kanefe_fem: flexible bodies for kanefe from meshes (gmsh, dolfinx, PETSc) and from beam elements (numpy, scipy).

Importing the package is fast: each public name is imported when it is first used, and dolfinx, PETSc and gmsh only when
a function needs them.
"""

from typing import TYPE_CHECKING

from kanefe._public import lazy

if TYPE_CHECKING:
    from kanefe_fem.assemblies.assembly import Assembly as Assembly
    from kanefe_fem.assemblies.parts import Part as Part
    from kanefe_fem.assemblies.proposals import ProposedJoint as ProposedJoint
    from kanefe_fem.assemblies.reading import read_step as read_step
    from kanefe_fem.beams.body import beam_body as beam_body
    from kanefe_fem.beams.body import beam_model as beam_model
    from kanefe_fem.beams.body import straight_beam as straight_beam
    from kanefe_fem.beams.exact import exact_beam as exact_beam
    from kanefe_fem.beams.from_mesh import beam_model_from_mesh as beam_model_from_mesh
    from kanefe_fem.beams.sections import Box as Box
    from kanefe_fem.beams.sections import Rectangle as Rectangle
    from kanefe_fem.beams.sections import Section as Section
    from kanefe_fem.beams.sections import SolidCircle as SolidCircle
    from kanefe_fem.beams.sections import Tube as Tube
    from kanefe_fem.beams.stiffness_section import StiffnessSection as StiffnessSection
    from kanefe_fem.lumped.parts import LumpedMass as LumpedMass
    from kanefe_fem.lumped.parts import LumpedSpring as LumpedSpring
    from kanefe_fem.lumped.parts import attach as attach
    from kanefe_fem.materials.damping import PronyFit as PronyFit
    from kanefe_fem.materials.damping import prony_of_loss_factor as prony_of_loss_factor
    from kanefe_fem.materials.isotropic import Material as Material
    from kanefe_fem.materials.laminate import Laminate as Laminate
    from kanefe_fem.materials.laminate import Ply as Ply
    from kanefe_fem.materials.oriented import Oriented as Oriented
    from kanefe_fem.materials.oriented import axes_at_angle as axes_at_angle
    from kanefe_fem.materials.oriented import cylindrical_axes as cylindrical_axes
    from kanefe_fem.materials.oriented import spherical_axes as spherical_axes
    from kanefe_fem.materials.orthotropic import Anisotropic as Anisotropic
    from kanefe_fem.materials.orthotropic import Orthotropic as Orthotropic
    from kanefe_fem.materials.strengths import Strengths as Strengths
    from kanefe_fem.materials.user_energy import UserEnergy as UserEnergy
    from kanefe_fem.mesh.mesh import Mesh as Mesh
    from kanefe_fem.mesh.refinement import refined_mesh as refined_mesh
    from kanefe_fem.mesh.simple import box_mesh as box_mesh
    from kanefe_fem.mesh.simple import cylinder_mesh as cylinder_mesh
    from kanefe_fem.mesh.simple import rectangle_mesh as rectangle_mesh
    from kanefe_fem.mesh.surface_grid import surface_mesh as surface_mesh
    from kanefe_fem.mesh_files import read_mesh as read_mesh
    from kanefe_fem.recovery.gauges import rosette_principal as rosette_principal
    from kanefe_fem.recovery.recovery import recover as recover
    from kanefe_fem.segments.segmented import segmented as segmented
    from kanefe_fem.shells.body import shell_body as shell_body
    from kanefe_fem.shells.body import shell_model as shell_model
    from kanefe_fem.shells.deck_properties import shell_properties as shell_properties
    from kanefe_fem.shells.faces import ShellFace as ShellFace
    from kanefe_fem.shells.stiffener import Stiffener as Stiffener
    from kanefe_fem.solids.body import solid_body as solid_body
    from kanefe_fem.solids.model import solid_model as solid_model
    from kanefe_fem.solids.own_forms import Forms as Forms
    from kanefe_fem.solids.potential_flow import PotentialFlow as PotentialFlow
    from kanefe_fem.solids.preload import Preload as Preload
    from kanefe_fem.solids.preload import preloaded as preloaded

__all__, __getattr__, __dir__ = lazy(__file__, globals())
