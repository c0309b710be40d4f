"""Firn in Python: runs as arrays, decisions, prints in simulated time, comparisons, paths and trajectories.

Everything is computed by the program `firn`, in processes of their own: threads of Python go on meanwhile. Heights are in
mm; maps have the shape (ny, nx), row j along x. A command that fails raises FirnError with the program's own message.
python/README.md has the contract of a controller.
"""
from .commands import compare, decide, plan, simulate, slice
from .contract import Action, End, Interval, Landed, Layer, Measurement, Model, Print, Setup, Stop, Surface, Values
from .live import LivePrint, connect
from .program import FirnError, program
from .runs import Run, Table, read_log

__all__ = ["Print", "End", "Stop", "Measurement", "Setup", "Action", "Interval", "Model", "Layer", "Surface", "Landed", "Values", "Run", "Table", "FirnError", "read_log", "decide", "simulate", "compare",
           "slice", "plan", "program", "connect", "LivePrint"]
