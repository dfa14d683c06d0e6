"""scripts/alone: alone it is."""
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Alone(unittest.TestCase):
    def test_alone(self):
        """A command gets its arguments, gives its exit code, has loopback and a multicast route, and nobody else's ports."""
        alone = ROOT / "scripts/alone"
        done = subprocess.run([alone, "sh", "-c", 'ip route get 239.255.76.67; ip -o addr; echo "$1"; exit 5', "-", "a b"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("dev lo", done.stdout)
        self.assertIn("a b\n", done.stdout)
        self.assertNotIn("eth0", done.stdout)

    def test_no_namespace(self):
        """Where no namespace can be made the command does not run, and the exit code is 77, which ctest counts as not run."""
        with tempfile.TemporaryDirectory() as folder:
            stub = pathlib.Path(folder) / "unshare"
            stub.write_text("#!/bin/sh\necho unshare: Operation not permitted >&2\nexit 1\n")
            stub.chmod(0o755)
            done = subprocess.run([ROOT / "scripts/alone", "echo", "ran"], capture_output=True, text=True, env={"PATH": f"{folder}:/usr/sbin:/usr/bin:/sbin:/bin"})
            self.assertEqual((done.returncode, done.stdout), (77, ""))
            self.assertIn("not run: echo", done.stderr)


if __name__ == "__main__":
    unittest.main()
