"""What happens when: what labs promise for each fault, in each phase of a run, on each kind of arena. tests/campaign/campaign judges by this table, and
The page of failure behaviour is printed from it.

The lab that the fault meets is roark, its peer is shark.
"""
import dataclasses
import re

ARENAS = {
    "simulated": "both labs simulate, as fast as they can (strict: a lab waits for its peer at each boundary)",
    "paced": "both labs simulate in real time (free: lab time goes on without the peer)",
    "hardware": "the lab drives an emulated testbed in real time: cameras, overhead controller, robots (free); its peer simulates in real time",
}
PHASES = {
    "waiting at 0": "the lab waits for its peer, which was not started yet; it is started after the fault",
    "running": "both labs are in mid-run",
    "waiting in mid-run": "the link is cut, and the lab waits for its peer; the link is mended after the fault",
    "ending": "the lab has finished and repeats its last state for its peer",
}
FAULTS = {
    "Ctrl-C": "the lab's operator presses Ctrl-C",
    "SIGTERM": "the lab is asked to end",
    "SIGKILL": "the lab's process is killed",
    "Ctrl-C, line away": "the line to the controller is cut, the operator presses Ctrl-C, and the line comes back after 8 s",
    "SIGKILL, line away": "the line to the controller is cut, the lab's process is killed, and the line comes back after 8 s",
    **{f"{who} in vain, {line} away": f"the {line} to the controller is cut, the lab's process is killed, {what} reaches nobody, and the {line} comes back after 8 s"
       for who, what in (("ohc", "`arkmesh ohc PORT pause`"), ("upload", "`arkmesh ohc PORT upload`"), ("second lab", "another lab"))
       for line in ("line", "terminal")},
    **{f"stalls {seconds} s, pause {when}": f"the line to the controller holds all bytes back for {seconds} s; the lab is told to pause a second after {what}"
       for seconds in (5, 15) for when, what in (("during", "that began"), ("after", "bytes pass again"))},
    "hangs, pause": "the lab's process hangs for 7 s, and is told to pause",
    "hangs, stop": "the lab's process hangs, is told to stop, and is killed then",
    "hangs, SIGKILL": "the lab's process hangs for 7 s, and is killed",
    "hangs 2 s": "the lab's process hangs for 2 s",
    "hangs 10 s": "the lab's process hangs for 10 s",
    "SIGSTOP 20 s": "the lab's process stands still for 20 s",
    "program crash": "a robot's program crashes; on hardware a robot fails",
    "scenario exception": "the scenario fails",
    "peer killed": "the peer's process is killed",
    "peer's states refused": "the peer sends states that break the rules",
    "link cut": "the link between the labs is cut for good",
    "link cut 4 s": "the link between the labs is cut and mended",
    "disk full": "the run folder's disk is full, with `recorder.keep_free_mib = 0`",
    "run folder removed": "the run folder is deleted",
}
LINKS = {
    "tcp": "two gateways on one machine, over plain TCP",
    "tls": "the same over TLS",
    "nats": "the same at a NATS server on this machine",
}
# What robots know, with a scenario in Python or C++: the phase, and its faults.
WORDS, LANGUAGES = "words", ("Python", "C++")
WORD_FAULTS = [f"{what}, {when}" for what in ("reset", "robot off and on", "robot away")
               for when in ("before words", "after words", "while the line is away")]
WORD_FAULTS += [f"parameters, {when}" for when in ("line away at the start", "pause before the start", "reset")]
# A day with emulated robots, from calibration to ten minutes of an experiment: the phase, and its rooms.
REHEARSAL, ROOMS = "rehearsal", ("bright room", "dim room", "blurred room")
LINK = "link"  # the phase of faults between gateways: both labs simulate in mid-run


@dataclasses.dataclass(frozen=True)
class LinkFault:
    """A fault between two gateways, which both labs survive with the hash of an undisturbed run. `counters` is what grows, a regular expression for
    LAB.COUNTER of the gateways' `peers`, by kind of link where they differ; a kind without one does not have the fault. `nats` is that of labs that
    meet at a server."""
    words: str
    counters: str | dict
    down: bool | None = False  # whether both ends that live show the link as down; None: they may
    after: str = ""  # what is promised, or found, besides
    nats: str | None = None
    of_server: bool = False  # it is the server's, so that the third gateway notices, too

    def counter(self, kind):
        if kind == "nats":
            return self.nats
        return self.counters if isinstance(self.counters, str) else self.counters.get(kind)


