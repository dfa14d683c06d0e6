"""Makes small run folders, as a run leaves them, for tests of the scripts. Needs the message types of scripts/build."""
import math
import pathlib
import struct
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / folder)
                for folder in ("scripts", "drawing", "tests/support", "tests/campaign", "tests/measure", "tests/figures")]
import read_log  # noqa: E402
from read_log import new  # noqa: E402


def field(name, values):
    return new("field_t", name=name, values=values, n=len(values))


def event(number, seconds, channel, data):
    """One event of an LCM log."""
    name = channel.encode()
    return struct.pack(">IqqII", read_log.SYNC, number, int(seconds * 1e6), len(name), len(data)) + name + data


LABS = {"roark": (0.5, 12, 2.0), "shark": (1.0, 48, 1.0)}
SITES_UM = [(-375000, 375000), (125000, 375000), (375000, 125000), (-125000, 125000), (-375000, -125000), (125000, -125000),
            (-125000, -375000), (375000, -375000)]


def robots(lab, period):
    side, count, scale = LABS[lab]
    out = []
    for i in range(count):
        angle = 2.4 * i + 0.05 * period
        r = 0.46 * side * math.sqrt((i + 0.5) / count)
        x, y = scale * r * math.cos(angle), scale * r * math.sin(angle)
        out.append(new("shared_robot_t", robot=i, x_um=round(x * 1e6), y_um=round(y * 1e6), heading_urad=round(1e6 * (angle % 6 - 3)),
                       led=(4, 4, 2, 1)[i % 4]))
    return out


def view(lab, period, of=LABS):
    """The shared view of a run of DHTF of these labs at one boundary."""
    labs = []
    for name in of:
        own = [field("team", [(period + i) % (5 if name == "shark" else 3) for i in range(8)])]
        if name == "shark":
            own += [field("active", [1, 1, 0, 1, 1, 1, 0, 1])]
            if period == 0:
                own += [field("site_x_um", [x for x, _ in SITES_UM]), field("site_y_um", [y for _, y in SITES_UM]),
                        field("site_hard.roark", [0, 1, 0, 1, 0, 1, 0, 1]), field("site_hard.shark", [0, 0, 1, 1, 0, 0, 1, 1])]
        labs.append(new("lab_view_t", lab=name, period=period, robots=robots(name, period), fields=own))
    return new("shared_view_t", stamp_us=period * 2000000, period=period, scale=LABS[lab][2], labs=labs)


CONFIG = """[run]
seed = 7
[shared.projection.roark]
scale = 2.0
[scenario.dhtf]
site_radius_m = 0.08
[scenario.dhtf.requirements]
shark = [2, 4]
roark = [1, 2]
"""
COMPLETED = "period,time_s,site,cell,active_since_s,hard.roark,hard.shark,team.roark,team.shark\n"


def make_lab(path, lab, periods=5, labs=LABS):
    """Writes path/{log.lcm, config.toml, completed.csv} of one lab."""
    path = pathlib.Path(path)
    path.mkdir(parents=True, exist_ok=True)
    side, count, _ = LABS[lab]
    arena = new("arena_info_t", lab=lab, platform="ode", width_m=side, height_m=side, robots=count, body_radius_m=0.0165)
    log = event(0, 1e9, "arena", arena.encode())
    for period in range(periods):
        log += event(2 * period + 1, 1e9 + 2 * period, "shared", view(lab, period, labs).encode())
        log += event(2 * period + 2, 1e9 + 2 * period, "foreign", b"not one of ours")
    (path / "log.lcm").write_bytes(log)
    (path / "config.toml").write_text(CONFIG)
    rows = [f"{p},{2 * p}.000000,{p % 8},{p},0.000000,{p % 2},{p // 2 % 2},1,2\n" for p in range(1, periods)]
    (path / "completed.csv").write_text(COMPLETED + "".join(rows))


def make(folder, periods=5, labs=LABS):
    """A run folder of labs shark and roark, or of one of them."""
    for lab in labs:
        make_lab(pathlib.Path(folder) / lab, lab, periods, labs)
