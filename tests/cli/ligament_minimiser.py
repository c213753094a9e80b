"""Equilibria of a sheet of tiles on ligaments, by SciPy's minimisers: a second method that shares
no code with Kirireel.

Use: ligament_minimiser.py MODEL RUN WIDTH LENGTH E NU THICKNESS COLUMN
prints by how much the states of a run, in which the last column of so many tiles is moved along x
and the first is held, miss the minimiser's: vertices at the end (metres), then over all states
energies and forces (parts of the largest).

The energy is derived independently, in complex numbers. A tile is (z, phi), the position of its middle (the
mean of its corners) and its turn; a point of it is z + r e^(i phi). The neck at a joint runs from
a point of tile A to a point of tile B, and with l between them, l0 at the start, holds

    k_l (|l| - |l0|)^2 / 2 + k_s g^2 / 2 + k_b (phi_B - phi_A)^2 / 2,
    g = arg(l / l0) - (phi_A + phi_B) / 2.

With f = k_l (|l| - |l0|) l / |l| + i k_s g l / |l|^2 its differential is
    Re(conj(f) dl) - k_s g (dphi_A + dphi_B) / 2 + k_b (phi_B - phi_A) (dphi_B - dphi_A).
"""
import csv
import sys
import time

import numpy as np
from scipy.optimize import minimize
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve


def neck_stiffnesses(width, length, youngs, poisson, thickness):
    """Stretching, shearing (Timoshenko's beam) and bending (docs/fea.md)."""
    area, inertia = width * thickness, thickness * width**3 / 12
    shear_modulus = youngs / (2 * (1 + poisson))
    ends = np.interp(length / width, (1, 2, 5, 10, 20), (1.268, 1.267, 1.265, 1.263, 1.259))
    return (youngs * area / length,
            1 / (length / (12 * youngs * inertia) + 1 / (5 / 6 * shear_modulus * area * length)),
            youngs * inertia / (length + ends * width))


def read_tiles(file):
    """The corners of each tile as complex numbers, and their heights."""
    rows = [np.array(line.split(), float).reshape(-1, 3) for line in open(file) if line.strip()]
    return [row[:, 0] + 1j * row[:, 1] for row in rows]


def read_joints(file):
    return np.array([[int(word) for word in line.split()[:4]] for line in open(file) if line.strip()])


def unit(number):
    return number / abs(number)


def bisector(tile, corner):
    """From a corner into its tile."""
    count = len(tile)
    return unit(unit(tile[(corner + 1) % count] - tile[corner]) +
                unit(tile[(corner - 1) % count] - tile[corner]))


class Sheet:
    def __init__(self, folder, neck, thickness):
        """neck: width, length, Young's modulus, Poisson's ratio."""
        self.tiles = read_tiles(f"{folder}/vertices.txt")
        joints = read_joints(f"{folder}/constraints.txt")
        self.k_l, self.k_s, self.k_b = neck_stiffnesses(*neck, thickness)
        self.middles = np.array([tile.mean() for tile in self.tiles])
        self.a, self.b = joints[:, 0], joints[:, 2]
        across = np.array([unit(bisector(self.tiles[b], j) - bisector(self.tiles[a], i))
                           for a, i, b, j in joints])
        self.l0 = neck[1] * across
        corner = lambda k: np.array([self.tiles[row[k]][row[k + 1]] for row in joints])
        self.r_a = corner(0) - self.l0 / 2 - self.middles[self.a]
        self.r_b = corner(2) + self.l0 / 2 - self.middles[self.b]

    def start(self):
        return np.stack([self.middles.real, self.middles.imag, 0 * self.middles.real])

    def strains(self, q):
        """Turned arms, the ligaments and their strains, at q = (x, y, phi) of all tiles."""
        z, phi = q[0] + 1j * q[1], q[2]
        arm_a, arm_b = self.r_a * np.exp(1j * phi[self.a]), self.r_b * np.exp(1j * phi[self.b])
        l = z[self.b] + arm_b - z[self.a] - arm_a
        stretch = abs(l) - abs(self.l0)
        shear = np.angle(l / self.l0 * np.exp(-0.5j * (phi[self.a] + phi[self.b])))
        return arm_a, arm_b, l, stretch, shear, phi[self.b] - phi[self.a]

    def energy(self, q):
        _, _, _, stretch, shear, bend = self.strains(q)
        return 0.5 * (self.k_l * stretch @ stretch + self.k_s * shear @ shear + self.k_b * bend @ bend)

    def gather(self, at_a, at_b):
        """Sums the contributions of ligaments to their tiles."""
        total = np.empty((3, len(self.tiles)))
        for k in range(3):
            total[k] = (np.bincount(self.a, at_a[k], len(self.tiles)) +
                        np.bincount(self.b, at_b[k], len(self.tiles)))
        return total

    def gradient(self, q):
        arm_a, arm_b, l, stretch, shear, bend = self.strains(q)
        f = self.k_l * stretch * l / abs(l) + 1j * self.k_s * shear * l / abs(l)**2
        half, moment = 0.5 * self.k_s * shear, self.k_b * bend
        turn = lambda arm: (np.conj(f) * 1j * arm).real
        return self.gather((-f.real, -f.imag, -turn(arm_a) - half - moment),
                           (f.real, f.imag, turn(arm_b) - half + moment))

    def hessian(self, q):
        """Blocks of 6 x 6 per ligament, from the differential of the gradient along each coordinate."""
        arm_a, arm_b, l, stretch, shear, bend = self.strains(q)
        size, n = abs(l), l / abs(l)
        f = self.k_l * stretch * n + 1j * self.k_s * shear * n / size
        columns = []
        for tile, part in ((tile, part) for tile in range(2) for part in range(3)):
            turn_a, turn_b = float(tile == 0 and part == 2), float(tile == 1 and part == 2)
            sign, arm = (-1, arm_a) if tile == 0 else (1, arm_b)
            dl = sign * ((1, 1j)[part] * np.ones_like(l) if part < 2 else 1j * arm)
            along, angle = (np.conj(n) * dl).real, (np.conj(n) * dl).imag / size
            d_shear = angle - 0.5 * (turn_a + turn_b)
            df = (self.k_l * (along * n + stretch * 1j * n * angle) +
                  1j * self.k_s * (d_shear / size + shear * (1j * angle / size - along / size**2)) * n)
            half, moment = 0.5 * self.k_s * d_shear, self.k_b * (turn_b - turn_a)
            turn = lambda r, rate: (np.conj(df) * 1j * r - np.conj(f) * r * rate).real
            columns.append(np.stack([-df.real, -df.imag, -turn(arm_a, turn_a) - half - moment,
                                     df.real, df.imag, turn(arm_b, turn_b) - half + moment]))
        blocks = np.stack(columns, axis=1)  # row, column, ligament
        count = len(self.tiles)
        index = np.stack([k * count + tile for tile in (self.a, self.b) for k in range(3)])
        rows, cols = np.broadcast_arrays(index[:, None, :], index[None, :, :])
        return coo_matrix((blocks.ravel(), (rows.ravel(), cols.ravel())), (3 * count, 3 * count)).tocsr()


