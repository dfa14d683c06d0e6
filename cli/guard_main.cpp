// The program arkmesh-guard, which labs start for themselves: see StandGuard.
#include <charconv>
#include <cstdio>
#include <cstring>

#include "hal/platforms/kilobot/stand_guard.hpp"

int main(int argc, char** argv) {
  int word = -1;
  if (argc == 3) std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), word);
  if (word < 0) {
    std::fputs(
        "arkmesh-guard is started by a lab with real robots, and tells them to stand when that lab is gone. It is not "
        "started by hand: robots are told to stand with arkmesh ohc PORT pause.\n",
        stderr);
    return 2;
  }
  return arkmesh::hal::kilobot::stand_guard(argv[1], word);
}
