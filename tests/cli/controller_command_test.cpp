// `arkmesh controller` as a user meets it: exit codes, the sentence of each failure, tables and pictures.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "hal/platforms/kilobot/intel_hex.hpp"
#include "tests/sim_ode/host/program_run.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

struct Ended {
  int code = -1;
  std::string output;  // standard output and error
};

Ended controller(std::vector<std::string> arguments, const std::filesystem::path& folder,
                 const std::string& arkmesh = ARKMESH_PROGRAM) {
  static int number = 0;
  arguments.insert(arguments.begin(), "controller");
  Process process(arkmesh, arguments, folder / fmt::format("output-{}.txt", ++number));
  const auto code = process.wait(std::chrono::seconds(300));
  return {code.value_or(-1), process.output()};
}

bool says(const Ended& ended, const std::string& part) {
  return ended.output.find(part) != std::string::npos;
}

std::string file(const std::string& name) {
  return program_file(name).string();
}

}  // namespace

TEST_CASE("controller run tells what the swarm did and leaves a table") {
  // Ten seconds of nine robots: 101 frames of nine rows and a header; a summary with each of its parts; exit code 0.
  const TemporaryFolder folder;
  const auto csv = folder.path() / "poses.csv";
  const Ended ended = controller(
      {"run", file("disperse_simple"), "--robots", "9", "--seconds", "10", "--arena", "0.3x0.4", "--csv", csv.string()},
      folder.path());
  INFO(ended.output);
  CHECK(ended.code == 0);
  for (const char* part :
       {"9 robots", "10.0 s simulated", "colours", "paths", "nearest", "messages", " sent", " heard"})
    CHECK_MESSAGE(says(ended, part), std::string(part));
  std::ifstream table(csv);
  std::string line;
  std::getline(table, line);
  CHECK(line == "time_s,robot,x_m,y_m,heading_rad,led");
  int rows = 0;
  for (; std::getline(table, line); ++rows) {
    std::istringstream fields(line);
    double time_s = -1, robot = -1, x_m = 9, y_m = 9;
    char comma = 0;
    fields >> time_s >> comma >> robot >> comma >> x_m >> comma >> y_m;
    CHECK(robot == rows % 9);
    CHECK(time_s == doctest::Approx(rows / 9 * 0.1));
    CHECK(std::abs(x_m) < 0.15);
    CHECK(std::abs(y_m) < 0.2);
  }
  CHECK(rows == 9 * 101);
}

TEST_CASE("controller run places obstacles and objects") {
  // The table has a row for the object in each frame, by its name; a robot that drives against it moves it.
  const TemporaryFolder folder;
  const auto csv = folder.path() / "poses.csv";
  const Ended ended = controller({"run", file("labs_drive_all"), "--robots", "1", "--seconds", "10", "--arena",
                                  "0.4x0.4", "--csv", csv.string(), "--set", "ode.start_poses=[-0.06,0,0]", "--set",
                                  "objects=[{name=\"puck\", shape=\"disc\", radius_m=0.03, mass_kg=0.02}]"},
                                 folder.path());
  INFO(ended.output);
  CHECK(ended.code == 0);
  std::ifstream table(csv);
  std::string line, last;
  int rows = 0;
  for (; std::getline(table, line); last = line)
    if (line.find(",puck,") != std::string::npos) ++rows;
  CHECK(rows == 101);
  CHECK(last.starts_with("10.0,puck,0.0"));
  CHECK_FALSE(last.starts_with("10.0,puck,0.00"));
}

