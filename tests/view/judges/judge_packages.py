"""Programs of others from npm that judge what arkmesh writes: versions and hashes in package-lock.json. Needs npm, and a network the first time."""
import pathlib
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[3]
PLACE = ROOT / "build/judges"


def installed():
    """The folder of the packages."""
    PLACE.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(pathlib.Path(__file__).with_name(name), PLACE)
    subprocess.run(["npm", "ci", "--ignore-scripts", "--no-fund", "--no-audit"], cwd=PLACE, check=True, stdout=subprocess.DEVNULL)
    return PLACE / "node_modules"
