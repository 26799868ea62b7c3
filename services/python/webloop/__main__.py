"""The entry: refuses a Python that is too old, then runs the controller.

An old Python has to be able to read this file, or it would say `SyntaxError`
and nothing else: so no annotations and no f-strings here. `main` has the rest.
"""

import os
import sys

OLDEST = (3, 9)

if sys.version_info < OLDEST:
    sys.stderr.write(
        "webloop: this is Python %d.%d and the controller needs %d.%d"
        " or newer; run it with another python3, or name one in WEBLOOP_PYTHON\n"
        % (tuple(sys.version_info[:2]) + OLDEST)
    )
    sys.exit(3)

if not __package__:
    # Started by the folder's path: its parent is where the package is found.
    sys.path[0] = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def start():
    """Runs the controller and ends the program."""
    from webloop.main import main

    sys.exit(main(sys.argv[1:]))


if __name__ == "__main__":
    start()
