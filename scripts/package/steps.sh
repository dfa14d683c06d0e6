# The steps of scripts/package/check, inside the new system: functions, in the order in which they are run, the later ones
# with systemd where it can be started. A line `says: ...` is shown.
cd /root
experiments=/usr/share/arkmesh/experiments

# Says that it has gone wrong.
fail() { echo "wrong: $*"; exit 1; }
# expect WORDS COMMAND...: the command fails, and says the words in one line.
expect() {
  local said
  ! said=$("${@:2}" 2>&1) || fail "no failure: ${*:2}"
  [ "$(wc -l <<<"$said")" -eq 1 ] || fail "not one sentence: $said"
  [[ $said == *"$1"* ]] || fail "not '$1': $said"
  echo "says: $said"
}
# later SECONDS COMMAND...: the command succeeds within that time.
later() {
  for _ in $(seq $((10 * $1))); do "${@:2}" && return 0; sleep 0.1; done
  fail "not within $1 s: ${*:2}"
}
packages() { apt-get install -y --no-install-recommends $(printf '%s_*.deb ' "$@"); }

install_gateway() { # step
  apt-get update
  packages /packages/arkmesh-gateway
  ! command -v cc gcc python3 || fail "the gateway takes a compiler or Python"
  ! dpkg-query -W 'libode*' 'libopencv*' || fail "the gateway takes the simulator or cameras"
}

gateway() { # step
  cat >door.toml <<'END'
lab.name = "door"
shared = {labs = ["door", "other"], owner = "door"}
bus.url = "udpm://239.255.76.67:7731?ttl=0"
gateway = {listen = "127.0.0.1:7831", peers = [{lab = "other"}]}
END
  arkmesh gateway door.toml >gateway.log 2>&1 &
  later 10 grep -q 7831 gateway.log
  (exec 3<>/dev/tcp/127.0.0.1/7831) || fail "the gateway does not listen"
  kill $! && wait $! || fail "the gateway ended with $?"
  arkmesh keys init door
  expect "it is in the package arkmesh" arkmesh lab door.toml
}

install_labs() { # step
  packages /packages/arkmesh
  ! command -v cc gcc || fail "labs take a compiler"
  expect "needs the package python3-arkmesh" arkmesh run $experiments/light_up/a.toml --out runs/none
  packages /packages/python3-arkmesh
}

demo() { # step
  local start=$SECONDS
  arkmesh run $experiments/dhtf/shark.toml $experiments/dhtf/roark.toml --out runs/dhtf
  echo "says: the demo took $((SECONDS - start)) s"
  grep -q final_hash runs/dhtf/shark/result.json || fail "no result"
  [ -f runs/dhtf/shark/files/dhtf.c ] || fail "the run's folder lacks the robots' program"
  arkmesh run $experiments/cre/meadow.toml $experiments/cre/sky.toml --seconds 20 --out runs/cre
  arkmesh rerun runs/cre
}

# The commands that docs/install.md has, as a user without root.
commands_of_the_page() { # step
  sed -n '/^## Trying it/,/^## Labs/{/^```sh/,/^```/{/^```/!p}}' /packages/install.md >/packages/trying.sh
  grep -q 'arkmesh run' /packages/trying.sh || fail "the page has no commands"
  install -d -o 1234 -g 1234 /home/visitor
  (cd /home/visitor && setpriv --reuid 1234 --regid 1234 --clear-groups env HOME=/home/visitor bash -euo pipefail /packages/trying.sh)
  [ -f /home/visitor/demo/result.json ] || fail "no result"
}

page() { # step
  arkmesh view runs/dhtf --port 8800 >view.log 2>&1 &
  later 20 python3 2>/dev/null -c \
    'import urllib.request as r; assert b"<html" in r.urlopen("http://127.0.0.1:8800/").read()'
  kill $! && wait $! || fail "the page ended with $?"
  arkmesh export runs/cre --csv
}

labs_as_processes() { # step
  timeout 600 arkmesh up $experiments/dhtf/shark.toml $experiments/dhtf/roark.toml --set run.duration_s=20 --out runs/up
}