TEST_CASE("controller run says in one sentence what is wrong with a program") {
  // Does not compile, crashes, never returns: exit code 1, and the last line names file and line or robot and time.
  const TemporaryFolder folder;
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"refused_syntax", {"refused_syntax.c:7", "error"}},
      {"refused_no_start", {"never calls kilo_start"}},
      {"crash_null", {"robot 3", "bad pointer", "crash_null.c:10"}},
      {"hang_loop", {"never returns", "hang_loop.c:9"}}};
  for (const auto& [program, parts] : cases) {
    const Ended ended = controller({"run", file(program), "--seconds", "10"}, folder.path());
    INFO(ended.output);
    CHECK(ended.code == 1);
    for (const std::string& part : parts) CHECK_MESSAGE(says(ended, part), part);
    const auto begin = ended.output.find("arkmesh: ");
    REQUIRE(begin != std::string::npos);
    CHECK(ended.output.find('\n', begin) == ended.output.size() - 1);
  }
}

TEST_CASE("controller run shows what robots print, and how much it does not show") {
  // Lines carry robot and time and are complete, also when they are printed bit by bit; --text bounds them and says so;
  // a crash comes after the robot's last words; progress counts seconds.
  const TemporaryFolder folder;
  const auto program = folder.path() / "chatter.c";
  std::ofstream(program) << R"(#define DEBUG
#include <kilolib.h>
#include <debug.h>
int n, zero;
void setup() { debug_init(); printf("robot %d ", kilo_uid); printf("is %s\r\n", "here"); }
void loop() {
  printf("line %d\n", ++n);
  if (n == 8 && kilo_uid == 1) { printf("last words"); n /= zero; }
  delay(1000);
}
int main() { kilo_init(); kilo_start(setup, loop); return 0; }
)";
  const Ended all = controller({"run", program.string(), "--robots", "2", "--seconds", "5"}, folder.path());
  INFO(all.output);
  CHECK(all.code == 0);
  for (const char* part : {"robot 0: robot 0 is here\n", "robot 1: robot 1 is here\n", "robot 0: line 5\n",
                           "robot 1: line 5\n", "second "})
    CHECK_MESSAGE(says(all, part), std::string(part));
  CHECK_FALSE(says(all, "not shown"));
  const Ended some =
      controller({"run", program.string(), "--robots", "2", "--seconds", "5", "--text", "2"}, folder.path());
  CHECK(says(some, "robot 1: line 1\n"));
  CHECK_FALSE(says(some, "line 2\n"));
  CHECK_MESSAGE(says(some, "8 more lines not shown"), some.output);
  const Ended crashed = controller({"run", program.string(), "--robots", "2", "--seconds", "20"}, folder.path());
  CHECK(crashed.code == 1);
  const auto words = crashed.output.find("robot 1: last words\n"), fault = crashed.output.find("division by zero");
  CHECK_MESSAGE(words < fault, crashed.output);
  CHECK(fault != std::string::npos);
}

TEST_CASE("an installed program brings along what it compiles against") {
  // Beside bin/arkmesh lies share/arkmesh: run and check use the headers there, not those of the sources.
  const TemporaryFolder folder;
  const auto arkmesh = folder.path() / "bin" / "arkmesh", kilolib = folder.path() / "share" / "arkmesh" / "kilolib";
  std::filesystem::create_directories(arkmesh.parent_path());
  std::filesystem::create_directories(kilolib);
  std::filesystem::copy_file(ARKMESH_PROGRAM, arkmesh);
  std::filesystem::copy_file(ARKMESH_PROGRAM "-lab", arkmesh.string() + "-lab");
  std::filesystem::copy(std::filesystem::path(ARKMESH_SOURCE_DIR) / "sim_ode" / "kilolib", kilolib,
                        std::filesystem::copy_options::recursive);
  std::filesystem::copy(std::filesystem::path(ARKMESH_SOURCE_DIR) / "hal" / "platforms" / "kilobot" / "firmware",
                        kilolib.parent_path() / "firmware", std::filesystem::copy_options::recursive);
  std::filesystem::copy(std::filesystem::path(ARKMESH_SOURCE_DIR) / "sim_ode" / "silicon",
                        kilolib.parent_path() / "silicon");
  std::ofstream(kilolib / "kilolib.h", std::ios::app) << "#define INSTALLED_COPY 1\n";
  const auto program = folder.path() / "where.c";
  std::ofstream(program)
      << "#include <kilolib.h>\n#include <arkmesh_id.h>\n#ifndef INSTALLED_COPY\n#error the headers of the "
         "sources\n#endif\n"
         "void setup() {}\nvoid loop() {}\nint main() { kilo_init(); kilo_start(setup, loop); return 0; }\n";
  const Ended run = controller({"run", program.string(), "--seconds", "1"}, folder.path(), arkmesh.string());
  CHECK_MESSAGE(run.code == 0, run.output);
  CHECK(controller({"run", program.string(), "--seconds", "1"}, folder.path()).code == 1);
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) return;
  const Ended check = controller({"check", program.string()}, folder.path(), arkmesh.string());
  CHECK_MESSAGE(check.code == 0, check.output);
}

