"""What scripts/figures/exchange_modes computes from runs."""
import importlib.machinery
import importlib.util
import pathlib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
loader = importlib.machinery.SourceFileLoader("exchange_modes", str(ROOT / "scripts/figures/exchange_modes"))
exchange_modes = importlib.util.module_from_spec(importlib.util.spec_from_loader("exchange_modes", loader))
loader.exec_module(exchange_modes)


def lab(owner, sent, age, completed, told=1):
    events = {"told": told, "told_early": 2, "confirmed": 0, "unconfirmed": 3, "resent": 4}
    applied = {"other": {"boundaries": 5, "age_periods_mean": age, "age_periods_most": 9}}
    return {"is_owner": owner, "counts": {"completed": completed}, "exchange": {"sent": {"bytes": sent}, "events": events, "applied": applied}}


def run(mode, network, hash_text, seed=1, period=2.0, completed=7):
    return {"mode": mode, "period_s": period, "network": network, "seed": seed, "seconds": 10, "final_hash": hash_text,
            "labs": {"a": lab(True, 1000, 0.5, completed), "b": lab(False, 200, 1.5, 0)}}


class ExchangeModes(unittest.TestCase):
    def test_row(self):
        """Bytes are per second and by direction; age up is what the owner applies; the result is the owner's count; all are means over seeds."""
        row = exchange_modes.row_of([run("event", "free", "x"), run("event", "free", "y", seed=2, completed=9)], "completed")
        self.assertEqual((row["runs"], row["result"], row["up"], row["down"]), (2, 8, 20, 100))
        self.assertEqual((row["age_up"], row["age_down"]), (0.5, 1.5))
        self.assertEqual((row["events"], row["unconfirmed"], row["resent"]), (6, 6, 8))

    def test_strict_promise(self):
        """Hashes are compared by network, and by mode with the same period; a difference shows."""
        def promise(bad):
            runs = [run("time", "strict", "x"), run("event", "strict", "x"), run("time", "strict, bad", "x"), run("event", "strict, bad", bad)]
            return exchange_modes.strict_promise(exchange_modes.rows_of(runs, "completed"))
        self.assertTrue(promise("x").startswith("In 2 of 2 strict rows"))
        self.assertTrue(promise("y").startswith("In 1 of 2 strict rows"))
        self.assertIn("In 1 of 1 strict rows by events", promise("x"))

    def test_table(self):
        """A row for each setting that was run, none for others; a count that a scenario lacks is no number."""
        rows = exchange_modes.rows_of([run("mixed", "free", "x")], "consensus.ms")
        lines = exchange_modes.table(rows, "consensus.ms").splitlines()
        self.assertEqual(len(lines), 3)
        self.assertEqual(lines[2], "| free | 2 | mixed | 1 | nan | 20 | 100 | 0.50 | 1.50 | 6 | 6 | 8 |")

    def test_seeds(self):
        self.assertEqual((exchange_modes.seeds("3..5"), exchange_modes.seeds("7")), ([3, 4, 5], [7]))


if __name__ == "__main__":
    unittest.main()
