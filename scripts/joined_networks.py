"""Networks of their own for labs, joined by a cable or behind routers, as if each lab were a machine; and keys, with which the labs trust each other."""
import contextlib
import shutil
import subprocess

from lab_processes import PROGRAM, ROOT, Failed, begin, end_with_parent, last_line, ready

# The first address of each lab's end of the cable: 10.77.0.1, 10.77.0.2.
ADDRESS = "10.77.0.{}"
PORT = 7444


def call(*command):
    """What a command said; Failed when it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"`{' '.join(str(word) for word in command)}` failed: {last_line(done.stderr or done.stdout)}")
    return done.stdout


@contextlib.contextmanager
def network(demo="--remote"):
    """Words before a command that run it in a network of its own, which is there as long as the block. Needs root, or `scripts/alone` around it."""
    # A process that does nothing keeps the network; with it, it is gone.
    try:
        keeper = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo; exec sleep infinity"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                  preexec_fn=end_with_parent)
    except OSError as error:
        raise Failed(f"unshare cannot be started ({error.strerror}); scripts/setup test installs it.") from None
    try:
        if not keeper.stdout.readline():
            raise Failed(f"Networks of their own can be made by root only; try: scripts/alone scripts/demo {demo}")
        yield ["nsenter", "-t", str(keeper.pid), "-n", "--"]
    finally:
        keeper.stdout.close()
        keeper.kill()
        keeper.wait()


def lay_cable(one, end, address, other, other_end, other_address):
    """A cable between two networks, with the name and the address of each end."""
    call(*one, "ip", "link", "add", end, "type", "veth", "peer", "name", other_end, "netns", other[2])
    for words, name, own in ((one, end, address), (other, other_end, other_address)):
        call(*words, "ip", "address", "add", own, "dev", name)
        for each in (name, "lo"):
            call(*words, "ip", "link", "set", each, "up")


def keep_lcm_in(words):
    """LCM stays in the lab."""
    call(*words, "ip", "route", "add", "224.0.0.0/4", "dev", "lo")


@contextlib.contextmanager
def joined_networks(labs):
    """{lab: words before a command that run it in the lab's network} of two labs."""
    with contextlib.ExitStack() as ending:
        enter = {lab: ending.enter_context(network()) for lab in labs}
        one, other = enter.values()
        lay_cable(one, "cable", f"{ADDRESS.format(1)}/24", other, "cable", f"{ADDRESS.format(2)}/24")
        for words in enter.values():
            keep_lcm_in(words)
        yield enter


# What a lab's router does: it lends its address to who is behind it, and lets in answers alone.
ROUTER_RULES = """table ip lab {
  chain out { type nat hook postrouting priority srcnat; oifname "outside" masquerade; }
  chain in { type filter hook forward priority filter; policy drop; ct state established,related accept; iifname "inside" accept; }
}
"""
HALL = "10.78.0.1"  # where the server is; the labs' routers are 10.78.1.2, 10.78.2.2


@contextlib.contextmanager
def networks_behind_routers(labs):
    """({lab: words before a command that run it in the lab's network}, those of the network of a server at HALL). Each lab is behind a router that
    translates addresses, all have the same private one, and nothing leads from lab to lab."""
    with contextlib.ExitStack() as ending:
        hall = ending.enter_context(network("--federation"))
        call(*hall, "ip", "address", "add", f"{HALL}/32", "dev", "lo")
        enter = {}
        for number, lab in enumerate(labs, 1):
            router, enter[lab] = ending.enter_context(network("--federation")), ending.enter_context(network("--federation"))
            lay_cable(router, "outside", f"10.78.{number}.2/24", hall, f"lab{number}", f"10.78.{number}.1/24")
            lay_cable(router, "inside", "192.168.1.1/24", enter[lab], "cable", "192.168.1.2/24")
            call(*router, "ip", "route", "add", "default", "via", f"10.78.{number}.1")
            call(*enter[lab], "ip", "route", "add", "default", "via", "192.168.1.1")
            call(*router, "sh", "-c", "echo 1 > /proc/sys/net/ipv4/ip_forward")
            call(*router, "nft", ROUTER_RULES)
            keep_lcm_in(enter[lab])
        yield enter, hall


def start_nats_server(folder, text, words=(), name="nats-server", preexec_fn=end_with_parent):
    """The server with this configuration, which lies in the folder beside what it says; `words` go before its command."""
    file = folder / f"{name}.conf"
    file.write_text(text)
    return begin([*words, "/usr/sbin/nats-server", "-c", file], file.with_suffix(".txt"), "scripts/setup federation installs it", preexec_fn)


def nats_server(folder, text, words=()):
    """The server as a context, ready: its process."""
    return ready(start_nats_server(folder, text, words), folder / "nats-server.txt", "Server is ready", "The NATS server")


def server_text():
    """The configuration of a server at HALL."""
    return (ROOT / "experiments/federation/server.conf").read_text().replace("127.0.0.1:4222", f"{HALL}:4222")


def make_keys(labs, folder, program=PROGRAM):
    """Each lab has keys of its own in folder/LAB, and trusts all others."""
    for lab in labs:
        call(program, "keys", "init", lab, "--keys", folder / lab)
    for lab in labs:
        for other in labs:
            if other != lab:  # what `arkmesh keys trust` does, without a process for each pair
                (folder / lab / "trusted").mkdir(exist_ok=True)
                shutil.copy(folder / other / f"{other}.crt", folder / lab / "trusted")


def join_at_server(labs, folder, servers, program=PROGRAM):
    """{lab: overrides of its file}: each lab has keys of its own below `folder`; all meet at the servers of gateway.connect, encrypted."""
    make_keys(labs, folder, program)
    return {lab: [f'gateway.keys="{(folder / lab).resolve()}"', 'gateway.listen=""', "gateway.peers=[]", f'gateway.connect="{servers}"', "gateway.encrypt=true"]
            for lab in labs}


def join_by_tls(labs, folder, program=PROGRAM):
    """{lab: overrides of its file}: each of two labs has keys of its own below `folder`; the first listens, the second connects over TLS."""
    first, second = labs
    make_keys(labs, folder, program)
    return {first: [f'gateway.keys="{(folder / first).resolve()}"', f'gateway.listen="tls://0.0.0.0:{PORT}"', f'gateway.peers=[{{lab="{second}"}}]'],
            second: [f'gateway.keys="{(folder / second).resolve()}"', f'gateway.peers=[{{lab="{first}",connect="tls://{ADDRESS.format(1)}:{PORT}"}}]']}