TEST_CASE("controller run ends cleanly with programs that would harm the process") {
  // An endless loop in main(), before any robot's time begins; variables that would fill the PC's memory; an empty
  // file.
  const TemporaryFolder folder;
  const std::string rest =
      "void setup() {}\nvoid loop() {}\nint main() { kilo_init(); kilo_start(setup, loop); return 0; }\n";
  const std::tuple<const char*, std::string, const char*> cases[] = {
      {"main_hangs.c", "#include <kilolib.h>\nvoid setup() {}\nvoid loop() {}\nint main() {\n  for (;;) {\n  }\n}\n",
       "never calls kilo_start(setup, loop); move to loop() what it repeats in main (main_hangs.c:5)"},
      {"large.c", "#include <kilolib.h>\nchar room[100000000];\n" + rest, "its variables take 100000"},
      {"empty.c", "", "undefined reference to `main'"}};
  for (const auto& [name, text, words] : cases) {
    std::ofstream(folder.path() / name) << text;
    const Ended ended =
        controller({"run", (folder.path() / name).string(), "--robots", "3", "--seconds", "5"}, folder.path());
    CHECK(ended.code == 1);
    CHECK_MESSAGE(says(ended, words), ended.output);
  }
}

TEST_CASE("controller run names who waits in loop for ever, and where") {
  // Robots 3 to 9 wait, for the clock or a message; the run goes on, for it may be what they should do. Nobody is told
  // of who shows that it works, or returns.
  const TemporaryFolder folder;
  const auto program = folder.path() / "waits.c";
  const auto run = [&](const std::string& loop) {
    std::ofstream(program)
        << "#include <kilolib.h>\nvolatile int flag = 0;\nvoid rx(message_t* m, "
           "distance_measurement_t* d) {}\nvoid setup() {}\nvoid loop() {\n"
        << loop << "\n}\nint main() { kilo_init(); kilo_message_rx = rx; kilo_start(setup, loop); return 0; }\n";
    return controller({"run", program.string(), "--robots", "10", "--seconds", "8"}, folder.path());
  };
  for (const char* wait : {"delay(100);", "while (!flag) {}", "while (kilo_ticks > 0) {}", "set_color(1);",
                           "set_motors(0, 0);", "if (get_ambientlight() > 2000) flag++;"}) {
    const Ended ended = run("  if (kilo_uid > 2)\n    for (;;) " + std::string(wait));
    CHECK(ended.code == 0);
    CHECK_MESSAGE(says(ended, "the program of robot 3 has not returned from loop"), ended.output);
    CHECK_MESSAGE(says(ended, "it waits in loop (waits.c:7)"), ended.output);
    CHECK_MESSAGE(says(ended, "so do 6 more robots"), ended.output);
    CHECK_MESSAGE(says(ended, "robots.waited 7"), ended.output);
  }
  for (const char* works : {"  for (;;) {\n    set_color(kilo_ticks & 1);\n    delay(100);\n  }", "  delay(1000);",
                            "  set_motors(70, 70);\n  while (!flag) {}"}) {
    const Ended ended = run(works);
    CHECK(ended.code == 0);
    CHECK_FALSE(says(ended, "has not returned"));
  }
}