TLS, REFUSED_HELLO = "tls", r"shark\.session\.refused\.(unknown_lab|lab_name)"
LINK_FAULTS = {
    "connecting gateway killed": LinkFault("the gateway of the side that connects is killed, and started again after 4 s",
                                           r"shark\.session\.closed\.(by_peer|connection_lost)", True, nats=r"shark\.session\.closed\.\w+"),
    "listening gateway killed": LinkFault("the gateway of the side that listens is killed, and started again after 4 s",
                                          r"roark\.session\.closed\.(by_peer|connection_lost)", True),
    "gateway frozen 6 s": LinkFault("the peer's gateway stands still (SIGSTOP)", r"shark\.session\.closed\.silent", True, nats=r"shark\.session\.closed\.silent"),
    "half-open 6 s": LinkFault("packets of the side that listens vanish, those of the other arrive", r"roark\.session\.closed\.silent", True),
    "partition 1 s": LinkFault("all packets between the two vanish", "", after="the connection holds", nats=""),
    "partition 60 s": LinkFault("all packets between the two vanish", r"(shark|roark)\.session\.closed\.silent", True, nats=r"(shark|roark)\.session\.closed\.silent"),
    "flapping 60 s": LinkFault("all packets between the two vanish for 200 ms, pass for 200 ms, and so on", "", None, nats=""),
    "slow reader 40 s": LinkFault("what goes to the side that listens passes at 1 kB/s", r"roark\.outbox\.replaced\.world", None),
    "clock an hour ahead": LinkFault("the wall clock of the peer's machine jumps an hour ahead", "", after="the clock's offset is shown", nats=""),
    "clock an hour back": LinkFault("the wall clock of the peer's machine jumps an hour back", "", after="the clock's offset is shown", nats=""),
    "old session replayed": LinkFault("the bytes of an earlier connection are sent again",
                                      {"tcp": r"shark\.session\.(replaced|closed\.bad_ack)", TLS: r"shark\.session\.failed\.handshake"}, None),
    "garbage": LinkFault("all kinds of bytes that are no session, before and after a hello", r"shark\.session\.closed\.bad_.*"),
    "another lab's name": LinkFault("somebody claims the name of a lab that is not its own", REFUSED_HELLO),
    "channel not imported": LinkFault("a peer publishes on a channel that is not imported", r"shark\.received\.refused\.not_imported\.stray"),
    "flood of 1000": LinkFault("1000 connections that say nothing, and twenty that say a byte a second",
                               r"shark\.session\.closed\.too_many_(pending|of_address)"),
    "wrong kind of link": LinkFault("plain TCP to a TLS port; TLS to a plain port",
                                    {"tcp": r"shark\.session\.closed\.speaks_tls", TLS: r"shark\.session\.refused\.plain_tcp"}),
    "certificate unknown": LinkFault("a gateway comes whose certificate is not trusted", {TLS: r"shark\.session\.refused\.certificate_unknown"}),
    "certificate expired": LinkFault("a trusted lab comes whose certificate ended a year ago", {TLS: ""},
                                     after="it counts; `certificate.days_left` is 0"),
    "certificate revoked": LinkFault("a lab that is connected is revoked, and comes again", {TLS: r"shark\.session\.refused\.certificate_revoked"},
                                     after="its link is cut within 1 s"),
    "certificate of another lab": LinkFault("a gateway expects a trusted lab where there is another",
                                            {TLS: r"raven\.session\.refused\.certificate_of_other_lab"}),
    "full disk": LinkFault("the disk is full on which labs record and gateways' output is kept, and the link is cut", "", None,
                           after="both labs run to the end with that hash, and fail, for their logs are not whole"),
    "descriptors exhausted": LinkFault("strangers connect to a gateway that may open few files", r"shark\.session\.failed\.accept"),
}
LINK_FAULTS |= {
    "server killed 60 s": LinkFault("the NATS server is killed, and started again", {}, True, nats=r"(shark|roark)\.server\.closed\.lost", of_server=True),
    "server frozen 6 s": LinkFault("the NATS server stands still (SIGSTOP)", {}, True, nats=r"(shark|roark)\.server\.closed\.silent", of_server=True),
    "server out of memory 6 s": LinkFault("the NATS server holds more for a client that reads nothing than it has memory for, ends, and is started again", {}, True,
                                          nats=r"(shark|roark)\.server\.closed\.lost", of_server=True),
    "server takes 16 kB 60 s": LinkFault("the NATS server is started again with a `max_payload` that is too small, and then with a larger one", {}, True,
                                         nats=r"(shark|roark)\.server\.refused\.payload_limit", of_server=True),
    "server is full 60 s": LinkFault("strangers take all connections that the NATS server allows, and the peer's own is lost", {}, True, nats=r"roark\.server\.failed\.connect"),
    "slow consumer 40 s": LinkFault("what goes to the peer from the NATS server passes at 1 kB/s, and no more than 64 kB wait for it there", {}, None,
                                    nats=r"(shark|roark)\.(server|session)\.closed\.\w+"),
    "one message in ten lost 40 s": LinkFault("of the messages that the NATS server sends to the peer each tenth is dropped", {}, None,
                                              nats=r"(shark|roark)\.federation\.pieces\.sent_again"),
    "cluster partition 60 s": LinkFault("the labs are at two NATS servers of one cluster, and all packets between these vanish", {}, True,
                                        after="their machines have `net.ipv4.tcp_retries2 = 5`", nats=r"(shark|roark)\.session\.closed\.silent"),
    "cluster's server killed 60 s": LinkFault("the labs are at two NATS servers of one cluster, and the peer's is killed", {}, None,
                                              after="its gateway goes to the other", nats=r"roark\.server\.closed\.lost"),
}
EXIT_CODES = {"finished": 0, "failed": 1, "stopped": 3, "killed": -9}


