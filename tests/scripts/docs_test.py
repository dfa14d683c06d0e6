"""What the documents promise is there: tests that tests/README.md names, and files that documents link to."""
import functools
import json
import pathlib
import re
import shlex
import subprocess
import tempfile
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@functools.cache
def help_of(*words):
    """What `arkmesh WORDS --help` prints."""
    return subprocess.run([ROOT / "build/release/arkmesh", *words, "--help"], check=True, capture_output=True, text=True, timeout=600).stdout


def commands_in(text):
    below = re.search(r"\nSubcommands:\n(.*?)(\n\n|\Z)", text, re.S)
    return re.findall(r"^  (\S+)", below[1], re.M) if below else []


def wrong_in(command):
    """What does not exist of a command line that begins with arkmesh: empty, or a word of it."""
    words = shlex.split(command, comments=True)[1:]
    name, rest = words[0], words[1:]
    if name not in commands_in(help_of()):
        return name
    text = help_of(name)
    known = commands_in(text)
    if known:
        sub = next((word for word in rest if word in known), None)
        if sub is None:
            return f"{name}, which wants one of {known}"
        text += help_of(name, *rest[:rest.index(sub) + 1])
    return next((word for word in rest if re.match("--?[a-z]", word) and
                 not re.search(rf"(^|[\s,]){re.escape(word.split('=')[0])}\b", text)), "")


# Where the fragments of C++ in docs stand: for each document its blocks in order, as (before, behind) the block.
FRAGMENTS = {
    "docs/architecture.md": [("template <class Section> void fields_of(const Section& s, double& duration_s) {", "}")],
    "docs/writing-a-scenario-in-cpp.md": [
        ("}", "namespace {"),
        ("void draw(lab::Lab& lab, const std::vector<std::uint8_t>& trace) {", "}"),
        ("struct Declares : lab::Scenario { using Lab = lab::Lab;", "};"),
        ("void add(std::vector<app::CatalogueEntry>& entries) { using app::scenario_with; std::vector<app::CatalogueEntry> more = {", "}; entries.swap(more); }")],
}
INCLUDES = ("#include \"app/scenarios.hpp\"\n#include \"hal/overlay/drawing.hpp\"\n#include \"scenarios/light_up/light_up.hpp\"\n"
            "using namespace arkmesh;\n")