TEST_CASE("controller refuses wrong use with exit code 2") {
  // A missing file, no file, nonsense for sizes and places, and more robots than fit.
  const TemporaryFolder folder;
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"run"},
      {"run", "no_such_file.c"},
      {"run", file("labs_blink"), "--arena", "1m"},
      {"run", file("labs_blink"), "--arena", "1x1x1"},
      {"run", file("labs_blink"), "--light", "here"},
      {"run", file("labs_blink"), "--seconds", "-1"},
      {"run", file("labs_blink"), "--robots", "0"},
      {"run", file("labs_blink"), "--arena", "0.05x0.05"},
      {"run", file("labs_blink"), "--csv", "/no/such/folder/poses.csv"},
      {"run", file("labs_blink"), "--png", "/no/such/folder/end.png"},
      {"run", file("labs_blink"), "--video", "/no/such/folder/run.mp4"},
      {"run", file("labs_blink"), "--text", "-1"},
      {"check", "no_such_file.c"}};
  for (const auto& arguments : wrong) {
    const Ended ended = controller(arguments, folder.path());
    INFO(ended.output);
    CHECK(ended.code == 2);
    CHECK_FALSE(ended.output.empty());
  }
  // keys of the arena are the arena's to judge
  CHECK(says(controller({"run", file("labs_blink"), "--set", "ode.preset=real"}, folder.path()),
             "must be one of \"ideal\", \"measured\""));
}

TEST_CASE("controller check says what a program needs and what may go wrong with an int of 16 bits") {
  // A program within the limits, one with too much memory, one with constants that do not fit, one that does not build.
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) {
    MESSAGE("avr-gcc is not installed: the build for the robot is not checked");
    return;
  }
  const TemporaryFolder folder;
  const std::string frame =
      "\nvoid setup() {{}}\nvoid loop() {{ {} }}\nint main() {{ kilo_init(); kilo_start(setup, loop); }}\n";
  const auto write = [&](const std::string& name, const std::string& text) {
    const auto path = folder.path() / name;
    std::ofstream(path) << text;
    return path.string();
  };
  const Ended good = controller({"check", file("gradient_hops")}, folder.path());
  CHECK(good.code == 0);
  CHECK_MESSAGE(says(good, "of 28160 bytes"), good.output);
  CHECK_FALSE(says(good, "warning"));

  const Ended large =
      controller({"check", write("large.c", "#include <kilolib.h>\nchar room[2000];" +
                                                fmt::format(fmt::runtime(frame), "room[kilo_uid] = 1;"))},
                 folder.path());
  CHECK(large.code == 1);
  CHECK_MESSAGE(says(large, "does not fit"), large.output);

  const Ended wide = controller(
      {"check", write("wide.c", "#include <kilolib.h>\n" +
                                    fmt::format(fmt::runtime(frame), "if (kilo_uid * 2 > 3) delay(60 * 1000);"))},
      folder.path());
  CHECK(wide.code == 0);
  CHECK_MESSAGE(says(wide, "warning: integer overflow"), wide.output);

  // What a PC, or a simulator, does not show: each with a control of the same shape.
  const auto said_of = [&](const std::string& globals, const std::string& loop) {
    return controller(
        {"check", write("width.c", "#include <kilolib.h>\n" + globals + fmt::format(fmt::runtime(frame), loop))},
        folder.path());
  };
  for (const auto& [globals, wrong, right, sentence] : std::vector<std::array<std::string, 4>>{
           {"int id; message_t m;", "id = m.data[0] << 8 | m.data[1];", "id = (m.data[0] & 3) << 8 | m.data[1];",
            "width.c:4: two bytes are shifted into an int"},
           {"int32_t id; message_t m;", "id = (m.data[0] << 8) + m.data[1];",
            "id = (uint16_t)(m.data[0] << 8 | m.data[1]);", "width.c:4: two bytes are shifted into an int"},
           {"int sum;", "int i; for (i = 0; i < 300; i++) { int light = get_ambientlight(); sum = sum + light; }",
            "int i; int32_t all = 0; for (i = 0; i < 300; i++) all += get_ambientlight(); sum = all / 300;",
            "readings, up to 1023 each, are summed in sum"},
           {"int part;", "part = get_ambientlight() * 100 / 1024;", "part = get_ambientlight() * 10 / 1024;",
            "times 100 exceeds 16 bits"},
           {"uint32_t calls;", "calls++; if (calls > 120000) set_color(1);", "calls++; if (calls > 20) set_color(1);",
            "calls counts calls of loop up to 120000"},
           {"uint32_t calls, last;", "calls++; if (calls > 5000) set_color(1);",
            "if (kilo_ticks > last) { last = kilo_ticks; calls++; } if (calls > 5000) set_color(1);", "calls of loop"},
           {"uint16_t last;", "if (last == -1) set_color(1);", "if (last == 65535) set_color(1);",
            "width.c:4: a negative number is compared with an unsigned one"},
           {"uint32_t last;", "if (kilo_uid < rand()) set_color(1);", "if (last == -1) set_color(1);",
            "width.c:4: a negative number is compared with an unsigned one"},
           {"int32_t late; uint16_t a, b;", "late = a - b;", "late = (int16_t)(a - b);",
            "width.c:4: an unsigned 16-bit difference is never negative"},
           {"#include <stdlib.h>\nchar *text; char room[9];", "text = malloc(9);", "text = room;",
            "malloc shares its memory with the stack"}}) {
    const Ended found = said_of(globals, wrong), control = said_of(globals, right);
    CHECK_MESSAGE(says(found, sentence), found.output);
    CHECK_MESSAGE(!says(control, sentence), control.output);
    CHECK(found.code == 0);
  }
  const Ended deep = said_of("void use(char *);\nvoid use(char *at) { *at = 1; set_color(*at); }",
                             "char room[3600]; use(room); set_motors(room[kilo_uid], 0);");
  CHECK(deep.code == 1);
  CHECK_MESSAGE(says(deep, "loop alone needs 36"), deep.output);
  CHECK_MESSAGE(says(deep, "remain for the stack"), deep.output);

  const Ended broken = controller({"check", file("refused_syntax")}, folder.path());
  CHECK(broken.code == 1);
  CHECK_MESSAGE(says(broken, "refused_syntax.c:7"), broken.output);
}

