"""Finds the angle at which a sheet of rotating squares is 1.3 times as wide as closed.

By closed form the squares stand cos(a/2) + sin(a/2) edges apart, which is 1.3 at 43.6 degrees.
"""

from scipy.optimize import minimize_scalar

import kirireel

WANTED = 1.3


def width_ratio(angle):
    """How much wider the deployed sheet's tiles stand; the angle in degrees."""
    sheet = kirireel.generate("tessellation", columns=4, rows=4, target_angle=angle)
    across = kirireel.deploy(sheet, no_align=True).position[..., 0]
    return (across[-1].max() - across[-1].min()) / (across[0].max() - across[0].min())


best = minimize_scalar(lambda angle: (width_ratio(angle) - WANTED) ** 2, bounds=(1, 89),
                       method="bounded", options={"xatol": 1e-4})
print(f"{best.x:.3f} degrees: {width_ratio(best.x):.6f} times as wide, after {best.nfev} deployments")