@dataclasses.dataclass(frozen=True)
class Promise:
    """How the lab ends and what it says about it, and the same of its peer. `says` are regular expressions; a peer that is None ends as it likes."""
    end: str = "finished"
    says: str = ""
    peer: str | None = "finished"
    peer_says: str = ""
    code: int | None = None  # where it is not that of `end`
    may_be_finished: bool = False  # a killed lab's result may say so
    note: str = ""  # for the reader


@dataclasses.dataclass(frozen=True)
class NoSense:
    """A cell that makes no sense, and why."""
    why: str


GOES_ON = Promise()
GONE_ROARK = r"roark is gone|gave up waiting for roark|without roark|waiting for roark"
GONE_SHARK = r"shark is gone|gave up waiting for shark|without shark"
STOPPED = Promise("stopped", "stopped by the operator", "stopped", GONE_ROARK)
KILLED = Promise("killed", "", "failed", GONE_ROARK)
PEER_GONE = Promise("failed", GONE_SHARK, None)
REFUSED = Promise("failed", r"refuse|no robot|largest id", None)
GAVE_UP = Promise("failed", GONE_SHARK, "failed", GONE_ROARK, note="after `gate.patience_s`")
CRASHED = Promise("failed", r"roark failed at period \d+: the program of robot \d+ crashed", "failed", GONE_ROARK)
FAILED = Promise("failed", r"roark failed at period \d+: the scenario was told to fail", "failed", GONE_ROARK)
DISK_FULL = Promise("failed", r"recording in .* stopped", note="robots run to the end; the log is not whole, and `result.json`, which has its room from the start, says so")
REMOVED = Promise("failed", r"\"state\": \"failed\"", note="robots run to the end; said once, and the result goes to stdout")
STANDS_STILL = "lab time stands still: no robot's program runs, and no scenario is called"
IS_OVER = "the run is over: no robot's program runs, and no scenario is called"


