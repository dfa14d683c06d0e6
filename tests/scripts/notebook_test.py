"""arkmesh from a script or notebook: runs, batches and loops that the caller's process answers, recordings, and a new
scenario. Each case is a script as users write it, in a process of its own."""
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import textwrap
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARKMESH = ROOT / "build/release/arkmesh"
PYTHON = "/usr/bin/python3"
ENVIRONMENT = {**os.environ, "ARKMESH_PYTHON": PYTHON, "PYTHONPATH": str(ROOT / "scenarios/python")}
BEGIN = f"""
import json, os, pathlib, signal, sys, threading, time
import numpy as np
import arkmesh
FOLDER = {str(ROOT / "experiments/light_up")!r}
A, B, FILE = FOLDER + "/a.toml", FOLDER + "/b.toml", FOLDER + "/light_up.py"
"""
# As in light_up.py; it uses what stands around it, as classes of notebooks do.
LIGHT_UP = """
START = [0]
def near_owner(lab, reach):
    return arkmesh.within(lab.shared_xy, lab.others.shared_xy[lab.others.labs == lab.owner], reach)

class LightUp(arkmesh.Scenario):
    def begin(self, lab):
        self.reach = lab.setting("reach_m", 0.10, low=0.001, high=100, unit="m", about="how near")
        lab.declare("lit", length=1, low=0, high=1_000_000)
        lab.publish("lit", START)

    def frame(self, lab):
        if not lab.is_owner:
            near = np.logical_and(near_owner(lab, self.reach), lab.seen)
            lab.tell(lab.seen, kind=near, shown=(lab.led != 0) == near)
            lab.publish("lit", [near.sum()])

    def period(self, lab):
        lab.count("lit_periods", lab.field(lab.name, "lit").sum())
        lab.row("lit", time_s=lab.now_s, who=lab.name, robots=int(lab.field("b", "lit").sum()))
"""


