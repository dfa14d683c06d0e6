"""What the courses and task pages of docs/README.md tell people to type works: every block of shell and Python on them is run.

The blocks of a page are run in their order in one shell, in a temporary folder that looks like a clone. A block whose first line is a comment with
a file's name, `# study.py: ...`, is written to that file. One whose first line speaks of a terminal goes on beside the others to the end of the
page. One below `At a:` is typed at the machine a, which has a home folder of its own. A block of text shows lines that the block before it says,
`...` being anything.
"""
import collections
import concurrent.futures
import contextlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import tomllib
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
LANGUAGES = {"sh", "python", "toml", "c", "cpp", "r", "matlab", "ini", "text"}
# The blocks that are not run, by page and first line. At most five.
NOT_RUN = {
    ("install.md", "cd build/package"): "installs packages as root; scripts/package/check does it in a Debian of its own",
    ("install.md", "sudo adduser $USER arkmesh"): "wants systemd, and changes users; scripts/package/check does it there",
    ("batches.md", "arkmesh batch experiments/dhtf/batch.toml            # Fig. 5, 900 runs of 1800 s"):
        "takes half an hour; tests/figures does it",
    ("writing-a-scenario-in-cpp.md", "scripts/build --install ~/arkmesh          # once; then add ~/arkmesh/bin to PATH"):
        "takes minutes; install_test.py installs, and builds such a scenario",
    ("your-first-testbed.md", "arkmesh assign-ids lab.toml            # with hal/platforms/kilobot/firmware/assign_ids.c on the robots"):
        "takes twelve minutes, and wants four programs on the robots; the test program testbed and scripts/measure fit_hidden do it",
}
# What a page takes for granted: made before it is read.
EMULATOR = "arkmesh emulator experiments/emulator/roark.toml --set arena.ode.overhead_loss=0 >emulator.log 2>&1 & wait_for emulator.log\n"
KILOLIB = f"cp -r {ROOT}/tests/data/stand_in_kilolib kilolib\n"
BEFORE = {
    "install.md": "rm -r experiments\n",
    "prove.md": f"cp {ROOT}/tests/programs/differs/same.c my_robot.c\n",
    "writing-a-controller.md": EMULATOR + KILOLIB + "cp experiments/light_up/light_up.c my_robot.c\n",
    "writing-a-scenario.md": "cp experiments/light_up/*.toml experiments/light_up/*.c .\n",
    "your-first-testbed.md": EMULATOR + KILOLIB + "arkmesh controller build experiments/light_up/light_up.c -o prog.hex --kilolib kilolib\n"
        "arkmesh emulator experiments/emulator/roark.toml --chessboard 9 boards\n"
        "for each in boards/*.png; do cp $each board${each##*-}; done\n"
        "curl -so arena.png http://127.0.0.1:8090/camera0.jpg\n"
        "arkmesh testbed record experiments/dhtf/roark_emulated.toml --out day1-ten --seconds 2"
            " --set 'shared.labs=[\"roark\"]' --set shared.owner=roark\n",
    "virtual-sensors.md": "export PYTHONPATH=$(arkmesh scenario path)\n",
}
# What stands on a page for something that this machine does not have.
STAND_INS = {"/dev/ttyUSB0": "tcp://127.0.0.1:8091", "a.example.org": "127.0.0.1", "/usr/share/arkmesh/experiments": f"{ROOT}/experiments",
             "upload prog.hex": "upload prog.hex --rounds 1", "upload my_robot.hex": "upload my_robot.hex --rounds 1"}
TESTBED = {"--board 7x6": "--board 9x6", "--arena 1x1": "--arena 0.5x0.5", "arkmesh track 0": "arkmesh track http://127.0.0.1:8090/camera0",
           'source      = "0" ': 'source = "http://127.0.0.1:8090/camera0" ', "width_m  = 1.0": "width_m = 0.5", "height_m = 1.0": "height_m = 0.5"}
