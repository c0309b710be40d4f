#!/usr/bin/env python3
"""The same job in the G-code of four slicers has the same metres; results are kept by row and command."""
import json
import tempfile
import unittest
from pathlib import Path

import gcode_metres

# An outline of 3 m, an infill of 4 m and, where it can be told, a support of 5 m; travel of 100 m.
FIRN = """G90
M83 ; relative extrusion
G1 Z0.25 F6000
;TYPE:boundary
T0
G0 X1000 Y0 F6000
G1 X4000 Y0 E0.1 F3000
;TYPE:fill
G0 X100000 Y0
G1 X100000 Y4000 E0.1
G1 Z0.5 F6000
T1
;TYPE:boundary
G1 X105000 E0.2
"""
PRUSA = """M82 ; absolute
G92 E0
G1 Z.25 F7800
G1 X1000 Y0
;TYPE:External perimeter
G1 X4000 Y0 E2.5
G1 E.5 F2400
G1 X100000 Y0
G1 E2.5 F2400
;TYPE:Internal infill
G1 X100000 Y4000 E3
;TYPE:Support material
G92 E0
G1 Z0.5
G1 X105000 E.25
"""
CURA = PRUSA.replace("External perimeter", "WALL-OUTER").replace("Internal infill", "FILL").replace("Support material", "SUPPORT")
SLIC3R = """G90
G21
M82
G1 Z0.250 F7800
G1 X1000 Y0 F7800
G1 F1800
G1 X4000 Y0 E2.5
G1 X100000 Y0 F7800
G1 X100000 Y4000 E3 F3600
"""


class GcodeMetres(unittest.TestCase):
    def test_the_same_job_has_the_same_metres_in_every_slicers_gcode(self):
        for gcode in (FIRN, PRUSA, CURA):
            layers, metres, moves = gcode_metres.measure(gcode.splitlines())
            self.assertEqual((layers, moves), (2, 3))
            self.assertEqual(metres, [3.0, 4.0, 5.0])
        self.assertEqual(gcode_metres.measure(SLIC3R.splitlines()), (1, [3.0, 4.0, 0.0], 2))

    def test_a_path_of_an_unknown_kind_is_an_error_and_not_left_out(self):
        with self.assertRaises(KeyError):
            gcode_metres.measure(CURA.replace("FILL", "CROWN").splitlines())

    def test_results_measured_anew_replace_their_own_and_leave_the_others(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "new" / "slicing.json"
            gcode_metres.keep(path, ["lucy l.stl 3 firn-0.05 cpu_s=1.50 layers=661", "lucy l.stl 1 prusa-0.05 cpu_s=9"])
            gcode_metres.keep(path, ["lucy l.stl 1 prusa-0.05 cpu_s=10", "igea i.stl 2 firn-0.05 cpu_s=0.4"])
            kept = json.loads(path.read_text(encoding="utf-8"))
            self.assertEqual(kept["lucy"], {"mesh": "l.stl",
                                            "firn-0.05": {"rounds": 3, "cpu_s": 1.5, "layers": 661, "times_firn": 1.0},
                                            "prusa-0.05": {"rounds": 1, "cpu_s": 10, "times_firn": 6.67}})
            self.assertEqual(kept["igea"], {"mesh": "i.stl", "firn-0.05": {"rounds": 2, "cpu_s": 0.4, "times_firn": 1.0}})


if __name__ == "__main__":
    unittest.main()