class Paper(unittest.TestCase):
    def test_its_figures_are_those_of_the_pages(self):
        done = subprocess.run([ROOT / "tests/figures/paper", "--check"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_it_cites_what_its_list_has_and_lists_what_it_cites(self):
        cited = set(re.findall(r"@([a-z_]+\d*)", (ROOT / "paper/paper.md").read_text()))
        listed = re.findall(r"^@\w+\{([^,]+),$", (ROOT / "paper/paper.bib").read_text(), re.M)
        self.assertEqual(sorted(cited), sorted(listed))


class Documents(unittest.TestCase):
    def test_the_page_of_sensors_lists_the_kit(self):
        """Each piece of the kit's table, which the site has, stands on the page of virtual sensors."""
        table = subprocess.run([ROOT / "scripts/document_kit"], check=True, capture_output=True, text=True).stdout
        pieces = re.findall(r"^\| `lab\.(\w+)\(", table, re.M)
        self.assertGreater(len(pieces), 8)
        page = (ROOT / "docs/virtual-sensors.md").read_text()
        self.assertEqual([piece for piece in pieces if f"`{piece}`" not in page], [])

    def test_code_compiles(self):
        """Every block of C++ in README and docs compiles against the sources, each where its kind of fragment stands."""
        source = INCLUDES
        for document in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
            name = str(document.relative_to(ROOT))
            text = document.read_text()
            blocks = list(re.finditer(r"^```(?:cpp|c\+\+)\n(.*?)^```", text, re.S | re.M))
            around = FRAGMENTS.get(name, [])
            self.assertEqual(len(blocks), len(around), f"{name}: say in FRAGMENTS where each block of C++ stands")
            for number, (block, (before, behind)) in enumerate(zip(blocks, around)):
                line = text.count("\n", 0, block.start(1)) + 1
                source += f'namespace block_{re.sub(r"[^a-z]", "_", name)}{number} {{ {before}\n#line {line} "{name}"\n{block[1]}{behind} }}\n'
        include = ["-DARKMESH_PROGRAM_FOLDER=\"\"", f"-I{ROOT}", "-isystem", str(ROOT / "build/release/lcmtypes/cpp"), f"-I{ROOT}/build/release/hal/generated"]
        done = subprocess.run(["g++", "-std=c++20", "-fsyntax-only", *include, "-x", "c++", "-"], input=source, capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_named_tests_exist(self):
        """Every `folder: name` among the claims of tests/README.md is a TEST_CASE of that folder."""
        rows = re.search(r"## Claims.*?(?=\n## )", (ROOT / "tests/README.md").read_text(), re.S)[0]
        names = re.findall(r"`([a-z_]+): ([^`]+)`", rows.replace("`folder: name of the test case`", ""))
        self.assertGreater(len(names), 10)
        for folder, name in names:
            sources = "".join(file.read_text() for file in (ROOT / "tests" / folder).glob("*.cpp"))
            self.assertRegex(sources, rf'TEST_CASE\("{re.escape(name)}"[ )]', f"tests/{folder}")

    def test_links_lead_somewhere(self):
        """Every relative link of README and docs is a file."""
        for document in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
            for target in re.findall(r"\]\(([^)#:]+)\)", document.read_text()):
                self.assertTrue((document.parent / target).exists(), f"{document.name} links to {target}")

    def test_every_page_is_two_clicks_from_the_front_page(self):
        """README, which is also the front page of the site, links to each page of docs, or to a page that does."""
        def linked(page):
            return {(page.parent / target).resolve() for target in re.findall(r"\]\(([^)#:]+\.md)(?:#[^)]*)?\)", page.read_text())}
        first = linked(ROOT / "README.md")
        second = set().union(*(linked(page) for page in first if page.is_relative_to(ROOT / "docs")))
        pages = {page.resolve() for page in (ROOT / "docs").glob("*.md")}
        self.assertGreater(len(pages), 30)
        self.assertEqual(sorted(page.name for page in pages - first - second), [])

    def test_commands_are_there(self):
        """Every command line on the pages of testbeds exists as written, with each of its options."""
        for document in ("docs/learn-testbed.md", "docs/your-first-testbed.md"):
            text = (ROOT / document).read_text()
            blocks = "".join(re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S))
            commands = re.findall(r"^(arkmesh .*)$", blocks, re.M) + re.findall(r"`(arkmesh [^`]+)`", text)
            self.assertGreater(len(commands), 10, document)
            for command in commands:
                self.assertEqual(wrong_in(command), "", f"{document}: {command}")
        self.assertEqual(wrong_in("arkmesh fly away"), "fly")
        self.assertEqual(wrong_in("arkmesh track 0 --serv 8095"), "--serv")
        self.assertIn("ohc, which wants", wrong_in("arkmesh ohc /dev/ttyUSB0 lampe"))

    def test_every_key_is_documented(self):
        """Every key of a run's effective configuration is listed by `config --keys` or in the README of the simulated arena."""
        documents = subprocess.run([ROOT / "build/release/arkmesh", "config", "--keys"], check=True, capture_output=True, text=True, timeout=600).stdout
        documents += (ROOT / "docs/keys.md").read_text() + (ROOT / "sim_ode/README.md").read_text()
        labs = [ROOT / f"experiments/dhtf/{lab}.toml" for lab in ("shark", "roark")]
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([ROOT / "build/release/arkmesh", "run", *labs, "--out", folder, "--set", "run.duration_s=2"], check=True,
                           capture_output=True, timeout=600)
            config = tomllib.loads((pathlib.Path(folder) / "shark/config.toml").read_text())

        def check(table, path):
            for key, value in table.items():
                if isinstance(value, dict):
                    # Tables by lab are documented with a stand-in for the lab.
                    check(value, path + [key if path[-1:] not in (["projection"],) else "<lab>"])
                elif isinstance(value, list) and value and isinstance(value[0], dict):
                    check(value[0], path + [key + "[0]"])
                else:
                    names = [".".join(path + [key]), "." + key, key, ".".join(path + ["<lab>"])]
                    self.assertTrue(any(f"`{name}`" in documents for name in names), f"{'.'.join(path + [key])} is not documented")

        check(config, [])

    def test_every_counter_is_documented(self):
        """Every counter of a simulated lab and of one on an emulated testbed stands in a README's section on counters."""
        documented = set()
        for readme in subprocess.run(["git", "ls-files", "*/README.md"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split():
            section = re.search(r"^## Counters\n(.*?)(?=^## |\Z)", (ROOT / readme).read_text(), re.M | re.S)
            for cell in re.findall(r"^\| ([^|]*) \|", section[1] if section else "", re.M):
                first = ""
                for name in re.findall(r"`([^`]+)`", cell):  # `poses.lost`, `.late` stands for poses.lost and poses.late
                    first = first if name.startswith(".") else name
                    documented.add(first.rpartition(".")[0] + name if name.startswith(".") else name)
        with tempfile.TemporaryDirectory() as folder:
            alone = ["--set", 'shared.labs=["roark"]', "--set", "shared.owner=roark"]
            for name, labs, options in (("simulated", ("light_up/a", "light_up/b"), []), ("emulated", ("dhtf/roark_emulated",), alone)):
                files = [ROOT / f"experiments/{lab}.toml" for lab in labs]
                subprocess.run([ROOT / "build/release/arkmesh", "run", *files, "--out", f"{folder}/{name}", "--seconds", "4", *options],
                               check=True, capture_output=True, timeout=600)
            counted = {name for file in pathlib.Path(folder).glob("*/*/result.json") for name in json.loads(file.read_text())["counters"]}
        self.assertGreater(len(counted), 30)
        counted = {re.sub(r"\.[ab]$", ".<lab>", name) for name in counted}  # what is counted by lab
        missing = [name for name in sorted(counted) if name.removeprefix("arena.") not in documented and name not in documented]
        self.assertEqual(missing, [])


if __name__ == "__main__":
    unittest.main()
