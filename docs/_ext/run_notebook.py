"""Run a notebook that is kept as text (jupytext's percent format); write it with what its cells showed.

Called as `run_notebook.py TEXT FOLDER`; writes FOLDER/notebook.ipynb. A cell that fails is an error.
"""

import os
import sys
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient

os.environ.pop("MPLBACKEND", None)  # the kernel's own
os.environ["TQDM_DISABLE"] = "1"  # a bar on its way is no outcome
notebook = jupytext.reads(Path(sys.argv[1]).read_text(encoding="utf-8"), fmt="py:percent")
notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
for cell in notebook.cells:
    cell.metadata.pop("execution", None)
nbformat.write(notebook, Path(sys.argv[2]) / "notebook.ipynb")
