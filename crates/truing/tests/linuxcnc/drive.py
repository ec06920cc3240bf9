#!/usr/bin/python3
"""Stands in for the screen: switches the machine on, homes it, runs probe.ngc and ends LinuxCNC."""
import os
import sys
import time

import linuxcnc

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()


def wait(is_so, seconds):
    end = time.time() + seconds
    while time.time() < end:
        status.poll()
        if is_so():
            return
        time.sleep(0.01)
    sys.exit(f"timed out in state {status.task_state}, {status.interp_state}: {errors.poll()}")


time.sleep(1)
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete()
command.state(linuxcnc.STATE_ON)
command.wait_complete()
command.home(-1)
wait(lambda: all(status.homed[:3]), 20)
command.mode(linuxcnc.MODE_AUTO)
command.wait_complete()
command.program_open(os.path.abspath("probe.ngc"))
command.auto(linuxcnc.AUTO_RUN, 0)
time.sleep(0.5)
wait(lambda: status.interp_state == linuxcnc.INTERP_IDLE, 240)
said = errors.poll()
if said:
    sys.exit(str(said))
