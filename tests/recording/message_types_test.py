#!/usr/bin/python3
"""Whether the tables of our messages agree with the code that lcm-gen makes.

    message_types_test.py LCM_TYPES_FOLDER
"""
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "hal/layout")]
import make_types
import read_log

read_log.TYPES_DIR = pathlib.Path(sys.argv.pop(1))


class Tables(unittest.TestCase):
    def test_generated_code(self):
        """Fingerprints and fields are those of generated code, in their order."""
        types = make_types.tables(ROOT / "lcmtypes")
        self.assertEqual(len(types), len(list((ROOT / "lcmtypes").glob("*.lcm"))))
        for name, each in types.items():
            cls = read_log.types()[bytes.fromhex(each["fingerprint"])]
            self.assertEqual(cls.__name__, name)
            self.assertEqual(cls.__slots__, [field["name"] for field in each["fields"]])


if __name__ == "__main__":
    unittest.main()