# What a block that goes on beside says when the next one can be typed; else anything.
READY = {"arkmesh up lab.toml": "period [1-9]"}
SHELL = """set -eu
declare -A where
machine() { where[$here]=$PWD; here=$1; export HOME=$top/$1; mkdir -p $HOME; cd "${where[$1]:-$HOME}"; }
wait_for() { for _ in $(seq 600); do ! grep -q "${2:-.}" $1 || return 0; sleep 0.05; done; echo "not said: ${2:-.}"; cat $1; return 1; }
top=$PWD here=home beside=()
"""
Block = collections.namedtuple("Block", "language text line machine")


def task_pages():
    """The pages of the parts that tell people what to type."""
    parts = re.split(r"^## ", (ROOT / "docs/README.md").read_text(), flags=re.M)
    return [page for part in parts if re.match("Learn|Do", part) for page in re.findall(r"^\| \[[^]]+\]\(([^)]+)\)", part, re.M)]


def blocks_of(page):
    text = (DOCS / page).read_text()
    for found in re.finditer(r"^(?:At (\w+):\n+)?```(.*)\n((?:(?!```).*\n)*)```$", text, re.M):
        yield Block(found[2], found[3], text.count("\n", 0, found.start(3)), found[1])


def file_of(block):
    """The name of the file that a block is, or None."""
    found = re.match(r"(?:#|//|/\*) ([\w.]+\.(?:py|toml|c)):", block.text)
    return found and found[1]


def is_beside(block):
    return bool(re.match(r"#.*\bterminal\b", block.text))


def is_run(page, block):
    return block.language in ("sh", "python") and not file_of(block) and (page, block.text.partition("\n")[0]) not in NOT_RUN


def script_of(page):
    """The page as a shell script, which says `@@ LINE` before each block."""
    out = SHELL + BEFORE.get(page, "")
    for block in blocks_of(page):
        text = block.text
        for name, stand_in in {**STAND_INS, **(TESTBED if page == "your-first-testbed.md" else {})}.items():
            text = text.replace(name, stand_in)
        text = re.sub(r"/(?:to|from)-\w+\b", "$top/mail", text) if block.machine else text
        if not (file_of(block) or is_run(page, block)):
            continue
        out += f"machine {block.machine}\n" if block.machine else ""
        out += f"echo '@@ {block.line}'\n"
        if file_of(block):
            out += f"cat >{file_of(block)} <<'END OF FILE'\n{text}END OF FILE\n"
        elif block.language == "python":
            out += f"python3 - <<'END OF FILE'\n{text}END OF FILE\n"
        elif is_beside(block):
            log = f"$top/beside-{block.line}.log"
            out += f"(\n{text}\n) >{log} 2>&1 & beside+=($!)\nwait_for {log} '{READY.get(text.splitlines()[-1], '.')}'\n"
        else:
            out += text
    # What goes on beside has not failed.
    return out + 'echo "@@ 0"\nfor each in "${beside[@]}"; do kill -0 $each 2>/dev/null || wait $each; done\n'


