"""Browsers' side of a page's WebSocket, as far as measuring needs it: joins, reads what comes, or stops reading."""
import base64
import os
import selectors
import socket
import subprocess
import sys
import threading
import time


def join(port):
    """A connection on which the page's messages come."""
    connection = socket.create_connection(("127.0.0.1", port), timeout=300)
    key = base64.b64encode(os.urandom(16)).decode()
    connection.sendall((f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                        f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
    answer = connection.recv(12)
    if answer != b"HTTP/1.1 101":
        raise OSError(f"the page answered {answer!r}")
    return connection


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def joined(process, port, number):
    """So many connections to the page of a process, as soon as it listens; none when it ended before."""
    while process.poll() is None:
        try:
            return [join(port) for _ in range(number)]
        except ConnectionRefusedError:
            time.sleep(0.005)
    return []


def read_all(connections, ended):
    """Reads and forgets until `ended` is set; returns the bytes of all together."""
    total, selector = 0, selectors.DefaultSelector()
    for connection in connections:
        connection.setblocking(False)
        selector.register(connection, selectors.EVENT_READ)
    while not ended.is_set():
        for key, _ in selector.select(0.1):
            try:
                part = key.fileobj.recv(1 << 20)
            except OSError:
                part = b""
            total += len(part)
            if not part:
                selector.unregister(key.fileobj)
    return total


def watched(command, said, viewers, stopped=0):
    """Runs a command of labs with a page, with so many viewers that read and so many that do not: its CPU time in seconds, and the bytes that were read."""
    port = free_port()  # a short run does not say where its page is
    if viewers + stopped:
        command = [*command, "--set", f"view.port={port}"]
    with open(said, "wb") as out:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT)
    ended, total, connections = threading.Event(), [], []
    try:
        if viewers + stopped:
            connections = joined(process, port, viewers + stopped)
            if not connections:
                raise OSError(f"it ended before its page listened, see {said}")
        reader = threading.Thread(target=lambda: total.append(read_all(connections[:viewers], ended)))
        reader.start()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
        ended.set()
    reader.join()
    for connection in connections:
        connection.close()
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command)
    return usage.ru_utime + usage.ru_stime, total[0]


if __name__ == "__main__":
    sys.exit("page_viewers: scripts/measure uses this")
