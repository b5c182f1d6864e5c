"""The equations of motion of a frozen scene, by the route chosen for it, and its consistent start."""