python_scenario() { # step
  local name
  for name in light_up quorum relay beacon; do
    arkmesh run $experiments/$name/a.toml $experiments/$name/b.toml --seconds 10 --out runs/$name
  done
  arkmesh scenario new my_swarm
  arkmesh run my_swarm/a.toml my_swarm/b.toml --seconds 10 --out runs/my_swarm
  python3 -c 'import arkmesh; print(arkmesh.run("my_swarm/a.toml", "my_swarm/b.toml", seconds=10))'
}

program_without_compiler() { # step
  cp $experiments/light_up/light_up.c own.c
  echo '// my own' >>own.c
  expect "apt-get install gcc libc6-dev" arkmesh run my_swarm/a.toml my_swarm/b.toml \
    --set arena.ode.controller=own.c --out runs/own
}

units() { # step
  local unit score
  [ "$(stat -c %G:%a /etc/arkmesh)" = arkmesh:2775 ] || fail "/etc/arkmesh is not the group's"
  for unit in arkmesh-gateway@shark.service arkmesh-lab@shark.service; do
    systemd-analyze verify --man=no "$unit"
    [ -z "$(systemd-analyze verify --man=no "$unit" 2>&1)" ] || fail "verify says something of $unit"
    score=$(systemd-analyze security --offline=true --threshold=40 "$unit" | tail -n 1)
    echo "says: $unit: $score"
  done
}

install_sudo() { # step
  apt-get install -y --no-install-recommends sudo passwd
  visudo -cf /etc/sudoers.d/arkmesh
}

operators() { # step
  local file=/etc/arkmesh/shark.toml as
  useradd --create-home --groups arkmesh member
  as=(runuser -u member -- sudo -n -u arkmesh arkmesh)
  runuser -u member -- tee $file >/dev/null <<'END'
include = ["/usr/share/arkmesh/experiments/dhtf/shark.toml"]
shared.labs = ["shark"]
arena.pace = 1.0
END
  "${as[@]}" keys init shark
  (cd /var/lib/arkmesh && runuser -u arkmesh -- env HOME=/var/lib/arkmesh arkmesh lab $file) >lab.log 2>&1 &
  later 20 "${as[@]}" status $file --json
  "${as[@]}" pause $file
  "${as[@]}" stop $file
  wait $! && fail "the lab did not say that it was stopped" || [ $? -eq 3 ] || fail "the lab did not end with 3"
  ! runuser -u member -- sudo -n -u arkmesh arkmesh run $file || fail "operators may do more than they should"
  runuser -u member -- ls /var/lib/arkmesh/runs
}

install_testbed() { # step
  packages /packages/arkmesh-testbed
}

testbed() { # step
  cd $experiments/dhtf
  timeout 600 arkmesh run shark.toml roark_emulated.toml --seconds 20 --out /root/runs/testbed
}

install_all() { # step
  packages /packages/arkmesh-doc
  [ -f /usr/share/doc/arkmesh/html/docs/learn-scenario.html ] || fail "no documents"
}

install_dev() { # step
  packages /packages/libarkmesh-dev
}

scenario_in_cpp() { # step
  arkmesh scenario new own_swarm --cpp
  cmake -S own_swarm -B own_swarm/build
  cmake --build own_swarm/build
  own_swarm/build/own_swarm run own_swarm/a.toml own_swarm/b.toml --seconds 10 --out runs/cpp
  # With a compiler, a program of one's own runs.
  arkmesh run my_swarm/a.toml my_swarm/b.toml --seconds 10 --set arena.ode.controller=own.c --out runs/own
}

install_systemd() { # step
  apt-get install -y --no-install-recommends systemd-sysv dbus
}

# robots walk|stand: whether most of the emulated testbed's robots do, or all, in the last second of what its record holds.
robots() {
  python3 - "$1" <<'END'
import sys
rows = [row.split(",") for row in open("/root/truth.csv").read().rpartition("\n")[0].split("\n")[1:]]
latest = [row for row in rows if float(row[0]) > float(rows[-1][0]) - 1]
poses = {row[1]: {tuple(other[3:6]) for other in latest if other[1] == row[1]} for row in latest}
walking = sum(len(each) > 1 for each in poses.values())
sys.exit(not (walking == 0 if sys.argv[1] == "stand" else walking > len(poses) / 2))
END
}
emulated() { journalctl -q -u emulator | grep commands:; }
# standing: the robots stand, and go on standing.
standing() {
  later 30 robots stand
  sleep 3
  robots stand || fail "the robots walk again"
}
# A lab with an emulated testbed, whose robots walk. Once it has failed it is not started again while it is looked at.
start_lab() {
  systemctl start arkmesh-lab@roark
  later 180 robots walk
}

