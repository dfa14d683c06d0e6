"""The campaign: its page has its whole table, and its short form has cells that make sense."""
import subprocess
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
import campaign_network
import campaign_promises
from lab_processes import ROOT


class Campaign(unittest.TestCase):
    def test_page_has_the_table(self):
        """What `tests/campaign/campaign --docs` prints has a row for each fault, of labs and between gateways."""
        printed = subprocess.run([ROOT / "tests/campaign/campaign", "--docs"], check=True, capture_output=True, text=True).stdout
        for fault in [*campaign_promises.FAULTS, *campaign_promises.LINK_FAULTS]:
            self.assertIn(f"\n| {fault} | ", printed)

    def test_short_form(self):
        """Sixteen cells, each with a promise, on all arenas and in all phases."""
        cells = campaign_promises.SHORT
        self.assertEqual((len(cells), len(set(cells))), (16, 16))
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

    def test_lost_messages_of_a_server(self):
        """Each nth message is dropped and everything else passes, however the bytes come; a message may hold line ends."""
        sent = b"INFO {}\r\n" + b"".join(b"MSG a.b 1 %d\r\n%s\r\n" % (len(text), text) for text in (b"one", b"t\r\nwo", b"", b"MSG x 1 3")) + b"PONG\r\n"
        for size in (1, 7, len(sent)):
            every, third = campaign_network.NatsMessages(), campaign_network.NatsMessages()
            parts = [sent[at:at + size] for at in range(0, len(sent), size)]
            self.assertEqual(b"".join(every.without_each(0, part) for part in parts), sent)
            self.assertEqual(b"".join(third.without_each(3, part) for part in parts), sent.replace(b"MSG a.b 1 0\r\n\r\n", b""))


if __name__ == "__main__":
    unittest.main()
