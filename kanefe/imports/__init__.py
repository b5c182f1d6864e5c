"""Bodies from other programs: matrices of Abaqus, Nastran, Ansys and of plain files, and Standard Input Data (SID).

Every reader calls `kanefe.model_from_matrices`, whose self-check refuses matrices that are not those of a free body.
"""

from kanefe.imports.abaqus import read_abaqus as read_abaqus
from kanefe.imports.ansys import read_ansys as read_ansys
from kanefe.imports.calculix import read_calculix as read_calculix
from kanefe.imports.matrix_market import read_matrix_market as read_matrix_market
from kanefe.imports.nastran import read_nastran as read_nastran
from kanefe.imports.npz import read_matrices as read_matrices
from kanefe.imports.npz import write_matrices as write_matrices
from kanefe.imports.sid import read_sid as read_sid
from kanefe.imports.sid import write_sid as write_sid
from kanefe.imports.superelement import write_superelement as write_superelement