class Squeeze:
    """The sheet with guided x of some centres, and one fixed y."""

    def __init__(self, sheet, held, moved):
        self.sheet, self.moved = sheet, np.array(moved)
        is_free = np.ones((3, len(sheet.tiles)), bool)
        is_free[0, list(held) + list(moved)] = False
        is_free[1, held[0]] = False
        self.free = np.flatnonzero(is_free)

    def minimise(self, q, displacement, method):
        """The state next to q, with the moved tiles at this displacement."""
        sheet = self.sheet
        q = q.copy()
        q[0, self.moved] = sheet.start()[0, self.moved] + displacement

        def full(free):
            state = q.copy()
            state.flat[self.free] = free
            return state

        found = minimize(
            lambda free: sheet.energy(full(free)), q.flat[self.free],
            jac=lambda free: sheet.gradient(full(free)).ravel()[self.free],
            **self.choices(method, full))
        return full(found.x)

    def choices(self, method, full):
        if method == "L-BFGS-B":
            return {"method": method,
                    "options": {"maxiter": 100000, "maxfun": 100000, "ftol": 0, "gtol": 1e-9, "maxcor": 30}}
        last = {}

        def product(free, along):
            key = free.tobytes()
            if last.get("key") != key:
                matrix = self.sheet.hessian(full(free))[self.free][:, self.free]
                last.update(key=key, matrix=matrix)
            return last["matrix"] @ along

        options = {"xtol": 1e-11} if method == "Newton-CG" else {"gtol": 1e-9}
        return {"method": method, "hessp": product, "options": options}

    def follow(self, displacements, method):
        """The states at these displacements, each from the one before, and the CPU seconds they took."""
        q, states = self.sheet.start(), []
        begin = time.process_time()
        for displacement in displacements:
            q = self.minimise(q, displacement, method)
            states.append(q)
        return states, time.process_time() - begin

    def polished(self, q):
        """One step of Newton's method: minimisers end at the precision of the energy."""
        q = q.copy()
        slope = self.sheet.gradient(q).ravel()[self.free]
        q.flat[self.free] -= spsolve(self.sheet.hessian(q)[self.free][:, self.free], slope)
        return q

    def force(self, q):
        return self.sheet.gradient(q)[0, self.moved].sum()


def vertices(sheet, q):
    z = q[0] + 1j * q[1]
    return [z[i] + (sheet.tiles[i] - sheet.middles[i]) * np.exp(1j * q[2, i]) for i in range(len(z))]


def main():
    model, run = sys.argv[1:3]
    *neck, thickness = map(float, sys.argv[3:8])
    column = int(sys.argv[8])
    sheet = Sheet(model, neck, thickness)
    count = len(sheet.tiles)
    squeeze = Squeeze(sheet, range(column), range(count - column, count))
    rows = list(csv.DictReader(open(f"{run}/load_curve.csv")))
    states, _ = squeeze.follow([float(row["grip_3_x_m"]) for row in rows], "trust-ncg")
    states = [squeeze.polished(q) for q in states]
    ends = read_tiles(f"{run}/final_vertices.txt")
    print(max(abs(a - b).max() for a, b in zip(vertices(sheet, states[-1]), ends)))

    def miss(column, value):
        expected = np.array([value(q) for q in states])
        return abs(expected - [float(row[column]) for row in rows]).max() / abs(expected).max()

    print(miss("energy_J", sheet.energy))
    print(miss("grip_3_x_force_N", squeeze.force))


if __name__ == "__main__":
    main()
