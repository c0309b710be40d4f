#!/usr/bin/env python3
"""What a library calls lies in a library that it is linked with, so that each program may be linked with the rooms it needs.

A static library is built whatever its objects call: the linker of a program that brings the callee by chance says nothing.

    scripts/check_links.py BUILD_FOLDER [ROOT]
"""
import sys

from check_symbols import build_and_root, demangled, objects_of
from firn_tree import finish


def linked(build):
    """library -> itself and all that it is linked with, from links.txt."""
    next_of = {}
    for line in (build / "links.txt").read_text(encoding="utf-8").splitlines():
        library, *others = line.split()
        next_of[library] = others
    found = {}
    for library in next_of:
        reached, waiting = {library}, [library]
        while waiting:
            for other in next_of.get(waiting.pop(), ()):
                if other not in reached:
                    reached.add(other)
                    waiting.append(other)
        found[library] = reached
    return found


def check(objects, reached):
    """One problem for each pair of a library and a library that it calls without a link.

    A name that two libraries define is the program's to choose: ./firn-demo has tables of fewer labs.
    """
    definers = {}
    for obj in objects.values():
        for name in obj.strong | obj.weak:
            definers.setdefault(name, set()).add(obj.library)
    missing = {}
    for obj in objects.values():
        for name in obj.calls if obj.library in reached else ():
            where = definers.get(name, ())
            if len(where) == 1 and not where & reached[obj.library]:
                missing.setdefault((obj.library, *where), set()).add(name)
    names = demangled({min(calls) for calls in missing.values()})
    return [f"{library}: calls {names[min(calls)]} of {where}, which it is not linked with"
            for (library, where), calls in sorted(missing.items())]


def main():
    build, root = build_and_root(__doc__)
    objects, missing = objects_of(build, root)
    problems = [f"{source}: is not compiled yet: build first" for source in missing]
    return finish("check_links", problems + check(objects, linked(build)))


if __name__ == "__main__":
    sys.exit(main())
