"""Who connects to a gateway's port without being one: by hand, byte by byte, over plain TCP or with a lab's keys over TLS. See tests/campaign/campaign."""
import contextlib
import os
import socket
import ssl
import struct
import time

HELLO, MESSAGE, PART, LAST_PART, ACK = 1, 2, 5, 6, 7
LENGTHS = (0, 1 << 14, 1 << 31, (1 << 32) - 1)
MAX_MESSAGE = 1 << 20


def crc32c(data, crc=0):
    crc ^= 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x82F63B78 * (crc & 1)
    return crc ^ 0xFFFFFFFF


def frame(kind, payload, length=None):
    """A frame whose checksums are right, also when the length is not the payload's."""
    head = struct.pack(">II", len(payload) if length is None else length, kind)
    head += struct.pack(">I", crc32c(head))
    return head + struct.pack(">I", crc32c(head + payload)) + payload


def name(text):
    return bytes([len(text)]) + text.encode()


def hello(lab, channels=("world",), count=None, magic=b"ARKMESH\n"):
    listed = b"".join(name(channel) + bytes(8) for channel in channels)
    boot_id = int(time.time() * 1e6)
    return frame(HELLO, magic + struct.pack(">H", 3) + name(lab) + name("by hand") + name("dhtf") + struct.pack(">QI", boot_id, MAX_MESSAGE)
                 + struct.pack(">H", len(channels) if count is None else count) + listed)


def before_hello(lab):
    """What nobody takes for a hello, by name."""
    good = hello(lab)
    yield "random bytes", os.urandom(4096)
    yield "a truncated hello", good[:-7]
    yield "a damaged hello", good[:-1] + bytes([good[-1] ^ 1])
    yield "another magic", hello(lab, magic=b"ARKMASH\n")
    yield "more channels than there are", hello(lab, count=256)
    yield "65535 channels", hello(lab, count=65535)
    yield "an empty name", frame(HELLO, good[16:26] + b"\0" + good[26:])
    yield "a web browser", b"GET / HTTP/1.1\r\nHost: shark\r\n\r\n"
    for length in LENGTHS:
        yield f"a hello of length {length}", frame(HELLO, b"", length)


def after_hello(lab):
    """What ends a session that began well, by name."""
    for length in LENGTHS:
        yield f"a message of length {length}", hello(lab) + frame(MESSAGE, b"", length)
    yield "a second hello", 2 * hello(lab)
    yield "an unknown kind", hello(lab) + frame(77, b"")
    yield "an acknowledgement of what was never sent", hello(lab) + frame(ACK, struct.pack(">QQ", 1 << 60, 1 << 60))
    yield "a channel longer than its message", hello(lab) + frame(MESSAGE, bytes(8) + b"\xff" + b"world")
    piece = bytes(8) + name("world") + bytes(1 << 13)
    yield "parts without end", hello(lab) + frame(PART, piece) * 200


def connect(port, keys=None, lab="", source="127.0.0.1"):
    """A connection to a port of this machine; with a folder of keys over TLS, as that lab."""
    plain = socket.create_connection(("127.0.0.1", port), timeout=10, source_address=(source, 0))
    if keys is None:
        return plain
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode, context.minimum_version = False, ssl.CERT_NONE, ssl.TLSVersion.TLSv1_3
    context.load_cert_chain(keys / f"{lab}.crt", keys / f"{lab}.key")
    return context.wrap_socket(plain)


def until_closed(connection, seconds):
    """Reads what comes until the other end closes; all of it, and whether it closed in time."""
    came, end = b"", time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        connection.settimeout(left)
        try:
            data = connection.recv(1 << 16)
        except TimeoutError:
            break
        except OSError:
            return came, True
        if not data:
            return came, True
        came += data
    return came, False


def send(port, data, seconds, **how):
    """Connects, sends, waits for the end: what came, and whether the other end closed in time. A handshake that fails is an end, too."""
    with contextlib.ExitStack() as ending:
        try:
            connection = ending.enter_context(connect(port, **how))
            connection.sendall(data)
        except OSError:
            return b"", True
        return until_closed(connection, seconds)
