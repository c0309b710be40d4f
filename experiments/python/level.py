"""Level feedback: raise the lowest cells first, so that the surface comes up level."""
import numpy as np
from firn import End, Print


class Level:
    def __init__(self, setup):
        self.setup = setup

    def decide(self, m):
        s = self.setup
        short = s.mask & (m.height_mm + 0.5 * s.layer_height_mm < s.target_mm)
        if not short.any():
            return End("every cell is within half a layer of its target")
        # One layer above the lowest: no higher cell gets a droplet.
        drops = short & (m.height_mm < m.height_mm[short].min() + s.layer_height_mm)
        if s.objective_mm(s.predict(m.height_mm, drops)) >= s.objective_mm(m.height_mm):
            return End("no droplet brings the surface closer to the target")
        return Print(drops, "raises the lowest cells")
