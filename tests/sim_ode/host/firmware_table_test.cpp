// The rows of firmware_table.txt, run by the simulator. tests/firmware/firmware_table runs the same rows on a real
// kilolib.
#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "hal/overlay/led_name.hpp"
#include "sim_ode/host/robot_host.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

struct TableRow {
  std::vector<std::string> steps;
  std::string motors, led, program;
};

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? std::string{} : text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

std::vector<TableRow> table_rows() {
  std::ifstream file(std::string(ARKMESH_SOURCE_DIR) + "/tests/sim_ode/host/firmware_table.txt");
  std::vector<TableRow> out;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream parts(line);
    std::string steps;
    TableRow row;
    std::getline(parts, steps, '|');
    std::getline(parts, row.motors, '|');
    std::getline(parts, row.led, '|');
    std::getline(parts, row.program);
    std::istringstream words(steps);
    for (std::string word; words >> word;) row.steps.push_back(word);
    row.motors = trimmed(row.motors);
    row.led = trimmed(row.led);
    row.program = trimmed(row.program);
    out.push_back(row);
  }
  return out;
}

// One robot, and what an observer sees of it.
class TableRobot {
 public:
  explicit TableRobot(const std::shared_ptr<const RobotProgram>& program)
      : motors_({.speed_spread = 0, .duty_spread = 0}, 1, "shark", 1),
        leds_(1),
        host_(program, 1, motors_, leds_, {}, "shark", 1, {5}) {}

  void step(const std::string& step) {
    const std::size_t colon = step.find(':');
    const std::string name = step.substr(0, colon);
    std::array<int, 4> values{};
    if (colon != std::string::npos) {
      std::istringstream list(step.substr(colon + 1));
      std::size_t k = 0;
      for (std::string value; std::getline(list, value, ',');) values.at(k++) = std::stoi(value);
    }
    if (name == "wait") return run_for(values[0]);
    const bool repeated = name.back() == '*';
    if (name == "page") {
      for (int word = 0; word < 64; word += 3) tick(message(type_boot_page, {values[0], word}));
    } else if (repeated) {
      for (int i = 0; i < 275; ++i) tick(message_for(name.substr(0, name.size() - 1), values));
    } else {
      tick(message_for(name, values));
    }
    run_for(300);
  }

  std::string led() const {
    std::vector<hal::Led> seen;
    leds_.look(0, seen);
    return std::string(hal::name_of(seen[0]));
  }
  // The duties, of those in question, that its motion is that of.
  bool drives(int left, int right) const {
    const Velocity want = motors_.velocity(0, static_cast<std::uint8_t>(left), static_cast<std::uint8_t>(right));
    return now_.ahead_m_s == want.ahead_m_s && now_.left_m_s == want.left_m_s && now_.turn_rad_s == want.turn_rad_s;
  }
  // How often setup has run, by the message that the library asks the program for within 17 ticks; 0: it does not.
  int setups() {
    setups_ = 0;
    run_for(17 * 33);
    return setups_;
  }

 private:
  static Message message(int type, std::initializer_list<int> data = {}) {
    Message out;
    out.type = static_cast<std::uint8_t>(type);
    std::size_t k = 0;
    for (int byte : data) out.data[k++] = static_cast<std::uint8_t>(byte);
    return out;
  }
  static Message message_for(const std::string& name, const std::array<int, 4>& v) {
    if (name == "run") return message(type_run);
    if (name == "pause") return message(type_wakeup);
    if (name == "sleep") return message(type_sleep);
    if (name == "charge") return message(type_charge);
    if (name == "voltage") return message(type_voltage);
    if (name == "reset") return message(type_reset);
    if (name == "boot") return message(type_boot);
    if (name == "other") return message(200);
    if (name == "bit") return message(type_read_uid, {v[0]});
    if (name == "id") return message(type_calibrate, {1, v[0], v[0] >> 8});
    if (name == "left") return message(type_calibrate, {2, 0, 0, v[0]});
    if (name == "right") return message(type_calibrate, {3, 0, 0, 0, v[0]});
    if (name == "straight") return message(type_calibrate, {4, 0, 0, 0, 0, v[0], v[1]});
    if (name == "mode") return message(type_calibrate, {v[0]});
    if (name == "save") return message(type_calibrate);
    if (name == "size") return message(type_boot_size, {v[0]});
    if (name == "colour") return message(1, {v[0]});
    if (name == "drive") return message(2, {v[0], v[1]});
    if (name == "job") return message(3, {v[0], v[1], v[2], v[3]});
    if (name == "setup") return message(4, {v[0]});
    throw std::runtime_error("no step: " + name);
  }

  void run_for(int ms) {
    for (std::int64_t us = 0; us < ms * 1000; us += tick_us) tick({});
  }
  void tick(const std::optional<Message>& heard) {
    Inbox inbox;
    if (heard) inbox.overhead.push_back({.message = *heard, .missed = {}});
    host_.tick(++tick_, inbox);
    for (std::size_t i = 0; i < host_.offers().size(); ++i)
      if (const Reply reply = host_.send_turn({.robot = 0, .channel = Outcome::Channel::free}); reply.message)
        setups_ = reply.message->data[0];
    for (const Motors::Change& change : motors_.end_tick()) now_ = change.velocity;
    leds_.end_tick();
  }

  Motors motors_;
  LedLights leds_;
  RobotHost host_;
  std::int64_t tick_ = 0;
  Velocity now_;
  int setups_ = 0;
};

}  // namespace

TEST_CASE("firmware table") {
  // Each row's steps lead to the motors, the LED and the program that it says.
  const std::vector<TableRow> rows = table_rows();
  CHECK(rows.size() > 100);
  const auto program = RobotProgram::load(controller("firmware_table.c"));
  for (const TableRow& row : rows) {
    TableRobot robot(program);
    std::string steps;
    for (const std::string& step : row.steps) {
      steps += step + ' ';
      robot.step(step);
    }
    CAPTURE(steps);
    int left = -1, right = -1;
    std::istringstream(row.motors) >> left >> right;
    CHECK_MESSAGE(robot.drives(left, right), "motors: ", row.motors);
    CHECK(robot.led() == row.led);
    CHECK(robot.setups() == (row.program == "runs" ? 1 : 0));
  }
}

}  // namespace arkmesh::sim_ode
