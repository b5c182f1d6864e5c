"""The plugin's verification cases for ``kanefe verify``.

`beams` needs numpy and scipy alone, `solids` a mesh assembler.
"""
