"""How springs of different stiffness pull a cap towards its target: a study as one figure."""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import kirireel

cap = kirireel.generate("cap", half_size=1)
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for stiffness in (25, 100, 400):
    run = kirireel.deploy(cap, path="straight", spring_stiffness=stiffness, duration=4)
    axes.semilogy(run.time, run.target_error, label=f"{stiffness} N/m")
axes.set(xlabel="time / s", ylabel="largest distance from the target / m")
axes.legend(title="springs")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "study.png", dpi=150)
