"""How Sphinx builds the site. `make docs` runs it; see `.ci/docs`."""

import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS / "_ext")]

from kanefe import __version__  # noqa: E402

project = "kanefe"
author = "The kanefe developers"
project_copyright = author
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "formulas",
    "snippets",
    "reference",
    "gallery",
    "notebooks",
    "tables",
]
exclude_patterns = ["_ext", "data", "README.md"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

# A name of the library that a page mentions must exist; types in signatures that are not public are left as text.
nitpicky = True
default_role = "py:obj"  # `name` in docstrings
autodoc_typehints_format = "short"
autodoc_member_order = "groupwise"
autodoc_class_signature = "mixed"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
numpydoc_xref_param_type = False
# two classes are called Mesh: a signature that names one is not linked to the other
suppress_warnings = ["ref.python"]

html_theme = "furo"
html_title = f"kanefe {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True, "top_of_page_buttons": []}
pygments_style, pygments_dark_style = "friendly", "monokai"
copybutton_exclude = ".linenos, .gp, .go"
copybutton_selector = "div:not(.output) > div.highlight > pre"
