"""experiments/federation: its commands run as they are written, and its server keeps each lab to what it may say."""
import json
import os
import pathlib
import re
import shutil
import socket
import ssl
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/arkmesh"
FOLDER = ROOT / "experiments/federation"
SECONDS = 40


class Federation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.root = pathlib.Path(cls.temporary.name)
        for folder in ("experiments", "scenarios"):
            shutil.copytree(ROOT / folder, cls.root / folder, ignore=shutil.ignore_patterns("keys"))
        cls.keys, cls.plain, cls.tls = re.findall(r"```\n(.*?)```", (FOLDER / "README.md").read_text(), re.S)
        cls.shell(cls.keys)

    @classmethod
    def shell(cls, text):
        """Runs commands of the page as they are; servers that they leave behind end with them."""
        environment = os.environ | {"PATH": f"{PROGRAM.parent}:{os.environ['PATH']}:/usr/sbin"}
        with open(cls.root / "said.txt", "w+") as said:
            done = subprocess.run(["bash", "-ec", "trap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT\n" + text], cwd=cls.root, env=environment,
                                  stdin=subprocess.DEVNULL, stdout=said, stderr=said, timeout=600)
            said.seek(0)
            words = said.read()
        if done.returncode != 0:
            raise AssertionError(f"the page's commands failed:\n{words}")
        return words

    def hashes(self, text):
        """Final hashes of both labs when the commands run, with a short run."""
        words = self.shell(re.sub(r"(?m)^(arkmesh up .*)$", rf"\1 --set run.duration_s={SECONDS}", text))
        return re.findall(r"final hash (\w+)", words)

    def test_commands_of_the_page(self):
        """At either server both labs end with the hash of one process."""
        out = self.root / "local"
        subprocess.run([PROGRAM, "run", "experiments/dhtf/shark.toml", "experiments/dhtf/roark.toml", "--out", out, "--set", f"run.duration_s={SECONDS}"], cwd=self.root,
                       check=True, capture_output=True)
        expected = json.loads((out / "result.json").read_text())["final_hash"]
        self.assertEqual(self.hashes(self.plain), [expected] * 2)
        self.assertEqual(self.hashes(self.tls), [expected] * 2)

    def test_servers_permissions(self):
        """A lab says nothing in another's name, a watcher nothing at all, and somebody without a password gets no answer."""
        self.shell(self.tls.partition("nats-server")[0])
        server = subprocess.Popen(["/usr/sbin/nats-server", "-c", "experiments/federation/server_tls.conf"], cwd=self.root, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        shark, watcher, stranger = ("shark", "shark-says"), ("watcher", "watcher-hears"), ("roark", "a guess")
        self.assertEqual(self.answer(shark, "PUB arkmesh.dhtf.shark.ALL 2\r\nhi"), "PONG")
        self.assertIn("Permissions Violation", self.answer(shark, "PUB arkmesh.dhtf.roark.ALL 2\r\nhi"))
        self.assertIn("Permissions Violation", self.answer(shark, "SUB arkmesh.dhtf.*.roark 1"))
        self.assertEqual(self.answer(watcher, "SUB arkmesh.dhtf.*.WATCH 1"), "PONG")
        self.assertIn("Permissions Violation", self.answer(watcher, "SUB arkmesh.dhtf.*.shark 1"))
        self.assertIn("Permissions Violation", self.answer(watcher, "PUB arkmesh.dhtf.watcher.ALL 2\r\nhi"))
        self.assertIn("Authorization Violation", self.answer(stranger, "SUB arkmesh.dhtf.*.ALL 1"))

    def answer(self, who, command):
        """What the server answers to one command: PONG when nothing is wrong with it."""
        end = time.monotonic() + 300
        while True:
            try:
                plain = socket.create_connection(("localhost", 4223), timeout=300)
                break
            except ConnectionError:
                self.assertLess(time.monotonic(), end, "the server does not listen")
                time.sleep(0.05)
        with plain:
            information = b""
            while not information.endswith(b"\r\n"):
                information += plain.recv(1)
            trusted = ssl.create_default_context(cafile=self.root / "experiments/federation/keys/server/server.crt")
            with trusted.wrap_socket(plain, server_hostname="localhost") as secure:
                login = json.dumps({"verbose": False, "pedantic": False, "user": who[0], "pass": who[1], "lang": "test", "version": "1"})
                secure.sendall(f"CONNECT {login}\r\n{command}\r\nPING\r\n".encode())
                with secure.makefile("r", newline="\r\n") as lines:
                    return next(line.strip() for line in lines if not line.startswith(("INFO", "PING", "MSG")))


if __name__ == "__main__":
    unittest.main()