TEST_CASE("pictures and videos of a run, or a sentence that says what is missing") {
  // Where matplotlib and ffmpeg are there, files are written; where one is not, exit code 1 and the package to install.
  const TemporaryFolder folder;
  const auto png = folder.path() / "end.png", mp4 = folder.path() / "run.mp4";
  const Ended picture = controller({"run", file("labs_move"), "--seconds", "5", "--png", png.string()}, folder.path());
  INFO(picture.output);
  if (std::system("/usr/bin/python3 -c 'import matplotlib' > /dev/null 2>&1") != 0) {
    CHECK(picture.code == 1);
    CHECK(says(picture, "matplotlib for /usr/bin/python3 is missing"));
    return;
  }
  CHECK(picture.code == 0);
  CHECK(read_file(png).starts_with("\x89PNG"));
  const auto jpg = folder.path() / "end.jpg", odd = folder.path() / "end.txt";
  CHECK(controller({"run", file("labs_move"), "--seconds", "5", "--png", jpg.string()}, folder.path()).code == 0);
  CHECK(read_file(jpg).starts_with("\xFF\xD8\xFF"));
  for (const char* option : {"--png", "--video"}) {
    const Ended refused = controller({"run", file("labs_move"), "--seconds", "5", option, odd.string()}, folder.path());
    CHECK(refused.code == 1);
    CHECK_MESSAGE(says(refused, "give a name with one of these"), refused.output);
    CHECK_FALSE(std::filesystem::exists(odd));
  }
  const Ended video = controller({"run", file("labs_move"), "--seconds", "5", "--video", mp4.string()}, folder.path());
  INFO(video.output);
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) {
    CHECK(video.code == 1);
    CHECK(says(video, "ffmpeg, which writes videos, is missing; apt-get install ffmpeg"));
    return;
  }
  CHECK(video.code == 0);
  CHECK(read_file(mp4).substr(4, 4) == "ftyp");
}

