"""Level feedback whose droplets at the rim land inwards of the middle of their cells, away from what lies beside the part.

Needs places beside the middle: actuation.offsets = "x" or "grid".
"""
import numpy as np
from firn import End, Print


class Inset:
    def __init__(self, setup, inset=0.3):
        """inset: shares of the pitch."""
        self.setup = setup
        part = np.pad(setup.mask.astype(int), 1)
        left, right, below, above = part[1:-1, :-2], part[1:-1, 2:], part[:-2, 1:-1], part[2:, 1:-1]
        # Away from a side beside the part; of a wall one cell thick both are, and neither counts.
        self.places = setup.nearest_place(inset * (right - left), inset * (above - below))

    def decide(self, m):
        s = self.setup
        short = s.mask & (m.height_mm + 0.5 * s.layer_height_mm < s.target_mm)
        if not short.any():
            return End("every cell is within half a layer of its target")
        drops = short & (m.height_mm < m.height_mm[short].min() + s.layer_height_mm)
        if s.objective_mm(s.predict(m.height_mm, drops, self.places)) >= s.objective_mm(m.height_mm):
            return End("no droplet brings the surface closer to the target")
        return Print(drops, "raises the lowest cells, the rim's droplets inwards", self.places)
