"""Counts comparisons for the scripts beside it, and prints those that do not hold."""

import sys

passed = failed = 0


def check(what, holds, found=""):
    """Counts one comparison, and prints it if it does not hold."""
    global passed, failed
    if holds:
        passed += 1
    else:
        failed += 1
        print(f"FAILED: {what}{f': {found}' if found != '' else ''}")


def finish():
    """Prints the counts and ends the script, with 0 only without failures."""
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
