"""A lab's messages to Python: however they are cut on their way, each is received whole and once, and none that came early is forgotten."""
import collections
import pathlib
import socket
import sys
import threading
import types
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scenarios/python"))
from arkmesh import answering, session  # noqa: E402  # pylint: disable=wrong-import-position

MESSAGES = [("F", b""), ("P", b"x" * 70_000), ("F", bytes(range(256))), ("S", b"\0")]
SENT = b"".join(answering.HEAD.pack(len(content), ord(kind)) + content for kind, content in MESSAGES)


class Answering(unittest.TestCase):
    def setUp(self):
        self.lab, end = socket.socketpair()
        self.addCleanup(self.lab.close)
        self.of_session = types.SimpleNamespace(lines=collections.deque(), lock=threading.Lock(), busy=None)
        self.line = session.Line(end.detach(), self.of_session)
        self.addCleanup(self.line.socket.close)

    def send(self, *parts):
        threading.Thread(target=lambda: [self.lab.sendall(part) for part in parts], daemon=True).start()

    def test_messages_in_any_pieces(self):
        for piece in (1, 3, 4_096, len(SENT)):
            self.send(*(SENT[at:at + piece] for at in range(0, len(SENT), piece)))
            self.assertEqual([self.line.receive() for _ in MESSAGES], MESSAGES)
            self.assertFalse(self.line.came)

    def test_a_message_that_came_early_is_listed(self):
        """No selector tells of it: it is read already, before the user's code computes an answer to the first."""
        first = answering.HEAD.pack(1, ord("F")) + b"1"
        self.lab.sendall(first + first)
        self.line.receive()
        self.assertEqual(list(self.of_session.lines), [self.line])
        self.assertIs(self.of_session.busy, self.line)
        self.of_session.lines.clear()
        self.line.receive()
        self.assertEqual(list(self.of_session.lines), [])

    def test_an_end_within_a_message(self):
        self.lab.sendall(SENT[:7])
        self.lab.close()
        self.line.receive()
        self.assertRaises(answering.Gone, self.line.receive)


if __name__ == "__main__":
    unittest.main()
