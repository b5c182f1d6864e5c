"""The equations of motion of a frozen scene, by the route that was chosen for it, and its consistent start."""