class Notebook(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def start(self, text, scenario=LIGHT_UP):
        script = self.folder / "study.py"
        script.write_text(BEGIN + scenario + textwrap.dedent(text))
        process = subprocess.Popen([PYTHON, script], cwd=self.folder, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def script(self, text, scenario=LIGHT_UP):
        """Runs it to its end, and returns what its last line prints as JSON."""
        process = self.start(text, scenario)
        said, _ = process.communicate(timeout=600)
        self.assertEqual(process.returncode, 0, said)
        return json.loads(said.splitlines()[-1])

    def test_a_class_here_and_its_file_give_one_hash(self):
        """In this process, as a file in a child's, imported, and by rerun from the folder: the same final hash."""
        hashes = self.script("""
            runs = [arkmesh.run(LightUp, A, B, seconds=20, seed=3, out="run"), arkmesh.run(FILE, A, B, seconds=20, seed=3),
                    arkmesh.run(A, B, seconds=20, seed=3)]
            sys.path.insert(0, FOLDER)
            import light_up
            runs.append(arkmesh.run(light_up.LightUp, A, B, seconds=20, seed=3))
            assert runs[0].counts["lit_periods"] > 0
            print(json.dumps([run.hash for run in runs]))""")
        self.assertEqual(len(hashes), 4)
        self.assertEqual(len(set(hashes)), 1, hashes)
        again = subprocess.run([ARKMESH, "rerun", self.folder / "run"], env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
        self.assertIn("equal: final hash " + hashes[0], again.stdout)

    def test_what_a_run_holds(self):
        """Poses, rows and counts are those that the scenario saw, of each lab, also when the folder is opened later."""
        self.assertTrue(self.script("""
            seen = {"a": [], "b": []}
            class Watch(LightUp):
                def frame(self, lab):
                    super().frame(lab)
                    seen[lab.name].append((lab.now_s, lab.xy, lab.heading, lab.led))
            run = arkmesh.run(Watch, A, B, seconds=5, settings={"b:arena.robots": 7, "scenario.watch.reach_m": 0.2})
            for each in run, arkmesh.open_run(run.folder):
                for name, lab in each.labs.items():
                    assert lab.xy.shape == (51, 7 if name == "b" else 12, 2), lab.xy.shape
                    for time_s, xy, heading, led in seen[name]:
                        t = np.searchsorted(lab.t_s, time_s)
                        assert lab.t_s[t] == time_s
                        assert (lab.xy[t] == xy).all() and (lab.heading[t] == heading).all() and (lab.led[t] == led).all()
                assert (each.xy == each.labs["a"].xy).all() and list(each.labs["b"].ids) == list(range(7))
                rows = each.rows["lit"]
                assert len(rows) == 26 and rows["who"][0] == "a" and rows["time_s"][-1] == 5
                assert each.counts["lit_periods"] == rows["robots"].sum() > 0
            print(json.dumps(run.seed == 1 and run.state == "finished"))"""))

    def test_a_batch_is_its_runs(self):
        """A row for each seed, in the order given, with the hash and the count of the same run alone; beside, two at a time."""
        self.assertTrue(self.script("""
            batch = arkmesh.batch(LightUp, A, B, seeds=[4, 2, 3], jobs=2, seconds=5)
            assert list(batch["seed"]) == [4, 2, 3] and list(batch.runs) == [4, 2, 3]
            for row in batch.table:
                run = arkmesh.run(FILE, A, B, seed=int(row["seed"]), seconds=5)
                assert (row["final_hash"], row["lit_periods"]) == (run.hash, run.counts["lit_periods"])
                assert batch.runs[row["seed"]].hash == run.hash
            assert (arkmesh.open_run(batch.folder).table == batch.table).all()
            print(json.dumps(len(set(batch["final_hash"])) == 3))"""))

    def test_a_lab_as_a_loop(self):
        """A frame for each tenth of a second; what is told is done; leaving the loop ends the run as finished."""
        self.assertTrue(self.script("""
            with arkmesh.lab(A, seconds=10, seed=1, settings={"scenario.loop.kind": 1}) as lab:
                kind, frames = lab.setting("kind", 0), 0
                for frame in lab:
                    assert frame is lab and frame.now_s == frames / 10
                    frames += 1
                    frame.tell(frame.seen, kind=kind)
            assert frames == 101 and not lab.run.led[0].any() and (lab.run.led[-1] == 7).all()
            with arkmesh.lab(A, seconds=1000, every=5) as lab:
                for frame in lab:
                    if lab.now_s > 3:
                        break
            print(json.dumps([lab.run.state, lab.run.result["duration_s"] < 4]))""") == ["finished", True])

    def test_what_goes_wrong(self):
        """Each failure is one sentence with the user's file and line, and result.json is there; what is refused leaves no folder."""
        said = self.script("""
            class Bad(arkmesh.Scenario):
                def frame(self, lab):
                    if lab.name == "b" and lab.now_s > 2:
                        exec(compile(BAD, "mine.py", "exec"))
            def failure(call, *arguments, **more):
                try:
                    call(*arguments, **more)
                except arkmesh.Failed as error:
                    file = error.folder / "result.json"
                    return str(error), json.loads(file.read_text())["ended"] if file.exists() else error.folder.exists()
            out = []
            for BAD in ("\\n1 / 0", "\\nsys.exit(3)", "\\nlab.tell([77])", "\\ntime.sleep(600)"):
                out.append(failure(arkmesh.run, Bad, A, B, seconds=5, settings={"scenario.answer_s": 5 if "sleep" in BAD else 600}))
            def loop():
                with arkmesh.lab(A, seconds=5, settings={"scenario.answer_s": 5}) as lab:
                    for frame in lab:
                        exec(compile("\\ntime.sleep(600)", "mine.py", "exec"))
            out += [failure(loop), failure(arkmesh.run, Bad, A, settings={"run.nix": 1}), failure(arkmesh.run, "nix.py", A)]
            print(json.dumps(out))""")
        for wanted in ("mine.py:2: ZeroDivisionError", "mine.py:2: SystemExit: 3", "mine.py:2: ValueError: this lab has no robot 77", "mine.py:2: no answer in time", "mine.py:2: no answer in time"):
            sentence, ended = said.pop(0)
            self.assertIn(wanted, sentence)
            self.assertIn("the run's folder is runs/", sentence)
            self.assertIn(wanted.replace("in time", "for 5 s"), ended)
        self.assertEqual(said.pop(0), ["--set run.nix=1: unknown key 'run.nix'; remove it or correct its name", False])
        self.assertIn("there is no file", said[0][0])

    def test_where_it_hangs_may_be_said_late(self):
        """The process between lab and notebook passes it on late, and after the notebook has closed its line: the result still
        names the user's line."""
        (self.folder / "sitecustomize.py").write_text(textwrap.dedent("""
            import sys, time
            class Late:
                def write(self, text):
                    time.sleep(0.7 if text.startswith("hangs at ") else 0)
                    return sys.__stderr__.write(text)
                def flush(self):
                    sys.__stderr__.flush()
            sys.stderr = Late()"""))
        ended = self.script("""
            os.environ["PYTHONPATH"] += ":" + os.getcwd()
            class Hangs(arkmesh.Scenario):
                def frame(self, lab):
                    exec(compile("\\ntime.sleep(600)", "mine.py", "exec"))
            def loop():
                with arkmesh.lab(A, seconds=5, settings={"scenario.answer_s": 5}) as lab:
                    for frame in lab:
                        exec(compile("\\ntime.sleep(600)", "mine.py", "exec"))
            out = []
            for call in (loop, lambda: arkmesh.run(Hangs, A, seconds=5, settings={"scenario.answer_s": 5})):
                try:
                    call()
                except arkmesh.Failed as error:
                    out.append(json.loads((error.folder / "result.json").read_text())["ended"])
            print(json.dumps(out))""")
        self.assertEqual(len(ended), 2)
        for each in ended:
            self.assertIn("mine.py:2: no answer for 5 s", each)

    def test_the_callers_own_error_is_the_cause(self):
        """The traceback of the user's exception comes with it; from a loop it is the exception itself, and the run has failed."""
        self.assertTrue(self.script("""
            class Bad(arkmesh.Scenario):
                def frame(self, lab):
                    {}["nothing"]
            try:
                arkmesh.run(Bad, A)
            except arkmesh.Failed as error:
                assert isinstance(error.__cause__, KeyError)
            try:
                with arkmesh.lab(A, out="loop") as lab:
                    for frame in lab:
                        {}["nothing"]
            except KeyError:
                run = arkmesh.open_run("loop")
                print(json.dumps(run.state == "failed" and "study.py" in run.ended and "KeyError" in run.ended))"""))

    def test_ctrl_c_ends_both_at_once(self):
        """In a class that computes, before a file's child, and in a loop: KeyboardInterrupt at once, and a result that says stopped."""
        said = self.script("""
            class Slow(arkmesh.Scenario):
                def frame(self, lab):
                    pathlib.Path("begun").touch()
                    time.sleep(600)
            pathlib.Path("slow.py").write_text("import arkmesh, pathlib, time\\nclass Slow(arkmesh.Scenario):\\n  def frame(self, lab):\\n"
                                               "    pathlib.Path('begun').touch(); time.sleep(600)\\n")
            def loop(*_, **more):
                with arkmesh.lab(A, **more) as lab:
                    for frame in lab:
                        Slow().frame(lab)
            def interrupt():
                while not os.path.exists("begun"):
                    time.sleep(0.02)
                global at
                at = time.monotonic()
                signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
            states = []
            for call, what in (arkmesh.run, Slow), (arkmesh.run, "slow.py"), (loop, None):
                threading.Thread(target=interrupt).start()
                folder = f"out{len(states)}"
                try:
                    call(what, A, out=folder, settings={"scenario.answer_s": 500})
                except KeyboardInterrupt:
                    states.append((arkmesh.open_run(folder).state, time.monotonic() - at < 300))
                os.remove("begun")
            print(json.dumps(states))""")
        self.assertEqual(said, [["stopped", True]] * 3)

    def test_nothing_outlives_the_caller(self):
        """When the caller is killed, its runs end: with a class, and with a file."""
        for what in ("LightUp", "FILE"):
            with self.subTest(what):
                process = self.start(f"arkmesh.run({what}, A, B, seconds=1000000, out='out-{what}')")
                result, hashes = self.folder / f"out-{what}/result.json", self.folder / f"out-{what}/b/hash.csv"
                until = time.monotonic() + 300
                while not (hashes.exists() and hashes.stat().st_size > 1000):
                    self.assertLess(time.monotonic(), until)
                    time.sleep(0.05)
                process.send_signal(signal.SIGKILL)
                while json.loads(result.read_text())["state"] == "running":
                    self.assertLess(time.monotonic(), until)
                    time.sleep(0.05)
                self.assertIn(json.loads(result.read_text())["state"], ("failed", "stopped"))

    def test_cells_of_a_notebook(self):
        """A line of a cell is named `In[7]:2`, and not by the file that IPython makes of it; its class is kept for rerun."""
        self.assertEqual(self.script("""
            import linecache, types
            text = "import numpy as np\\nLOW = 2\\nclass Cell(arkmesh.Scenario):\\n  def begin(self, lab): lab.count('n', np.square(LOW))\\n"
            linecache.cache["cell"] = len(text), None, text.splitlines(True), "cell"
            exec(compile(text, "cell", "exec"))
            assert arkmesh.run(Cell, A, seconds=1, out="cell").counts["n"] == 4
            compiler = types.SimpleNamespace(_filename_map={"/tmp/ipykernel_1/2.py": 7})  # as IPython 8.5 has it
            sys.modules["IPython"] = types.SimpleNamespace(get_ipython=lambda: types.SimpleNamespace(compile=compiler))
            exec(compile("class Cell(arkmesh.Scenario):\\n  def begin(self, lab): 1 / 0", "/tmp/ipykernel_1/2.py", "exec"))
            try:
                arkmesh.run(Cell, A)
            except arkmesh.Failed as error:
                print(json.dumps(str(error).split(";")[0]))"""), "In[7]:2: ZeroDivisionError: division by zero")
        again = subprocess.run([ARKMESH, "rerun", self.folder / "cell"], env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)

    def test_beside_read_log(self):
        """The package and scripts/read_log.py, whose types have the same name, serve one script."""
        self.assertTrue(self.script(f"""
            sys.path.append({str(ROOT / "scripts")!r})
            import read_log
            run = arkmesh.run(FILE, A, B, seconds=2)
            frames = [read_log.decode(data) for _, channel, data in read_log.events(run.folder / "a/log.lcm") if channel == "poses"]
            assert [robot.x_m for robot in frames[-1].robots] == list(run.xy[-1, :, 0])
            print(json.dumps(len(frames) == len(run.xy)))"""))


class NewScenario(unittest.TestCase):
    def test_a_new_scenario_runs_and_its_test_passes(self):
        """As printed: it runs, its test passes, and nothing in it tells of the example."""
        with tempfile.TemporaryDirectory() as folder:
            def arkmesh(*arguments):
                return subprocess.run([ARKMESH, *arguments], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=600)

            made = arkmesh("scenario", "new", "studies/my_swarm", "--python")
            self.assertEqual(made.returncode, 0, made.stderr)
            command = made.stdout.split("run it with arkmesh ")[1].split()
            ran = arkmesh(*command)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertIn("20 s simulated", ran.stdout)
            path = arkmesh("scenario", "path").stdout.strip()
            tested = subprocess.run([PYTHON, "studies/my_swarm/my_swarm_test.py"], cwd=folder, env={**ENVIRONMENT, "PYTHONPATH": path},
                                    capture_output=True, text=True, timeout=600)
            self.assertEqual(tested.returncode, 0, tested.stderr)
            files = sorted((pathlib.Path(folder) / "studies/my_swarm").iterdir())
            self.assertEqual([f.name for f in files if f.is_file()],
                             ["README.md", "a.toml", "b.toml", "my_swarm.c", "my_swarm.py", "my_swarm_test.py"])
            for file in files:
                if file.is_file():
                    self.assertNotRegex(file.read_text(), "(?i)light[_-]?up", file.name)
            for name, wanted in (("studies/my_swarm", "exists; choose another name or folder"), ("My-Swarm", "a scenario's name is"), ("arkmesh", "a scenario's name is")):
                refused = arkmesh("scenario", "new", name)
                self.assertEqual(refused.returncode, 2)
                self.assertIn(wanted, refused.stderr)


if __name__ == "__main__":
    unittest.main()
