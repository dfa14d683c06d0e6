"""scripts/setup on machines that have everything, and on machines that lack something: apt, sudo and dpkg-query are stand-ins."""
import os
import pathlib
import subprocess
import tempfile
import unittest

SETUP = pathlib.Path(__file__).resolve().parents[2] / "scripts/setup"


class Setup(unittest.TestCase):
    def run_setup(self, profile, installed, apt="exit 0", user=0):
        """What setup says, its code, and the commands it called; `installed` is a shell condition on the package "$1"."""
        with tempfile.TemporaryDirectory() as folder:
            calls = pathlib.Path(folder) / "calls"
            calls.touch()
            for name, body in {"dpkg-query": f'set -- "${{@: -1}}"; if {installed}; then echo -n installed; else exit 1; fi',
                               "apt-get": f'echo "apt-get $@" >> {calls}; {apt}', "sudo": f'echo -n "sudo " >> {calls}; "$@"',
                               "id": f"echo {user}"}.items():
                stub = pathlib.Path(folder) / name
                stub.write_text(f"#!/bin/bash\n{body}\n")
                stub.chmod(0o755)
            done = subprocess.run([SETUP, *profile], capture_output=True, text=True, env={"PATH": f"{folder}:{os.environ['PATH']}"})
            return done.stdout + done.stderr, done.returncode, calls.read_text().splitlines()

    def test_nothing_missing(self):
        """With every package there, neither apt nor root is asked for."""
        for profile in ([], ["build"], ["spy"], ["test"], ["firmware"], ["film"], ["package"]):
            said, code, calls = self.run_setup(profile, "true", user=1000)
            self.assertEqual((code, calls), (0, []), said)

    def test_only_what_is_missing_is_installed(self):
        """One missing package: an update, then exactly that package, without questions; with sudo when not root."""
        said, code, calls = self.run_setup(["build"], '[ "$1" != libode-dev ]')
        self.assertEqual((code, calls), (0, ["apt-get update", "apt-get install -y --no-install-recommends libode-dev"]), said)
        said, code, calls = self.run_setup(["build"], '[ "$1" != libode-dev ]', user=1000)
        self.assertEqual((code, calls[0]), (0, "sudo apt-get update"), said)

    def test_apt_fails(self):
        """A failing apt ends setup with one sentence and apt's own last words."""
        said, code, _ = self.run_setup(["test"], "false", apt="echo E: no such host; exit 100")
        self.assertEqual(code, 1)
        self.assertIn("E: no such host", said)
        self.assertIn("setup: apt-get update failed: is there a network", said)

    def test_apt_in_use(self):
        """setup waits while another program uses apt, and says so once."""
        busy = 'if [ "$(grep -c update "${0%/*}/calls")" -lt 3 ]; then echo "E: Could not get lock /var/lib/apt/lists/lock"; exit 100; fi'
        said, code, calls = self.run_setup(["build"], '[ "$1" != libode-dev ]', apt=busy)
        self.assertEqual((code, said.count("another program uses apt"), calls[-1]), (0, 1, "apt-get install -y --no-install-recommends libode-dev"), said)

    def test_unknown_profile(self):
        """A profile that there is not gives the usage and code 2."""
        said, code, calls = self.run_setup(["everything"], "true")
        self.assertEqual((code, calls, "scripts/setup test" in said), (2, [], True))


if __name__ == "__main__":
    unittest.main()
