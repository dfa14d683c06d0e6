// That robots' programs build for the robot itself.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace arkmesh::scenarios {

// The very files of the simulator (paths within the project) compile with avr-gcc, without a warning, and leave nearly
// all of the robot's memory free. Says so where there is no avr-gcc.
inline void check_builds_for_robot(const std::vector<std::string>& files) {
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) {
    MESSAGE("avr-gcc is not installed: the build for the robot is not checked");
    return;
  }
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("arkmesh-avr-{}", ::getpid());
  std::filesystem::create_directories(folder);
  for (const std::string& file : files) {
    INFO(file);
    const std::string object = folder / "robot.o", size = folder / "size.txt";
    const std::string compile = fmt::format(
        "avr-gcc -mmcu=atmega328p -std=gnu99 -Os -funsigned-char -fpack-struct -fshort-enums -Wall -Wextra -Werror "
        "-I{0}/sim_ode/kilolib -I{0}/hal/platforms/kilobot/firmware -c {0}/{1} -o {2}",
        ARKMESH_SOURCE_DIR, file, object);
    REQUIRE(std::system(compile.c_str()) == 0);
    REQUIRE(std::system(fmt::format("avr-size {} > {}", object, size).c_str()) == 0);
    std::ifstream in(size);
    std::string header;
    std::getline(in, header);
    int text = 0, data = 0, bss = 0;
    in >> text >> data >> bss;
    CHECK(text > 100);
    CHECK(text < 4096);       // of 28160 bytes of flash
    CHECK(data + bss < 128);  // of 2048 bytes of RAM
  }
  std::filesystem::remove_all(folder);
}

}  // namespace arkmesh::scenarios
