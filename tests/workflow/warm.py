"""A Python that is warm: forked from one that has imported the libraries, which takes longer than most jobs.

`commands()` is a folder with the executables `python`, `snakemake` and `freerock`, for what a test starts and
for the jobs of a Snakemake so started. They end as what they stand for and pass on an interrupt, but no other
signal, and see no mounts of their own. Nothing of freerock is imported before the fork; a process takes its
own copy, by PYTHONPATH.
"""

import atexit
import contextlib
import functools
import gc
import importlib
import io
import marshal
import os
import runpy
import select
import shutil
import site
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

CLIENT = """\
#!{python} -IS
import marshal, os, signal, socket, sys

server = socket.socket(socket.AF_UNIX)
server.connect({address!r})
socket.send_fds(server, [b"!"], [0, 1, 2])
with server.makefile("rwb") as file:
    file.write(marshal.dumps([{before} + sys.argv[1:], os.getcwd(), dict(os.environ)]))
    file.flush()
    process = int(file.readline())
    signal.signal(signal.SIGINT, lambda *_: os.kill(process, signal.SIGINT))
    code = int(file.readline() or 1)
if code < 0:
    os.kill(os.getpid(), -code)
sys.exit(code)
"""
COMMANDS = {"python": [], "snakemake": ["-m", "snakemake"], "freerock": ["-m", "freerock.cli"]}
LIBRARIES = (  # of Snakemake and of its jobs, also those that they import late
    *("snakemake.cli", "snakemake.script", "snakemake.report.html_reporter", "snakemake.notebook"),
    *("snakemake.benchmark", "snakemake.storage", "docutils.core", "jsonschema", "nbformat", "smart_open"),
    *("h5py", "jinja2", "lmfit", "netCDF4", "nptdms", "pandas", "pydantic", "xarray", "yaml", "yte"),
    *("matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf", "matplotlib.style"),
    *("scipy.fft", "scipy.integrate", "scipy.ndimage", "scipy.optimize", "scipy.signal", "scipy.stats"),
    "tornado.httpserver",
)


@functools.cache
def commands() -> Path:
    """The folder of the executables; what they ask ends with this process."""
    folder = Path(tempfile.mkdtemp(prefix="warm"))
    for name, before in COMMANDS.items():
        text = CLIENT.format(python=sys.executable, address=str(folder / "socket"), before=before)
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    server = subprocess.Popen(
        [sys.executable, __file__, folder],
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    atexit.register(shutil.rmtree, folder)
    atexit.register(server.communicate)
    assert server.stdout.readline() == b"warm\n"
    return folder


def serve(folder: Path):
    """Fork for each client until stdin is closed and tell it the end; returns in the forked process."""
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(str(folder / "socket"))
    listening.listen()
    print("warm", flush=True)
    running = {}  # process and client, by the descriptor that tells the end of the process
    while sys.stdin not in (ready := select.select([listening, sys.stdin, *running], [], [])[0]):
        for ended in running.keys() & ready:
            process, client = running.pop(ended)
            os.close(ended)
            code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
            with client, contextlib.suppress(OSError):  # it may have been killed
                client.sendall(b"%d\n" % code)
        if listening in ready:
            client = listening.accept()[0]
            if (process := os.fork()) == 0:
                listening.close()
                for other, (_, waiting) in running.items():
                    os.close(other)
                    waiting.close()
                return as_asked(client, folder)
            with contextlib.suppress(OSError):
                client.sendall(b"%d\n" % process)
            running[os.pidfd_open(process)] = process, client
    os._exit(0)


def as_asked(client, folder: Path):
    """Take over the client's standard files, folder, environment and arguments."""
    _, files, *_ = socket.recv_fds(client, 1, 3)
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    with client, client.makefile("rb") as request:
        arguments, here, environment = marshal.load(request)
    os.chdir(here)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv, sys.orig_argv = arguments, [sys.executable, *arguments]
    sys.executable = str(folder / "python")
    sys.path[1:1] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
    sys.modules.pop("sitecustomize", None)  # Debian's Python has one of its own, imported before the fork
    site.execsitecustomize()


def warm_up():
    """Import the libraries; have some load what they load at first use."""
    for name in LIBRARIES:
        importlib.import_module(name)
    sys.modules["snakemake.cli"].get_argument_parser()  # looks for plug-ins among all modules
    import numba
    from matplotlib.figure import Figure

    numba.njit(lambda x: x + 1.0)(1.0)
    figure = Figure()
    figure.text(0, 0, "$x$")
    for suffix in ("png", "pdf"):
        figure.savefig(io.BytesIO(), format=suffix)
    gc.freeze()


def run():
    """What was asked for; returns its exit code."""
    try:
        if sys.argv[0] == "-m":
            del sys.argv[0]
            sys.path[0] = ""
            runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
        else:
            sys.path[0] = str(Path(sys.argv[0]).resolve().parent)
            runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as ended:
        if not isinstance(ended.code or 0, int):
            raise  # Python prints it
        return ended.code or 0
    return 0


def leave(codes: list):
    """End where the exit code is known: to take apart all that was imported takes longer than some jobs."""
    if codes:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(codes[0])


if __name__ == "__main__":
    codes = []
    atexit.register(leave, codes)  # the first, and so called last, when all threads have ended
    warm_up()
    serve(Path(sys.argv[1]))
    codes.append(run())
