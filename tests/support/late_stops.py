"""Prints of tests on a loaded computer: where one is stopped because somebody came too late, it is resumed as a person would."""
import os
import re

MOST = 3
SAFETY_STOP = 3
LATE = re.compile(r"no heartbeat|lease|has been busy|silent|stood still|said nothing|no good reply|no answer|link lost|no height map")


def finished(firn, code, text, run):
    """Returns code and text of the print's end. `firn` runs a command and returns both; `run` is the print's folder, or None."""
    for _ in range(MOST):
        loaded = os.getloadavg()[0] > os.cpu_count()
        if code != SAFETY_STOP or not run or not loaded or not LATE.search(text):
            break
        print(f"somebody came too late, as on a loaded computer; resumed: {text.strip().splitlines()[-1]}")
        code, more = firn("print", "--resume", run)
        text += more
    return code, text