def who_is_in(folder):
    """Processes that work in the folder: (id, name) of each."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if (process / "cwd").readlink().is_relative_to(folder):
                found.append((process.name, (process / "comm").read_text().strip()))
    return found


def until_all_left(folder):
    """The killed take a moment to end, and what they started, which has groups of its own, ends after them."""
    end = time.monotonic() + 60
    while found := who_is_in(folder):
        if time.monotonic() > end:
            raise AssertionError(f"still run: {found}")
        time.sleep(0.02)


def run(page, programs):
    """Runs a page; what is wrong, or nothing."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for part in ("experiments", "scenarios", "hal/platforms/kilobot/firmware", "scripts", "drawing", "tests/figures"):
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("mail", "home", "build"):
            (folder / name).mkdir()
        (folder / "build/release").symlink_to(ROOT / "build/release")
        environment = {**os.environ, "HOME": str(folder / "home"), "PATH": f"{programs}:{ROOT}/build/release:{os.environ['PATH']}"}
        environment.setdefault("XDG_CACHE_HOME", str(folder / "cache"))
        for name in ("XDG_CONFIG_HOME", "PYTHONPATH"):
            environment.pop(name, None)
        shell = subprocess.Popen([ROOT / "scripts/alone", "bash", "-c", script_of(page)], cwd=folder, env=environment, text=True, start_new_session=True,
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        # Whoever still runs beside has a log of its own, and does not hold the pipe.
        try:
            said, _ = shell.communicate(timeout=600)
        except subprocess.TimeoutExpired as late:
            said = (late.stdout or b"").decode() + "\ntakes more than 300 s"
        finally:
            for end in (signal.SIGINT, signal.SIGKILL):
                try:
                    os.killpg(shell.pid, end)
                except ProcessLookupError:
                    break
            shell.wait()
            until_all_left(folder)
        logs = {log.stem.partition("-")[2]: log.read_text() for log in folder.glob("beside-*.log")}
        parts = re.split(r"^@@ (\d+)\n", said, flags=re.M)
        said_by = {**dict(zip(parts[1::2], parts[2::2])), **logs}
        if shell.returncode:
            return f"docs/{page}:{parts[-2] if len(parts) > 2 else 0}: exit code {shell.returncode}: {parts[-1][-2000:]}" + "".join(f"\nbeside, {n}: {t[-1000:]}" for n, t in logs.items())
        before = None
        for block in blocks_of(page):
            if block.language == "text" and before and is_run(page, before):
                for line in filter(None, block.text.splitlines()):
                    wanted = re.escape(line).replace(re.escape("..."), ".*")
                    if not re.search(wanted, said_by[str(before.line)]):
                        return f"docs/{page}:{block.line}: not said: {line}\n{said_by[str(before.line)][-2000:]}"
            before = block
    return None


class Snippets(unittest.TestCase):
    def test_every_block_says_what_it_is(self):
        """Each block of a task page names its language, and TOML can be read."""
        for page in task_pages():
            for block in blocks_of(page):
                self.assertIn(block.language, LANGUAGES, f"docs/{page}:{block.line}")
                if block.language == "toml":
                    tomllib.loads(block.text)

    def test_few_are_not_run(self):
        """At most five blocks of shell and Python are not run, and each of them is there."""
        self.assertLessEqual(len(NOT_RUN), 5)
        there = {(page, block.text.partition("\n")[0]) for page in task_pages() for block in blocks_of(page)}
        self.assertLessEqual(set(NOT_RUN), there)

    def test_every_page_does_what_it_says(self):
        """The blocks of each page succeed, and say what the page shows."""
        pages = [page for page in task_pages() if any(is_run(page, block) for block in blocks_of(page))]
        self.assertGreater(len(pages), 10)
        with tempfile.TemporaryDirectory() as programs:
            # Users' python3 is Debian's.
            pathlib.Path(programs, "python3").symlink_to("/usr/bin/python3")
            # Most of the time goes to waiting for testbeds, which keep real time: their pages begin first.
            keeps_time = [page for page in pages if "emulat" in script_of(page)]
            pages.sort(key=lambda page: page not in keeps_time)
            with concurrent.futures.ThreadPoolExecutor(3) as pool:
                wrong = dict(zip(pages, pool.map(lambda page: run(page, programs), pages)))
            # A machine that is too busy keeps no real time: twice more, with nothing beside it.
            for _ in range(2):
                wrong.update({page: run(page, programs) for page in keeps_time if wrong[page]})
        wrong = [each for each in wrong.values() if each]
        if wrong:
            self.fail("\n\n".join(wrong))

    def test_a_wrong_page_is_noticed(self):
        """A command that fails, one that fails beside, a line that nobody says, and Python that raises are found, with page and line."""
        pages = {"```sh\ntrue\nfalse\n```": "docs/page.md:3: ", "```sh\n# in a terminal\necho x\nexit 3\n```\n": "docs/page.md:0: ",
                 "```sh\necho some words\n```\n\n```text\nsome ... more\n```": "docs/page.md:7: not said: some ... more",
                 "```python\n# a.py: bad\nraise ValueError\n```\n```python\nimport a\n```\n": "ValueError"}
        for text, wanted in pages.items():
            with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(globals(), DOCS=pathlib.Path(folder)):
                pathlib.Path(folder, "page.md").write_text("# Page\n\n" + text)
                self.assertIn(wanted, run("page.md", "/usr/bin") or "nothing")


if __name__ == "__main__":
    unittest.main()
