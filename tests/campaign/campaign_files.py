"""The configuration files of two small labs, of an emulated testbed, and a robot's program that crashes."""
from lab_processes import ROOT

DHTF = ROOT / "scenarios/dhtf/controller/dhtf.c"
PORTS = {"shark": 7701, "roark": 7702}  # of the LCM buses
LISTENS, THROUGH = 7801, 7811           # shark's gateway, and the link to it
LAB_TEXT = """include = ["{root}/experiments/dhtf/common.toml", "{root}/experiments/dhtf/presets/paper.toml"]
lab.name = "{lab}"
bus.url = "udpm://239.255.76.67:{bus}?ttl=0&recv_buf_size=4194304"
run.duration_s = {duration_s}
gate = {{period_s = {period_s}, patience_s = {patience_s}}}
recorder.keep_free_mib = 0
arena = {{use = "{use}", pace = {pace}, width_m = {side_m}, height_m = {side_m}, robots = {robots}, ode.controller = "{controller}", kilobot = {{port = "{port}", cameras = [
  {{source = "http://127.0.0.1:8090/camera0", calibration = "{out}/testbed.yaml"}}]}}}}
"""
GATEWAYS = {"shark": f'[gateway]\nlisten = "127.0.0.1:{LISTENS}"\n[[gateway.peers]]\nlab = "roark"\n',
            "roark": f'[gateway]\n[[gateway.peers]]\nlab = "shark"\nconnect = "127.0.0.1:{THROUGH}"\n'}
EMULATOR_TEXT = """emulator.frames_per_s = 10.0
emulator.camera = [{{name = "camera0", width_px = 640, height_px = 480, z_m = 0.95, focal_px = 800.0}}]
arena = {{robots = {robots}, width_m = 0.5, height_m = 0.5, ode.controller = "{controller}"}}
{more}"""
CRASH_TEXT = """#include <kilolib.h>
static int *nowhere = 0;
void setup() {{}}
void loop() {{
    set_color(RGB(0, 1, 0));
    if (kilo_ticks > {tick}) *nowhere = 1;
}}
int main() {{
    kilo_init();
    kilo_start(setup, loop);
    return 0;
}}
"""


def lab(name, port="tcp://127.0.0.1:8091", **values):
    return LAB_TEXT.format(root=ROOT, lab=name, bus=PORTS[name], port=port, **values) + GATEWAYS[name]


def emulator(robots, more=""):
    """Of one camera over half a metre; `more` lines."""
    return EMULATOR_TEXT.format(robots=robots, controller=DHTF, more=more)


def crashing_program(tick):
    """A robot's program that crashes at that tick; a second has 31."""
    return CRASH_TEXT.format(tick=tick)
