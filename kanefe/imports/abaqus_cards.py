"""Keywords of Abaqus and CalculiX by what they do to a mesh: place nodes, add mass or stiffness, or neither."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from kanefe.imports.abaqus_input import Keyword

PLACES = {
    "NFILL": "generates nodes",
    "NMAP": "places nodes",
    "IMPERFECTION": "places nodes",
    "ELGEN": "generates elements",
    "ELCOPY": "generates elements",
    "SYMMETRICMODELGENERATION": "generates elements",
    "IMPORT": "takes a mesh from another job",
    "REFINEMESH": "generates elements",
    "PARAMETER": "gives numbers by name",
}
"""Keywords that place or multiply nodes or elements and are not read, and what they do."""

ADDS = (
    *("MASS", "ROTARYINERTIA", "NONSTRUCTURALMASS", "SPRING", "DASHPOT", "GAP", "JOINT", "CONNECTORSECTION"),
    *("TIE", "COUPLING", "MPC", "NETWORKMPC", "EQUATION", "EQUATIONF", "RIGIDBODY", "KINEMATICCOUPLING", "FASTENER"),
    *("DISTRIBUTINGCOUPLING", "SHELLTOSOLIDCOUPLING", "EMBEDDEDELEMENT", "CYCLICSYMMETRYMODEL", "PRETENSIONSECTION"),
    *("MATRIXINPUT", "MATRIXASSEMBLE", "SUBSTRUCTUREPROPERTY", "INERTIARELIEF", "SUPERELEMENT"),
)
"""Keywords that change mass or stiffness and are no part of a mesh."""

DEPENDENT = ("TIE", "COUPLING", "MPC", "NETWORKMPC", "EQUATION", "EQUATIONF", "RIGIDBODY", "CYCLICSYMMETRYMODEL")
"""Keywords by which CalculiX makes nodes depend on others, so that their rows are not in its matrices."""

READ = {
    "NODE": ("NSET", "SYSTEM", "INPUT"),
    "NGEN": ("NSET", "LINE", "SYSTEM"),
    "NCOPY": ("CHANGE NUMBER", "OLD SET", "NEW SET", "SHIFT", "MULTIPLE", "REFLECT", "POLE"),
    "SYSTEM": (),
    "NSET": ("NSET", "GENERATE", "UNSORTED", "INTERNAL", "INSTANCE", "ELSET"),
    "ELEMENT": ("TYPE", "ELSET", "INPUT"),
    "ELSET": ("ELSET", "GENERATE", "UNSORTED", "INTERNAL", "INSTANCE"),
    "PART": ("NAME",),
    "ENDPART": (),
    "ASSEMBLY": ("NAME",),
    "ENDASSEMBLY": (),
    "INSTANCE": ("NAME", "PART", "LIBRARY", "INSTANCE"),
    "ENDINSTANCE": (),
}
"""Keywords that are read, and their parameters; others of these are told."""

_LEFT = """
HEADING PREPRINT RESTART STEP ENDSTEP SURFACE TRANSFORM ORIENTATION DISTRIBUTION DISTRIBUTIONTABLE AMPLITUDE
SOLIDSECTION SHELLSECTION SHELLGENERALSECTION BEAMSECTION BEAMGENERALSECTION MEMBRANESECTION FLUIDSECTION
SECTIONCONTROLS COHESIVESECTION GASKETSECTION EULERIANSECTION FRAMESECTION SURFACESECTION REBARLAYER REBAR
HOURGLASSSTIFFNESS TRANSVERSESHEARSTIFFNESS TRANSVERSESHEAR NORMAL NODALTHICKNESS USERELEMENT UELPROPERTY
INTEGRATEDOUTPUTSECTION MATERIAL ELASTIC DENSITY PLASTIC CYCLICHARDENING EXPANSION CONDUCTIVITY SPECIFICHEAT
SPECIFICGASCONSTANT CREEP CRUSHABLEFOAM DAMPING DEPVAR USERMATERIAL HYPERELASTIC HYPERFOAM VISCOELASTIC
ANISOTROPICHYPERELASTIC DEFORMATIONPLASTICITY MOHRCOULOMB MOHRCOULOMBHARDENING DAMAGEINITIATION DAMAGEEVOLUTION
RATEDEPENDENT POTENTIAL FAILSTRESS FAILSTRAIN FLUIDCONSTANTS FLUIDPROPERTIES ELECTRICALCONDUCTIVITY
MAGNETICPERMEABILITY CONCRETE CONCRETEDAMAGEDPLASTICITY DRUCKERPRAGER ACOUSTICMEDIUM UNIAXIALTESTDATA BIAXIALTESTDATA
PLANARTESTDATA VOLUMETRICTESTDATA SHEARTESTDATA LATENTHEAT INELASTICHEATFRACTION EOS SURFACEINTERACTION
SURFACEBEHAVIOR SURFACEPROPERTY FRICTION CONTACT CONTACTPAIR CONTACTINCLUSIONS CONTACTEXCLUSIONS
CONTACTPROPERTYASSIGNMENT CONTACTCONTROLS CONTACTCLEARANCE CONTACTDAMPING CONTACTFORMULATION
CONTACTINITIALIZATIONASSIGNMENT CONTACTINITIALIZATIONDATA CLEARANCE GAPCONDUCTANCE GAPHEATGENERATION COHESIVEBEHAVIOR
SURFACESMOOTHING CHANGEFRICTION CONNECTORBEHAVIOR CONNECTORELASTICITY CONNECTORDAMPING CONNECTORSTOP CONNECTORFRICTION
CONNECTORLOCK BOUNDARY BOUNDARYF INITIALCONDITIONS INITIALSTRAININCREASE PHYSICALCONSTANTS TEMPERATURE FIELD
BASEMOTION KINEMATIC DISTRIBUTING MODELCHANGE TIMEPOINTS VALUESATINFINITY SUBMODEL CONSTRAINTCONTROLS GEOSTATIC FILTER
FILEFORMAT RADIATE OUTPUT NODEFILE NODEPRINT NODEOUTPUT ELFILE ELPRINT ELEMENTOUTPUT CONTACTFILE CONTACTPRINT
CONTACTOUTPUT SECTIONPRINT ENERGYOUTPUT SYSTEMOUTPUT SURFACEFILM PSDDEFINITION SPECTRUM SURFACEFLAW DESIGNVARIABLES
SENSITIVITY OBJECTIVE FILM FLUIDCAVITY FLUIDBEHAVIOR PHYSICALPROPERTIES RANDOMRESPONSE USEREXTRACTION CYCHARDENING
MATRIX ELECTROMAGNETICS ROBUSTDESIGN CORRELATIONLENGTH CONDITIONS GREEN MODALDAMPING VIEWFACTOR MASSFLOW TARGETSURFACE
"""

LEFT = frozenset(_LEFT.split())
"""Keywords of a model that are left out: materials, sections, contacts, supports, output."""


def check_places(blocks: Iterable[Keyword], remedy: str) -> None:
    """Refuse what places or multiplies nodes or elements in a way that is not read.

    Raises
    ------
    FileError
        Naming the keyword and its line.
    """
    for block in blocks:
        does = PLACES.get(block.name)
        if does is not None:
            raise block.refused(f"{does}, which is not read. Remedy: write all nodes and elements out, {remedy}")


def adding(blocks: Iterable[Keyword]) -> dict[str, int]:
    """Return what changes mass or stiffness and is no part of a mesh: keyword -> first line."""
    found: dict[str, int] = {}
    for block in blocks:
        if block.name in ADDS:
            found.setdefault(f"*{block.name}", block.at)
    return found


def unknown(blocks: Iterable[Keyword]) -> dict[str, int]:
    """Return keywords of a model and parameters of those that are read which are not known: name -> first line."""
    found: dict[str, int] = {}
    known: Mapping[str, object] = READ | dict.fromkeys((*LEFT, *ADDS, *PLACES))
    is_in_step = False
    for block in blocks:
        is_in_step = block.name == "STEP" or (is_in_step and block.name != "ENDSTEP")
        if block.name not in known and not is_in_step:
            found.setdefault(f"*{block.name}", block.at)
        for option in block.options:
            if option not in READ.get(block.name, (option,)):
                found.setdefault(f"{option} of *{block.name}", block.at)
    return found