lab_as_service() { # step of a started system
  mkdir /run/systemd/system/arkmesh-lab@.service.d
  printf '[Service]\nRestartSec=600\n' >/run/systemd/system/arkmesh-lab@.service.d/later.conf
  systemctl daemon-reload
  cat >/etc/arkmesh/roark.toml <<'END'
include = ["/usr/share/arkmesh/experiments/dhtf/roark.toml"]
shared = {labs = ["roark"], owner = "roark"}
scenario.dhtf.requirements.roark = [1, 2]
arena.use = "kilobot"
END
  systemd-run -q --unit=emulator arkmesh emulator $experiments/emulator/roark.toml --truth /root/truth.csv
  later 60 emulated
  start_lab
}

service_stops() { # step of a started system
  systemctl stop arkmesh-lab@roark
  standing
  [ "$(systemctl show -P Result arkmesh-lab@roark)" = success ] || fail "a stopped lab counts as failed"
}

service_is_killed() { # step of a started system
  start_lab
  systemctl kill --kill-whom=main -s KILL arkmesh-lab@roark
  standing
  grep -sx arkmesh-guard /proc/[0-9]*/comm || fail "the guard did not outlive its lab"
}

service_comes_back() { # step of a started system
  rm /run/systemd/system/arkmesh-lab@.service.d/later.conf
  systemctl daemon-reload
  systemctl stop arkmesh-lab@roark
  start_lab
  local lab
  lab=$(systemctl show -P MainPID arkmesh-lab@roark)
  systemctl kill --kill-whom=main -s KILL arkmesh-lab@roark
  standing
  later 180 robots walk
  [ "$(systemctl show -P NRestarts arkmesh-lab@roark)" -gt 0 ] || fail "the lab was not started again"
  [ "$(systemctl show -P MainPID arkmesh-lab@roark)" != "$lab" ] || fail "the lab is still the first one"
  [ -n "$(ls /run/lock/arkmesh-port-*)" ] || fail "the unit's lock is not where others see it"
}

upgrade_in_mid_run() { # step of a started system
  systemctl stop arkmesh-lab@roark
  start_lab
  local lab said
  lab=$(systemctl show -P MainPID arkmesh-lab@roark)
  said=$(apt-get install -y --no-install-recommends /packages/newer/*.deb 2>&1)
  echo "$said"
  said=$(grep 'before the upgrade' <<<"$said") || fail "the upgrade does not say that a lab runs"
  echo "says: $said"
  [[ $said == *"arkmesh-lab@roark"* ]] || fail "the lab is not named"
  [ "$(systemctl show -P MainPID arkmesh-lab@roark)" = "$lab" ] || fail "the lab was started anew"
  later 30 robots walk
  runuser -u arkmesh -- env HOME=/var/lib/arkmesh arkmesh pause /etc/arkmesh/roark.toml
  standing
  systemctl restart arkmesh-lab@roark
  later 180 robots walk
  [ "$(readlink /proc/"$(systemctl show -P MainPID arkmesh-lab@roark)"/exe)" = /usr/bin/arkmesh-testbed ] ||
    fail "a restarted lab has the program of before"
}

remove_all() { # step
  local command
  command=$(sed -n 's/^`sudo \(apt remove [^`]*\)`.*/\1 -y/p' /packages/install.md)
  eval "${command:?the page has no such command}"
  ! command -v arkmesh || fail "the command is still there"
  ! [ -d /run/systemd/system ] || ! systemctl -q is-active arkmesh-lab@roark || fail "a lab still runs"
  local folder file
  for folder in /usr/share/arkmesh /usr/lib/arkmesh; do [ ! -e $folder ] || fail "left behind: $(find $folder)"; done
  for file in /etc/arkmesh/shark.toml runs/dhtf/shark/result.json .config/arkmesh/keys/door.crt; do
    [ -f $file ] || fail "$file is gone"
  done
}

"$1"
