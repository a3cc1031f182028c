"""Holds all threads of a process but those of one name, as a call that hangs in the kernel would, until it is gone.

    hang.py PROCESS NAME
"""

import ctypes
import os
import sys

SEIZE, INTERRUPT = 0x4206, 0x4207
ptrace = ctypes.CDLL(None, use_errno=True).ptrace
ptrace.argtypes = [ctypes.c_long] * 4
tasks = f"/proc/{sys.argv[1]}/task"
for task in os.listdir(tasks):
    with open(f"{tasks}/{task}/comm") as name:
        if name.read().strip() == sys.argv[2]:
            continue
    for request in (SEIZE, INTERRUPT):
        if ptrace(request, int(task), 0, 0) != 0:
            sys.exit(f"{task}: {os.strerror(ctypes.get_errno())}")
# Who traces lets go when it ends, and a thread that died is gone only when its tracer knows.
WALL = 0x40000000
while True:
    try:
        os.waitpid(-1, WALL)
    except ChildProcessError:
        break