def promise(arena, phase, fault):
    """What is promised for one cell: a Promise, or NoSense."""
    if phase in (WORDS, REHEARSAL):
        return GOES_ON
    if phase == LINK:
        return NoSense("this kind of link does not have the fault") if LINK_FAULTS[fault].counter(arena) is None else GOES_ON
    strict = arena == "simulated"
    at_0, waits, ending = phase == "waiting at 0", phase == "waiting in mid-run", phase == "ending"
    if fault.endswith(" away") or fault.startswith(("hangs", "stalls")):
        if arena != "hardware" or phase != "running":
            return NoSense("only the hardware has a controller, and only robots that run have to stand")
        if fault.startswith("Ctrl-C"):
            return dataclasses.replace(STOPPED, code=4, note="nobody saw that robots stand")
        return KILLED if fault.endswith((" away", "stop", "SIGKILL")) else GOES_ON
    if fault in ("Ctrl-C", "SIGTERM"):
        if ending:
            return Promise(note="the result stands")
        return Promise("stopped", STOPPED.says, None) if at_0 else dataclasses.replace(STOPPED, peer="failed", note="the peer does not hear of it") if waits else STOPPED
    if fault == "SIGKILL":
        if ending:
            return Promise("killed", "", "finished", may_be_finished=True, note="its result says `finished` when that was written already")
        return Promise("killed", "", None) if at_0 else KILLED
    if fault == "SIGSTOP 20 s":
        if strict and phase == "running":
            return Promise("failed", GONE_SHARK, "failed", r"roark is gone at period \d+: silent")
        return GOES_ON
    if fault in ("program crash", "scenario exception"):
        if arena == "hardware" and fault == "program crash":
            return Promise(note="the other robots play on")
        if ending:
            return NoSense(IS_OVER)
        if at_0 or (strict and waits):
            return NoSense(STANDS_STILL)
        if waits and fault == "program crash":
            return NoSense("robots that are paused run no program")
        return CRASHED if fault == "program crash" else FAILED
    if fault == "peer killed":
        if at_0:
            return Promise(note="the lab waits on, for the peer's next start")
        return Promise(peer="killed", may_be_finished=True) if ending else dataclasses.replace(PEER_GONE, peer="killed")
    if fault == "peer's states refused":
        return Promise(peer=None) if ending else REFUSED
    if fault == "link cut":
        if at_0:
            return Promise("stopped", "until it connects or the lab is stopped", None, note="the lab waits until it is stopped, and says so")
        return Promise(peer=None) if ending else GAVE_UP
    if fault == "link cut 4 s":
        return GOES_ON
    if fault == "disk full":
        return DISK_FULL
    return REMOVED


def cells():
    """Every (arena, phase, fault)."""
    return [(arena, phase, fault) for arena in ARENAS for phase in PHASES for fault in FAULTS] + [
        *((kind, LINK, fault) for kind in LINKS for fault in LINK_FAULTS), *((language, WORDS, fault) for language in LANGUAGES for fault in WORD_FAULTS),
        *(("hardware", REHEARSAL, room) for room in ROOMS)]


# What CI runs.
SHORT = [
    ("simulated", "waiting at 0", "Ctrl-C"),
    ("simulated", "waiting at 0", "peer's states refused"),
    ("simulated", "running", "SIGTERM"),
    ("simulated", "running", "SIGKILL"),
    ("simulated", "running", "scenario exception"),
    ("simulated", "running", "disk full"),
    ("simulated", "waiting in mid-run", "run folder removed"),
    ("simulated", "waiting in mid-run", "link cut"),
    ("paced", "running", "peer killed"),
    ("paced", "ending", "SIGTERM"),
    ("hardware", "waiting at 0", "SIGTERM"),
    ("hardware", "running", "SIGKILL"),
    ("hardware", "running", "Ctrl-C, line away"),
    ("hardware", "running", "SIGKILL, line away"),
    ("hardware", "running", "ohc in vain, line away"),
    ("hardware", "running", "hangs 10 s"),
]
SHORT_WORDS = [("Python", WORDS, "reset, after words"), ("C++", WORDS, "robot off and on, while the line is away"), ("C++", WORDS, "parameters, line away at the start")]

# And of faults between gateways: each once, over one kind of link or the other by turns, and at a server what only that has.
SHORT_LINKS = [next((kind, LINK, fault) for kind in (("tcp", "tls", "nats") if number % 2 else ("tls", "tcp", "nats")) if about.counter(kind) is not None)
               for number, (fault, about) in enumerate(LINK_FAULTS.items())]


def in_words(promised):
    """How the lab ends, and its peer where that differs."""
    if isinstance(promised, NoSense):
        return "-"
    code = EXIT_CODES[promised.end] if promised.code is None else promised.code
    words = promised.end + (f" ({code})" if code >= 0 else "")
    return words + (f", peer {promised.peer}" if promised.peer and promised.peer != promised.end else "")


