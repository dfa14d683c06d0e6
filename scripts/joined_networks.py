"""Networks of their own for labs, joined by a cable, as if each lab were a machine; and keys, with which the labs trust each other."""
import contextlib
import subprocess

from lab_processes import PROGRAM, Failed, end_with_parent

# The first address of each lab's end of the cable: 10.77.0.1, 10.77.0.2.
ADDRESS = "10.77.0.{}"
PORT = 7444


def call(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip().splitlines() or ["it said nothing"]
        raise Failed(f"`{' '.join(str(word) for word in command)}` failed: {said[-1]}")


@contextlib.contextmanager
def joined_networks(labs):
    """{lab: words before a command that run it in the lab's network} of two labs. Needs root, or `scripts/alone` around it."""
    with contextlib.ExitStack() as ending:
        enter = {}
        for lab in labs:
            # A process that does nothing keeps the network; with it, it is gone.
            try:
                keeper = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo; exec sleep infinity"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                          preexec_fn=end_with_parent)
            except OSError as error:
                raise Failed(f"unshare cannot be started ({error.strerror}); scripts/setup test installs it.") from None
            ending.callback(keeper.wait)
            ending.callback(keeper.kill)
            ending.callback(keeper.stdout.close)
            if not keeper.stdout.readline():
                raise Failed("Networks of their own can be made by root only; try: scripts/alone scripts/demo --remote")
            enter[lab] = ["nsenter", "-t", str(keeper.pid), "-n", "--"]
        one, other = enter.values()
        call(*one, "ip", "link", "add", "cable", "type", "veth", "peer", "name", "cable", "netns", other[2])
        for number, words in enumerate(enter.values(), 1):
            call(*words, "ip", "address", "add", f"{ADDRESS.format(number)}/24", "dev", "cable")
            call(*words, "ip", "link", "set", "cable", "up")
            call(*words, "ip", "link", "set", "lo", "up")
            call(*words, "ip", "route", "add", "224.0.0.0/4", "dev", "lo")  # LCM stays in the lab
        yield enter


def join_by_tls(labs, folder, program=PROGRAM):
    """{lab: overrides of its file}: each of two labs has keys of its own below `folder`; the first listens, the second connects over TLS."""
    first, second = labs
    for lab in labs:
        call(program, "keys", "init", lab, "--keys", folder / lab)
    call(program, "keys", "trust", folder / second / f"{second}.crt", "--keys", folder / first)
    call(program, "keys", "trust", folder / first / f"{first}.crt", "--keys", folder / second)
    return {first: [f'gateway.keys="{(folder / first).resolve()}"', f'gateway.listen="tls://0.0.0.0:{PORT}"', f'gateway.peers=[{{lab="{second}"}}]'],
            second: [f'gateway.keys="{(folder / second).resolve()}"', f'gateway.peers=[{{lab="{first}",connect="tls://{ADDRESS.format(1)}:{PORT}"}}]']}
