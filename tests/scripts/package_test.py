"""Debian packages, as far as they can be looked at without root: what each component installs, and man pages and
completions of every command."""
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"
PROGRAM = BUILD / "arkmesh"


class Components(unittest.TestCase):
    def test_each_component_has_its_files_and_no_file_is_in_two(self):
        has = {"gateway": ["bin/arkmesh", "bin/arkmesh-gateway", "lib/arkmesh/still_old"],
               "lab": ["bin/arkmesh-lab", "bin/arkmesh-recording", "share/arkmesh/kilolib/kilolib.h",
                       "share/arkmesh/experiments/dhtf/shark.toml", "share/arkmesh/scenarios/dhtf/controller/dhtf.c"],
               "testbed": ["bin/arkmesh-testbed", "bin/arkmesh-guard"],
               "python": ["share/arkmesh/python/arkmesh/__init__.py"],
               "dev": ["include/arkmesh/lab/scenario.hpp", "lib/cmake/arkmesh/arkmeshConfig.cmake"],
               "doc": ["share/doc/arkmesh/CHANGELOG.md"]}
        seen = {}
        for component, files in has.items():
            with tempfile.TemporaryDirectory() as folder:
                command = ["cmake", "--install", BUILD, "--prefix", folder, "--component", component]
                subprocess.run(command, check=True, capture_output=True)
                there = {str(file.relative_to(folder)) for file in pathlib.Path(folder).rglob("*") if file.is_file()}
            self.assertLessEqual(set(files), there, component)
            for file in there:
                self.assertEqual(seen.setdefault(file, component), component, file)


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        subprocess.run([ROOT / "scripts/package/pages.py", PROGRAM, cls.folder], check=True)
        said = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
        cls.commands = re.findall(r"^  (\S+)", said.partition("Subcommands:\n")[2], re.M)

    def complete(self, *words):
        script = f'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _arkmesh; printf "%s\\n" "${{COMPREPLY[@]}}"'
        file = self.folder / "gateway/bash-completion/completions/arkmesh"
        command = ["bash", "-c", script, file, "arkmesh", *words]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stdout.split()

    def test_bash_completes_every_command_and_its_options(self):
        self.assertGreater(len(self.commands), 20)
        self.assertEqual(self.complete(""), self.commands)
        for command in self.commands:
            self.assertIn("--help", self.complete(command, "-"), command)
        self.assertEqual(self.complete("keys", "tr"), ["trust"])
        self.assertEqual(self.complete("ohc", "/dev/ttyUSB0", "up"), ["upload"])
        self.assertIn("--kilolib", self.complete("controller", "build", "--k"))
        self.assertEqual(self.complete("run", ""), [])  # files, which bash itself completes

    def test_zsh_has_every_command(self):
        text = (self.folder / "gateway/zsh/vendor-completions/_arkmesh").read_text()
        for command in self.commands:
            self.assertIn(f"'{command}:", text)
            self.assertIn(f"\n    '{command}') ", text)

    def test_every_command_and_program_has_a_man_page(self):
        pages = {file.stem: file for file in self.folder.rglob("man1/*.1")}
        for command in [*self.commands, "recording", "guard"]:
            self.assertRegex(pages[f"arkmesh-{command}"].read_text(), rf"(?m)^arkmesh-{command} \\- \S", command)
        self.assertIn("arkmesh\\-calibrate\\-motors", pages["arkmesh"].read_text())


if __name__ == "__main__":
    unittest.main()