def links_page():
    """Faults between gateways, as lines of the page."""
    lines = ["## Between gateways", "",
             "Both labs simulate in mid-run (strict), joined by their gateways over plain TCP, over TLS, or at a NATS server; a third gateway is joined with one",
             "of them. In each cell both labs finish with the hash of an undisturbed run; no gateway ends, hangs, or grows by more than 8 MiB; the third gateway's",
             "link is up and carries data all the time, unless the fault is the server's; `ordered` messages between the two are neither lost nor repeated (when a",
             "gateway was killed, a gap). A link that is down is shown so within 3 s (at a server 4 s), and data flows within 1 s of the path's return (2 s of a",
             "killed gateway's start; at a server 8 s, for a lost connection to it is tried each 5 s).", "",
             "| fault | event | link shown as down | counter that grows |", "|---|---|---|---|"]
    for fault, about in LINK_FAULTS.items():
        counters = {kind: about.counter(kind) for kind in LINKS if about.counter(kind) is not None}
        patterns = dict.fromkeys(counters.values())
        told = [", ".join(f"`{plain}`" for plain in plain_counters(pattern)) + (f" ({', '.join(kind for kind in counters if counters[kind] == pattern)})"
                if len(patterns) > 1 or len(counters) < len(LINKS) else "") for pattern in patterns if pattern]
        down = {True: "yes", False: "no", None: "it may be"}[about.down]
        lines.append(f"| {fault} | {about.words}{'; ' + about.after if about.after else ''} | {down} | {'; '.join(told) or '-'} |")
    return lines + [""]


def plain_counters(pattern):
    """The names of counters in a pattern for LAB.COUNTER, for people."""
    name = pattern.replace(".*", "*").replace(r"\w+", "*").replace("\\", "").partition(".")[2]
    if found := re.search(r"\((.*?)\)", name):
        return [name.replace(found[0], each) for each in found[1].split("|")]
    return [name]


def page():
    """The page of failure behaviour."""
    lines = ["# Failure behaviour", "",
             "How a lab reacts to each fault, in each phase of a run. `tests/campaign/campaign` brings two labs into each phase, causes the fault, and checks",
             "these tables, from which `tests/campaign/campaign --docs` prints this page.", "",
             "A cell gives the `state` in the lab's `result.json` and the lab's exit code, and the peer's where it differs. In each cell the lab ends or",
             "continues within `gate.patience_s` (and a few seconds to notice and to end), reports the reason in one sentence, and leaves a readable recording. A",
             "killed lab's result says `running` until the next start marks it as `killed`. Real robots stop within 3.5 s of the lab's end, however it ended, and",
             "of the moment when its controller is reachable again, by the emulator's record, also on a TCP line that held bytes back. A stopped",
             "lab exits with 4 if its cameras did not see them stand in time. A strict run that finishes has the hash of an undisturbed one.", ""]
    lines += links_page()
    lines += ["## What robots know", "", "All robots show what they were told last by `lab.tell` or `lab.parameters`, in Python and C++, within 15 s of the fault's end:", "",
              *(f"- {fault}" for fault in WORD_FAULTS), ""]
    notes = []

    def noted(promised):
        note = promised.why if isinstance(promised, NoSense) else promised.note
        if note and note not in notes:
            notes.append(note)
        return f" [{notes.index(note) + 1}]" if note else ""

    for arena, words in ARENAS.items():
        lines += [f"## {arena.capitalize()}", "", f"{words[0].upper()}{words[1:]}.", "", f"| fault | {' | '.join(PHASES)} |", "|---" * (len(PHASES) + 1) + "|"]
        for fault in FAULTS:
            row = [promise(arena, phase, fault) for phase in PHASES]
            if not all(isinstance(promised, NoSense) for promised in row):
                lines.append(f"| {fault} | {' | '.join(in_words(promised) + noted(promised) for promised in row)} |")
        lines.append("")
    lines += [f"{number}. {note[0].upper()}{note[1:]}." for number, note in enumerate(notes, 1)]
    for title, words in (("The phases", PHASES), ("The faults", FAULTS)):
        lines += ["", f"## {title}", "", "| | |", "|---|---|", *(f"| {name} | {text} |" for name, text in words.items())]
    return "\n".join(lines) + "\n"
