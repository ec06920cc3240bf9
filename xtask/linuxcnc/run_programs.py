#!/usr/bin/python3
"""Stands in for the screen: switches the machine on, homes it, and runs what is laid into `programs`.

NAME.ngc is run when NAME.go is there; NAME.done then says "" or what went wrong. A file `end`, or ten
minutes without work, end LinuxCNC.
"""
import os
import pathlib
import sys
import time

import linuxcnc

IDLE_S = 600.0
PROGRAM_S = 300.0
command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()


def wait(is_so, seconds):
    """Waits for a state; what the controller says meanwhile, or that it took too long."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        said = errors.poll()
        if said:
            return said[1]
        if is_so():
            return ""
        time.sleep(0.005)
    return f"no end after {seconds} s (state {status.task_state}, {status.interp_state})"


def run(program):
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete()
    command.program_open(str(program.resolve()))
    command.wait_complete()
    command.auto(linuxcnc.AUTO_RUN, 0)
    command.wait_complete()
    # The interpreter reads ahead: it is idle when the last move has ended.
    said = wait(lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos, PROGRAM_S)
    if said:
        command.abort()
        command.wait_complete()
    return said


def main():
    time.sleep(1)
    command.state(linuxcnc.STATE_ESTOP_RESET)
    command.wait_complete()
    command.state(linuxcnc.STATE_ON)
    command.wait_complete()
    command.home(-1)
    said = wait(lambda: all(status.homed[:3]), 20)
    if said:
        sys.exit(said)
    queue = pathlib.Path("programs")
    idle_since = time.monotonic()
    while time.monotonic() < idle_since + IDLE_S and not pathlib.Path("end").exists():
        for asked in sorted(queue.glob("*.go")):
            asked.unlink()
            said = run(asked.with_suffix(".ngc"))
            answer = asked.with_suffix(".part")
            answer.write_text(said)
            os.rename(answer, asked.with_suffix(".done"))
            idle_since = time.monotonic()
        time.sleep(0.02)


main()
