"""The process of a scenario in Python. A lab starts it with one end of a socket pair as descriptor 3, and asks; it answers,
with the user's file, or hands that end over to the process that ARKMESH_ANSWERS names the socket of: running.py."""
import faulthandler
import os
import pathlib
import signal
import socket
import struct
import sys
import traceback

LAB = 3  # the descriptor
SYSTEMS = "/usr/bin/python3"  # has the packages that set-up installs, where another Python comes first in PATH


def hand_over(place):
    """The other process answers; this one stands for it, and asks it where it hangs when the lab asks."""
    with socket.socket(socket.AF_UNIX) as other:
        other.connect(place)
        socket.send_fds(other, [b"L"], [LAB])
        os.close(LAB)
        signal.signal(signal.SIGUSR1, lambda *_: other.send(b"?"))
        while said := other.recv(1 << 16):
            sys.stderr.write(said.decode())
            sys.stderr.flush()


def serve():
    sys.dont_write_bytecode = False  # else the package of a checkout is compiled at each start
    from arkmesh import answering
    sys.dont_write_bytecode = True
    file = pathlib.Path("the scenario")

    def make(facts):
        nonlocal file
        file = pathlib.Path(facts["file"])
        return answering.load(file), lambda: answering.sources_of_file(file)

    line = answering.Line(LAB)
    answers = answering.Answers(line, make)
    try:
        while True:
            answers.take()
    except answering.Gone:
        os._exit(0)
    except BaseException as error:  # also what the user's file raises to exit
        if not isinstance(error, answering.Wrong):
            traceback.print_exc()
        sys.stderr.flush()
        sys.stdout.flush()
        line.fail(answering.sentence_of(error, file.name))
        os._exit(1)


def main():
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the lab ends it
    if place := os.environ.get("ARKMESH_ANSWERS"):
        hand_over(place)
        sys.exit("the process that answered is gone")
    faulthandler.register(signal.SIGUSR1, all_threads=False)  # where it hangs
    try:
        import numpy  # pylint: disable=unused-import
    except ImportError as error:
        if sys.executable != SYSTEMS and "ARKMESH_PYTHON" not in os.environ and os.access(SYSTEMS, os.X_OK):
            os.execv(SYSTEMS, [SYSTEMS, "-B", __file__])
        why = (f"numpy cannot be imported by {sys.executable}: {error}; install it (python3-numpy), or name another "
               "Python in the environment, as ARKMESH_PYTHON").encode()
        os.write(LAB, struct.pack("<IB", len(why), ord("E")) + why)
        sys.exit(1)
    serve()


main()
