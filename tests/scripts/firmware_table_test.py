"""tests/firmware/firmware_table: what it says to an emulator of the robot, and what it makes of the answers. The emulator and the kilolib are stand-ins."""
import importlib.machinery
import importlib.util
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tests/firmware/firmware_table"
KILOLIB = ROOT / "tests/data/stand_in_kilolib"

loader = importlib.machinery.SourceFileLoader("firmware_table", str(SCRIPT))
firmware_table = importlib.util.module_from_spec(importlib.util.spec_from_loader("firmware_table", loader))
loader.exec_module(firmware_table)

# Answers as a robot that always stands, and keeps what was said to it.
EMULATOR = """#!/usr/bin/env python3
import sys
with open({log!r}, "a") as log:
    for line in sys.stdin:
        log.write(line)
        if line.startswith("look"):
            print("0 0 0 0 0", flush=True)
"""


def heard(pulses):
    """The bytes that a robot receives: bit k of one comes about k + 1 bits after its start."""
    frames, start, value = [], None, 0
    for at in pulses:
        if start is None:
            start, value = at, 0
            continue
        bit = (at - start - firmware_table.BIT // 2) // firmware_table.BIT
        if bit < 8:
            value |= 1 << bit
        else:
            frames.append(value)
            start = None
    return bytes(frames)


def run(*arguments, path=None):
    environment = {"PATH": path} if path else None
    return subprocess.run(["/usr/bin/python3", SCRIPT, *map(str, arguments)], capture_output=True, text=True, timeout=600, env=environment)


def run_standing(*arguments):
    """The script with a robot that always stands: how it ended, and the emulator's lines with light."""
    with tempfile.TemporaryDirectory() as folder:
        emulator, log = pathlib.Path(folder) / "emulator", pathlib.Path(folder) / "log"
        emulator.write_text(EMULATOR.format(log=str(log)))
        emulator.chmod(0o755)
        done = run("--kilolib", KILOLIB, "--emulator", emulator, *arguments)
        return done, [heard(map(int, line.split()[1:]))[:11] for line in log.read_text().splitlines() if line.startswith("pulses")]


class FirmwareTable(unittest.TestCase):
    def test_messages_are_those_of_the_air(self):
        """A message's light is received as its bytes, with the checksums of known messages."""
        self.assertEqual(heard(firmware_table.pulses(0x88)).hex(), "00" + "00" * 9 + "88" + "c794")
        self.assertEqual(heard(firmware_table.pulses(0, [0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88])).hex(), "00" "001122334455667788" "00" "b130")

    def test_every_row_can_be_said(self):
        """Each step of the table has its messages; calibration values stand where the robot reads them."""
        for steps, *_ in firmware_table.rows(firmware_table.TABLE.read_text()):
            for step in steps:
                name, _, values = step.partition(":")
                if name != "wait":
                    self.assertTrue(firmware_table.messages(name.rstrip("*"), [int(v) for v in values.split(",") if v], lambda at: [7] * 128), step)
        self.assertEqual(firmware_table.messages("left", [80], None), [(0x8A, [2, 0, 0, 80])])
        self.assertEqual(firmware_table.messages("right", [81], None), [(0x8A, [3, 0, 0, 0, 81])])
        self.assertEqual(firmware_table.messages("straight", [63, 64], None), [(0x8A, [4, 0, 0, 0, 0, 63, 64])])
        page = firmware_table.messages("page", [2], lambda at: [at // 128] * 128)
        self.assertEqual((len(page), page[0]), (22, (0x81, [2, 0] + [2] * 6)))

    @unittest.skipUnless(shutil.which("avr-gcc"), "avr-gcc is not installed: nothing is built for the robot")
    def test_rows_that_differ_are_named(self):
        """A robot that always stands does as the rows say in which it stands, and differs in the others."""
        done, said = run_standing("save")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("run save: 0 0, off, stands instead of 70 0, red, runs\n", done.stdout)
        self.assertRegex(done.stdout, r"\n\d+ rows, 3 differ\n$")
        self.assertIn(bytes.fromhex("00020000500000000000" + "8a"), said)

    def test_layouts_are_said_as_the_table_has_them(self):
        """Each row's bytes, start parameters first; a robot without light differs where its LED is to be lit."""
        table = list(firmware_table.layout_rows(firmware_table.LAYOUTS.read_text()))
        self.assertIn(("7+1+16", ROOT / "tests/programs/layout_7_1_16.c", [(10, bytes.fromhex("008000000001000002")), (0, bytes.fromhex("0b8001fe0000fe0000"))], "green"), table)
        if not shutil.which("avr-gcc"):
            self.skipTest("avr-gcc is not installed: nothing is built for the robot")
        done, said = run_standing("--layouts")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("8+16, layout_8_16.c, told 05513fff0000ff0000: off instead of green\n", done.stdout)
        self.assertRegex(done.stdout, r"\n9 rows, 8 differ\n$")
        self.assertIn(bytes.fromhex("00" "0b8001fe0000fe0000" "00"), said)

    def test_what_is_missing_is_one_sentence(self):
        """No compiler, no kilolib, no emulator: one sentence, code 2."""
        with tempfile.TemporaryDirectory() as nothing:
            for arguments, path, sentence in (
                (["--kilolib", KILOLIB], nothing, "avr-gcc, the robot's compiler, is missing: scripts/setup firmware"),
                (["--kilolib", nothing], None, f"{nothing} is no kilolib: it has no kilolib.c"),
            ):
                if path is None and not shutil.which("avr-gcc"):
                    continue
                done = run(*arguments, path=path)
                self.assertEqual((done.returncode, done.stderr), (2, f"firmware_table: {sentence}\n"))


if __name__ == "__main__":
    unittest.main()
