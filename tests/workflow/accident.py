"""Accidents at a chosen moment: `sitecustomize` of the processes that Snakemake starts.

ACCIDENT says what happens when the product AT (the end of its path) is written in full under its temporary
name and not yet renamed, or, "kill run early", in the first moment of a job. MARK is a file that tells that
the moment has come.
"""

import os
import resource
import signal
import sys
import time

ACCIDENT, AT, MARK = (os.environ.get(name, "") for name in ("ACCIDENT", "AT", "MARK"))
rename = os.replace


def strike(source):
    with open(MARK, "w") as mark:
        mark.write(str(source))
    if ACCIDENT == "kill job":
        os.kill(os.getpid(), signal.SIGKILL)
    elif ACCIDENT.startswith("kill run"):  # its job outlives it, until the mark is taken away
        os.kill(int(os.environ["RUN"]), signal.SIGKILL)
    end = time.monotonic() + 600
    while os.path.exists(MARK) and time.monotonic() < end:
        time.sleep(0.01)


def replace(source, target):
    if str(target).endswith(AT):
        strike(source)
    rename(source, target)


of_a_job = any(".snakemake/scripts" in word for word in sys.orig_argv)
if not of_a_job:
    os.environ["RUN"] = str(os.getpid())
if ACCIDENT in ("kill job", "kill run", "wait"):
    os.replace = replace
if ACCIDENT == "kill run early" and of_a_job:
    strike("")
if ACCIDENT == "full disk" and of_a_job:
    resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))  # no file grows longer
