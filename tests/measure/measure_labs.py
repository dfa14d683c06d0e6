"""What it costs to have many labs in one process."""
import shutil

from lab_processes import ROOT, Failed

ROUNDS = 3
LAB = """lab.name = "{name}"
run = {{scenario = "{scenario}", duration_s = {seconds}}}
gate.period_s = 1
shared.labs = {labs}
arena = {{robots = {robots}, width_m = {side_m}, height_m = {side_m}, ode = {{controller = "{program}", solver = "{solver}"}}}}
"""


def lab_files(folder, names, seconds, scenario="light_up", robots=12, side_m=0.5, solver="ode"):
    """Of labs that run in one process."""
    files = [folder / f"{scenario.removesuffix('.py')}_{name}.toml" for name in names]
    for name, file in zip(names, files):
        file.write_text(LAB.format(name=name, seconds=seconds, labs=str(names).replace("'", '"'), scenario=scenario, robots=robots, side_m=side_m, solver=solver,
                                   program=ROOT / "experiments/light_up/light_up.c"))
    return files


def run_labs(bench, number, solver="ode"):
    """light_up of so many labs of 12 robots, a period of 1 s, in one process: (simulated seconds in one of the wall, CPU seconds, peak MB)."""
    folder, seconds, names = bench.folder(), 4800 // number, [f"l{i:02}" for i in range(number)]
    run = bench.run(*lab_files(folder, names, seconds, solver=solver), "--set", "view.use=false")
    return run["wall"]["speed"], run["cpu_s"] / seconds, run["peak_mb"]


def fastest(bench, numbers, solver="ode"):
    """{number: (speed, CPU seconds of a simulated one, peak MB)}: the fastest of some runs of each, by turns."""
    all_ = {number: [] for number in numbers}
    for _ in range(ROUNDS):
        for number in numbers:
            all_[number].append(run_labs(bench, number, solver))
    return {number: max(rows) for number, rows in all_.items()}


def labs_sixteen(bench):
    """16 labs of 12 robots in one process: simulated seconds in one of the wall, with each solver."""
    ode, fast = (fastest(bench, [16], solver)[16][0] for solver in ("ode", "fast"))
    return ode >= 400, f"{ode:.0f}, with the fast solver {fast:.0f}", "400"


def labs_growth(bench):
    """What a lab of 16 costs beside a lab of 4, in CPU time and in memory."""
    of = fastest(bench, [4, 8, 16])
    for number, (speed, cpu_s, peak_mb) in of.items():
        print(f"  {number} labs: {speed:.0f} simulated s per wall s, {1e6 * cpu_s / number:.0f} us of CPU per lab and simulated s, {peak_mb / number:.1f} MB per lab")
    cpu, memory = (of[16][i] / 16 / (of[4][i] / 4) for i in (1, 2))
    return max(cpu, memory) <= 1.5, f"CPU {cpu:.2f}, memory {memory:.2f} of a lab of 4", "1.5"


def labs_addition(bench):
    """Processor time of the 48+12 pair of DHTF beside that of its two arenas alone, which hear the same words, by turns: what gate, bus, recorder and scenario add."""
    whole, bare = [], []
    for _ in range(ROUNDS):
        run = bench.run(*bench.pair_files, "--seed", 1, "--seconds", bench.seconds, "--set", "view.use=false", keep=True)
        folder = run["folder"]
        whole.append(run["cpu_s"])
        told = bench.say(bench.built("bare_arenas"), folder, 1, *bench.pair_files).split()
        if told[4] != told[6]:
            raise Failed(f"the arenas alone went another way: {told[6]} of {told[4]} frames are the same")
        bare.append(float(told[2]))
        shutil.rmtree(folder)
    added = min(whole) / min(bare) - 1
    return added <= 0.37, f"{added:.2f} of the arenas' time", "0.37, 0.6 times what it was"


KIT = """import arkmesh
class Five(arkmesh.Scenario):
    def begin(self, lab):
        self.trail = lab.trail("trail", width=5, height=5, cell=0.02, half_life=30, diffusion=1e-5, zones=(4, 3.14, 0.05, 0.2))
        self.walls, self.others = lab.eyes(sectors=8, reach=0.1), lab.eyes(sectors=4, reach=0.1, robots=0.0165)
        self.crowd, self.red = lab.crowd(reach=0.1), lab.crowd(reach=0.2, leds=[1])
    def frame(self, lab):
        self.trail.lay(lab.ids % 10 == 0, 0.1)
        lab.tell(lab.seen, kind=1, value=(self.trail.value > 2) | (self.crowd.count > 3))
"""


def kit_sensors(bench):
    """1000 robots with five virtual sensors each, in two labs and in Python: simulated seconds in one of the wall, beside the same without sensors;
    and the sensors alone, called from C++."""
    folder, robots, seconds, speed = bench.folder(), 500, 20, {}
    for name, text in {"five": KIT, "none": "import arkmesh\nclass Nothing(arkmesh.Scenario):\n    def frame(self, lab):\n        lab.tell(lab.seen, kind=1, value=lab.ids % 2)\n"}.items():
        (folder / f"{name}.py").write_text(text)
        files = lab_files(folder, ["a", "b"], seconds, f"{name}.py", robots, 3.2)
        speed[name] = max(bench.run(*files, "--set", "view.use=false")["wall"]["speed"] for _ in range(ROUNDS))
    each_us = 1e6 * (1 / speed["five"] - 1 / speed["none"]) / (2 * robots * 10)
    alone = bench.say(bench.built("bench_kit")).split()
    return (speed["five"] >= 20 and float(alone[3]) >= 20,
            f"Python {speed['five']:.0f} (without {speed['none']:.0f}), {each_us:.1f} us a robot and frame; C++, sensors alone, {float(alone[3]):.0f}, {float(alone[1]):.1f} us", "20")


MEASURES = [labs_sixteen, labs_growth, labs_addition, kit_sensors]
NOT_JUDGED_SHORT = set(MEASURES)
