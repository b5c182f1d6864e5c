"""One evaluation of the equations of a scene, and what is computed from states of a run."""
