"""A body from matrices of another program: two masses on a spring spin and stretch it by 19 %."""

import numpy as np

import kanefe as kf

k, m = 100.0, 1.0  # N/m, kg
M = m * np.eye(4)
K = k * np.array([[1, 0, -1, 0], [0, 0, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 0]])
model = kf.model_from_matrices(M, K, [[-0.5, 0, 0], [0.5, 0, 0]], components=("x", "y"))

scene = kf.System()
scene.add_flexible_body("dumbbell", kf.flexible_body(model), joint=kf.Planar(rate=5.0))
result = scene.simulate((0.0, 5.0), rtol=1e-10)

x = result.nodal_positions("dumbbell")
length = np.linalg.norm(x[:, 1] - x[:, 0], axis=1)
print(f"length at rest 1 m, longest {length.max():.6f} m, at the end {length[-1]:.9f} m")

# The exact central-force motion (verification case E04) has r = 1.1515799101 m at t = 5 s.
checked = (length[-1], 1.1515799101, 1e-7)
