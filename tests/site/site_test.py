"""The documentation site: it needs no other host, each link leads somewhere, and its search works from a file."""
import functools
import html.parser
import inspect
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "drawing"))
import chromium  # noqa: E402


class Page(html.parser.HTMLParser):
    """What a page refers to: `links` are followed by people, `parts` are fetched with the page. `names` are its anchors."""

    def __init__(self, file):
        super().__init__()
        self.links, self.parts, self.names, self.paragraphs = [], [], set(), []
        self.inside = []
        self.feed(file.read_text())

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.names.update(found[name] for name in ("id", "name") if found.get(name))
        if "href" in found:
            (self.links if tag == "a" else self.parts).append(found["href"])
        self.parts += [found[name] for name in ("src", "srcset", "poster", "data") if name in found]
        self.inside.append(tag)
        if tag == "p":
            self.paragraphs.append("")

    def handle_endtag(self, tag):
        while self.inside and self.inside.pop() != tag:
            pass

    def handle_data(self, data):
        if "p" in self.inside:
            self.paragraphs[-1] += data


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        made = subprocess.run([ROOT / "scripts/site/make", cls.folder], capture_output=True, text=True)
        if made.returncode:
            raise AssertionError(made.stdout + made.stderr)
        cls.pages = {file: Page(file) for file in cls.folder.rglob("*.html")}

    def test_links_and_anchors_lead_somewhere(self):
        """Every link within the site is a file of it, and every anchor is in its page."""
        wrong = []
        for file, page in self.pages.items():
            for link in page.links + page.parts:
                url = urllib.parse.urlsplit(link)
                if url.scheme:
                    continue
                target = (file.parent / urllib.parse.unquote(url.path)).resolve() if url.path else file
                if not target.is_file() or (url.fragment and target in self.pages and
                                            urllib.parse.unquote(url.fragment) not in self.pages[target].names):
                    wrong.append(f"{file.relative_to(self.folder)}: {link}")
        self.assertEqual(wrong, [])
        self.assertGreater(len(self.pages), 40)

    def test_nothing_comes_from_elsewhere(self):
        """No page, style or script fetches a font, script or picture from another host."""
        fetched = [part for page in self.pages.values() for part in page.parts]
        for file in [*self.folder.rglob("*.css"), *self.folder.rglob("*.js"), *self.folder.rglob("*.html"), *self.folder.rglob("*.svg")]:
            if file.parent.name == "search":  # has the words of all pages
                continue
            text = file.read_text()
            fetched += re.findall(r"(?:url\(|@import)\s*[\"']?([^)\"'\s]+)", text)
            fetched += re.findall(r"[\"'](https?:[^\"'\s]+\.(?:m?js|css|woff2?|ttf|png|jpe?g|gif|svg|ico))[\"']", text) if file.suffix == ".js" else []
        self.assertGreater(len(fetched), 100)
        self.assertEqual([each for each in fetched if re.match(r"(?:[a-z]+:)?//", each)], [])

    def test_lists_and_code_are_such(self):
        """No paragraph shows the marks of a list or of code: the site's Markdown wants a blank line before them."""
        for file, page in self.pages.items():
            self.assertNotRegex(file.read_text(), "[\x02\x03]")  # escapes in headings
            for paragraph in page.paragraphs:
                self.assertNotRegex(paragraph, r"(?m)^ *(?:[-*] |\d+\. |```|\| )", file.relative_to(self.folder))

    def test_what_is_made_is_whole(self):
        """The pages that are made have every command, key, type, table of counters and program."""
        commands, messages, counters = (self.pages[self.folder / f"docs/{name}.html"] for name in ("commands", "messages", "counters"))
        table = subprocess.run([ROOT / "build/release/arkmesh", "config", "--keys"], capture_output=True, text=True, check=True).stdout
        keys = (self.folder / "docs/keys.html").read_text()
        for name in re.findall(r"^\| `([^`<]+)`", table, re.M):
            self.assertIn(f"<code>{name}</code>", keys)
        self.assertIn("lab.eyes(sectors=8", (self.folder / "docs/virtual-sensors.html").read_text())
        self.assertIn("cluster partition 60 s", (self.folder / "docs/what-happens-when.html").read_text())
        gallery = (self.folder / "docs/controllers-gallery.html").read_text()
        for program in (ROOT / "tests/programs").glob("*.c"):
            self.assertIn(program.stem, gallery)
        said = subprocess.run([ROOT / "build/release/arkmesh", "--help"], capture_output=True, text=True, check=True).stdout
        for name in re.findall(r"^  (\S+)", said.partition("Subcommands:\n")[2], re.M):
            self.assertIn(f"arkmesh-{name}", commands.names)
        self.assertIn("arkmesh-keys-trust", commands.names)
        self.assertLessEqual({file.stem for file in (ROOT / "lcmtypes").glob("*.lcm")}, messages.names)
        self.assertLessEqual({"hal", "gateway", "lab", "view", "tracker"}, counters.names)

    def test_python_is_whole(self):
        """The page of Python's package has each of its public classes, functions, methods and properties, and each says in a docstring what it is."""
        sys.path.insert(0, str(ROOT / "scenarios/python"))
        import arkmesh  # pylint: disable=import-outside-toplevel
        things = [getattr(arkmesh, name) for name in arkmesh.__all__] + [each for each in vars(arkmesh.pieces).values() if inspect.isclass(each) and issubclass(each, arkmesh.pieces.Piece)]
        public = {}
        for thing in things:
            public[f"{thing.__module__}.{thing.__qualname__}"] = thing.__doc__
            for each in thing.__mro__ if inspect.isclass(thing) else ():
                if each.__module__.startswith("arkmesh"):
                    public.update({f"{each.__module__}.{each.__qualname__}.{name}": value.__doc__ for name, value in vars(each).items()
                                   if not name.startswith("_") and (inspect.isroutine(value) or isinstance(value, (property, functools.cached_property)))})
        public.pop("arkmesh.pieces.Piece")
        self.assertGreater(len(public), 80)
        self.assertEqual([name for name, words in public.items() if not words], [])
        self.assertEqual(public.keys() - self.pages[self.folder / "docs/python.html"].names, set())

    def test_search_finds_from_a_file(self):
        """In Chromium, from file://: what is searched for is found, its link leads to the page, and the console is quiet."""
        with chromium.browser() as driver:
            driver.get((self.folder / "index.html").as_uri())
            box = driver.find_element("css selector", "input.md-search__input")
            driver.find_element("css selector", "label.md-header__button[for=__search]").click() if not box.is_displayed() else box.click()
            box.send_keys("gate.patience_s")
            until = time.monotonic() + 300
            while not (found := driver.find_elements("css selector", "a.md-search-result__link")):
                self.assertLess(time.monotonic(), until, driver.get_log("browser"))
                time.sleep(0.05)
            addresses = [each.get_attribute("href") for each in found]
            self.assertTrue(any("docs/keys.html" in each for each in addresses), addresses)
            driver.get(next(each for each in addresses if "docs/keys.html" in each))
            self.assertEqual(driver.find_element("tag name", "h1").text.rstrip("\u00b6"), "Configuration files")
            self.assertEqual([each for each in driver.get_log("browser") if each["level"] == "SEVERE"], [])


if __name__ == "__main__":
    unittest.main()