TEST_CASE("controller build makes the file that robots are loaded with") {
  // A program and a library, as sources and as an archive, become an Intel HEX file of as many pages as are said; what
  // does not build or does not fit leaves none and ends with 1, a folder without a library with 2.
  if (std::system("avr-gcc --version > /dev/null 2>&1") != 0) {
    MESSAGE("avr-gcc is not installed: nothing is built for the robot");
    return;
  }
  const TemporaryFolder folder;
  const std::string kilolib = std::string(ARKMESH_SOURCE_DIR) + "/tests/data/stand_in_kilolib",
                    program = std::string(ARKMESH_SOURCE_DIR) + "/tests/sim_ode/controllers/firmware_table.c";
  const auto hex = folder.path() / "robot.hex";
  const auto build = [&](const std::string& source, const std::string& library) {
    std::filesystem::remove(hex);
    return controller({"build", source, "-o", hex.string(), "--kilolib", library}, folder.path());
  };
  const Ended built = build(program, kilolib);
  CHECK_MESSAGE(built.code == 0, built.output);
  CHECK_MESSAGE(says(built, "firmware_table.c: flash "), built.output);
  CHECK_MESSAGE(says(built, " of 28160 bytes, static RAM "), built.output);
  const hal::kilobot::Firmware firmware = hal::kilobot::read_intel_hex(hex);
  CHECK_MESSAGE(says(built, fmt::format("robot.hex: {} pages", firmware.pages())), built.output);
  CHECK(firmware.size_bytes() > 300);

  // an archive in the folder below the headers, as kilolib's Makefile leaves it
  const auto own = folder.path() / "kilolib";
  std::filesystem::create_directories(own / "build");
  for (const char* header : {"kilolib.h", "message.h"})
    std::filesystem::copy_file(std::filesystem::path(kilolib) / header, own / header);
  REQUIRE(std::system(fmt::format("cd {} && avr-gcc -mmcu=atmega328p -Os -c {}/kilolib.c {}/message_crc.c "
                                  "{}/message_send.S && avr-ar rcs build/kilolib.a *.o",
                                  own.string(), kilolib, kilolib, kilolib)
                          .c_str()) == 0);
  for (const auto& place : {own, own / "build" / "kilolib.a"}) {
    const Ended archived = build(program, place.string());
    CHECK_MESSAGE(archived.code == 0, archived.output);
    CHECK(hal::kilobot::read_intel_hex(hex).pages() > 0);
  }

  const Ended wrong = build(file("refused_syntax"), kilolib);
  CHECK(wrong.code == 1);
  CHECK_MESSAGE(says(wrong, "refused_syntax.c:"), wrong.output);
  CHECK_MESSAGE(says(wrong, "refused_syntax.c does not build for the robot, see above\n"), wrong.output);
  CHECK_FALSE(std::filesystem::exists(hex));

  const auto large = folder.path() / "large.c";
  std::ofstream(large) << "#include <kilolib.h>\nstatic uint8_t much[2100];\nvoid loop() { much[kilo_ticks]++; }\n"
                          "int main() { kilo_init(); kilo_start(loop, loop); return much[7]; }\n";
  const Ended full = build(large.string(), kilolib);
  CHECK(full.code == 1);
  CHECK_MESSAGE(says(full, "large.c does not fit on a robot; "), full.output);
  CHECK_FALSE(std::filesystem::exists(hex));

  const Ended none = build(program, folder.path().string());
  CHECK(none.code == 2);
  CHECK_MESSAGE(says(none, " is no kilolib: "), none.output);
}
