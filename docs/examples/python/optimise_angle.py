"""Finds the angle at which a sheet of rotating squares is 1.3 times as wide as closed.

In closed form the squares are cos(a/2) + sin(a/2) edges apart, which is 1.3 at 43.6 degrees.
"""

from scipy.optimize import minimize_scalar

import kirireel

TARGET_RATIO = 1.3


def width_ratio(angle):
    """The ratio of widths of the deployed and the initial sheet; the angle in degrees."""
    sheet = kirireel.generate("tessellation", columns=4, rows=4, target_angle=angle)
    across = kirireel.deploy(sheet, no_align=True).position[..., 0]
    return (across[-1].max() - across[-1].min()) / (across[0].max() - across[0].min())


best = minimize_scalar(lambda angle: (width_ratio(angle) - TARGET_RATIO) ** 2, bounds=(1, 89),
                       method="bounded", options={"xatol": 1e-4})
print(f"{best.x:.3f} degrees: {width_ratio(best.x):.6f} times as wide, after {best.nfev} deployments")
