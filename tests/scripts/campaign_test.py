"""The campaign: its page is the one of its table, and its short form has cells that make sense."""
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
import campaign_promises
from lab_processes import ROOT


class Campaign(unittest.TestCase):
    def test_page_is_the_table(self):
        """docs/what-happens-when.md is what `scripts/campaign --docs` writes."""
        self.assertEqual((ROOT / "docs/what-happens-when.md").read_text(), campaign_promises.page())

    def test_short_form(self):
        """Fourteen cells, each with a promise, on all arenas and in all phases."""
        cells = campaign_promises.SHORT
        self.assertEqual((len(cells), len(set(cells))), (14, 14))
        for arena, phase, fault in cells:
            self.assertIsInstance(campaign_promises.promise(arena, phase, fault), campaign_promises.Promise)
        self.assertEqual({arena for arena, _, _ in cells}, set(campaign_promises.ARENAS))
        self.assertEqual({phase for _, phase, _ in cells}, set(campaign_promises.PHASES))

    def test_short_links(self):
        """CI runs each fault between gateways once, and both kinds of link."""
        cells = campaign_promises.SHORT_LINKS
        self.assertEqual([fault for _, _, fault in cells], [*campaign_promises.LINK_FAULTS])
        self.assertEqual({kind for kind, _, _ in cells}, set(campaign_promises.LINKS))
        for cell in cells:
            self.assertIsInstance(campaign_promises.promise(*cell), campaign_promises.Promise)


if __name__ == "__main__":
    unittest.main()
