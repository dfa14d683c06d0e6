"""What the documents promise is there: tests that decisions.md names, and files that documents link to."""
import pathlib
import re
import subprocess
import tempfile
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Documents(unittest.TestCase):
    def test_named_tests_exist(self):
        """Every `folder: name` in docs/decisions.md is a TEST_CASE of that folder."""
        rows = re.search(r"## Claims.*?(?=\n## )", (ROOT / "docs/decisions.md").read_text(), re.S)[0]
        names = re.findall(r"`([a-z_]+): ([^`]+)`", rows.replace("`folder: name of the test case`", ""))
        self.assertGreater(len(names), 10)
        for folder, name in names:
            sources = "".join(file.read_text() for file in (ROOT / "tests" / folder).glob("*.cpp"))
            self.assertIn(f'TEST_CASE("{name}")', sources, f"tests/{folder}")

    def test_links_lead_somewhere(self):
        """Every relative link of README and docs is a file."""
        for document in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
            for target in re.findall(r"\]\(([^)#:]+)\)", document.read_text()):
                self.assertTrue((document.parent / target).exists(), f"{document.name} links to {target}")

    def test_every_key_is_documented(self):
        """Every key of a run's effective configuration stands in docs/formats.md or in the README of the simulated arena."""
        documents = (ROOT / "docs/formats.md").read_text() + (ROOT / "sim_ode/README.md").read_text()
        labs = [ROOT / f"experiments/dhtf/{lab}.toml" for lab in ("shark", "roark")]
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([ROOT / "build/release/arkmesh", "run", *labs, "--out", folder, "--set", "run.duration_s=2"], check=True,
                           capture_output=True, timeout=120)
            config = tomllib.loads((pathlib.Path(folder) / "shark/config.toml").read_text())

        def check(table, path):
            for key, value in table.items():
                if isinstance(value, dict):
                    # Tables by lab are documented with a stand-in for the lab.
                    check(value, path + [key if path[-1:] not in (["projection"],) else "<lab>"])
                else:
                    names = [".".join(path + [key]), "." + key, key, ".".join(path + ["<lab>"])]
                    self.assertTrue(any(f"`{name}`" in documents for name in names), f"{'.'.join(path + [key])} is not documented")

        check(config, [])


if __name__ == "__main__":
    unittest.main()
