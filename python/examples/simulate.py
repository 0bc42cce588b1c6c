"""Dzhanibekov's wing nut: spin about the middle axis turns over and over, energy and momentum
stay."""

import numpy as np

import slewkit

motion = slewkit.simulate(
    {
        "format": 1,
        "simulation": {"integrator": "lie_verlet", "duration_s": 120, "step_s": 0.01, "output_stride": 10},
        "bodies": [
            {
                "inertia_kg_m2": [1, 2, 2.5],
                "attitude": {"axis": [0, 0, 1], "angle_deg": 0},
                "angular_velocity_rad_s": [0.01, 1, 0],
            }
        ],
    }
)
spin = motion.bodies[0].angular_velocity[:, 1]
turns = np.count_nonzero(np.diff(np.sign(spin)))
print(f"turned over {turns} times; angular momentum drifts "
      f"by {np.ptp(motion.angular_momentum, axis=0).max():.1e} N·m·s")
assert turns >= 4 and np.ptp(motion.angular_momentum, axis=0).max() < 1e-12
