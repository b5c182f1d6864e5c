"""The verification cases of `kanefe_fem` for ``kanefe verify``.

`beams` needs only numpy and scipy, `solids` also dolfinx.
"""
