"""Browsers' side of a page's WebSocket, as far as measuring needs it: joins, reads what comes, or stops reading."""
import base64
import os
import re
import selectors
import socket
import subprocess
import sys
import threading
import time

URL = re.compile(r"http://127\.0\.0\.1:(\d+)/")


def join(port):
    """A connection on which the page's messages come."""
    connection = socket.create_connection(("127.0.0.1", port), timeout=10)
    key = base64.b64encode(os.urandom(16)).decode()
    connection.sendall((f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                        f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
    answer = connection.recv(12)
    if answer != b"HTTP/1.1 101":
        raise OSError(f"the page answered {answer!r}")
    return connection


def port_of(process, said):
    """The port of the page that a process prints into the file `said`; None when it ended without one."""
    while process.poll() is None:
        if found := URL.search(said.read_text(errors="replace")):
            return int(found[1])
        time.sleep(0.005)
    return None


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
    """Runs a command that has a page, with so many viewers that read and so many that do not: its CPU time in seconds, and the bytes that were read."""
    with open(said, "wb") as out:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT)
    ended, total, connections = threading.Event(), [], []
    try:
        if viewers + stopped:
            port = port_of(process, said)
            if port is None:
                raise OSError(f"{said} names no page")
            connections = [join(port) for _ in range(viewers + stopped)]
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
