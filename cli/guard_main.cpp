// The program arkmesh-guard, which labs start for themselves: see StandGuard.
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>

#include "hal/platforms/kilobot/stand_guard.hpp"

int main(int argc, char** argv) {
  int word = -1, hung_ms = -1;
  if (argc == 4) {
    std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), word);
    std::from_chars(argv[3], argv[3] + std::strlen(argv[3]), hung_ms);
  }
  if (word < 0 || hung_ms < 0) {
    std::fputs(
        "A lab with real robots starts arkmesh-guard, which stops them when that lab has died or hangs. Do not start "
        "it by hand; to stop robots: arkmesh ohc PORT pause.\n",
        stderr);
    return 2;
  }
  return arkmesh::hal::kilobot::stand_guard(argv[1], word, std::chrono::milliseconds(hung_ms));
}
