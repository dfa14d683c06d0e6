#include "app/live/live_view.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <numbers>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "app/live/count_history.hpp"
#include "app/live/emulator_link.hpp"
#include "app/live/frame_part.hpp"
#include "app/live/status_news.hpp"
#include "app/live/view_identity.hpp"
#include "hal/arenas/fault_port.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/files/own_files.hpp"
#include "hal/label.hpp"
#include "lab/status.hpp"

namespace arkmesh::app {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr auto last_words_within = 300ms, others_answer_within = 4000ms;
constexpr std::size_t max_fault_bytes = 300, max_said_bytes = 400, max_told = 16;

std::vector<std::string> certified(const view::ViewConfig& config) {
  std::vector<std::string> hosts = config.hosts;
  hosts.push_back(config.address);
  return hosts;
}

// A finite number, or nothing.
std::optional<double> number_in(const json& what, const char* name) {
  const auto found = what.find(name);
  if (found == what.end() || !found->is_number()) return {};
  return found->get<double>();
}

// Of what a viewer sent, which may be anything: "stop", "fault", ...; empty when it is none of ours.
std::string_view word_of(const json& what) {
  if (what.contains("fault")) return "fault";
  if (what.contains("move")) return "move";
  if (const auto name = "/command/name"_json_pointer; what.contains(name))
    for (const lab::OperatorWord& word : lab::operator_words)
      if (what[name] == word.name) return word.name;
  return {};
}

const json& wish_in(const json& what, const char* name) {
  const auto found = what.find(name);
  if (found == what.end() || !found->is_object()) throw std::runtime_error(fmt::format("'{}' must be an object", name));
  return *found;
}

// Before a robot's line on the emulator's control port: by the id that poses give it.
std::string robot_in(const json& wish) {
  const auto robot = number_in(wish, "robot");
  if (!robot || *robot < 0 || *robot > 4e9) throw std::runtime_error("'robot' must be a robot's number.");
  return fmt::format("robot id:{} ", static_cast<hal::RobotId>(*robot));
}

std::string line_of_move(const json& wish) {
  const auto x_m = number_in(wish, "x_m"), y_m = number_in(wish, "y_m"), heading_rad = number_in(wish, "heading_rad");
  if (!x_m || !y_m) throw std::runtime_error("'move' needs the numbers 'robot', 'x_m' and 'y_m'.");
  const std::string line = fmt::format("{}put {:.6f} {:.6f}", robot_in(wish), *x_m, *y_m);
  return heading_rad ? fmt::format("{} {:.3f}", line, *heading_rad * 180 / std::numbers::pi) : line;
}

std::string line_of_fault(const json& wish) {
  const auto found = wish.find("line");
  const std::string line = found != wish.end() && found->is_string() ? found->get<std::string>() : std::string();
  if (line.empty() || line.size() > max_fault_bytes || hal::printable(line, max_fault_bytes) != line)
    throw std::runtime_error("'fault' needs a 'line' as on the emulator's control port.");
  return wish.contains("robot") ? robot_in(wish) + line : line;
}

}  // namespace

// Of one lab: its bus, its pictures, and lines of its event log, from its status once a second.
class LiveView::Eye final : public hal::PictureWatcher {
 public:
  Eye(hal::EventLoop& loop, view::Server& server, int number, ConfiguredLab& lab)
      : server_(server),
        number_(number),
        lab_(lab),
        near_(dynamic_cast<hal::FaultPort*>(&lab.arena())),
        heard_(lab.bus().subscribe(".*", [this](auto channel, auto bytes) {
          // Once a period.
          if (channel == hal::channel::shared) history_.note(now_us(), lab_.runner().lab().counts());
          // Viewers have the status from refresh(), with another speed.
          const bool is_status = channel == hal::channel::status;
          if (!is_status || server_.viewers() == 0)
            server_.show(number_, now_us(), channel, bytes, frame_part(channel, bytes).value_or(FramePart{}).part);
          if (!is_status) return;
          for (const std::string& line : news_.read(bytes)) tell(line);
        })) {
    if (const auto to = view::endpoint_of(lab.view().emulator)) far_.emplace(loop, *to);
    lab_.pictures().attach(this);
  }
  ~Eye() override { lab_.pictures().attach(nullptr); }
  Eye(const Eye&) = delete;

  bool wants_pictures() const override { return server_.viewers() > 0; }
  void set_frame(const hal::PictureFrame& frame) override {
    server_.set_camera(number_, {{"name", frame.camera},
                                 {"width_px", frame.width_px},
                                 {"height_px", frame.height_px},
                                 {"arena_to_px", frame.arena_to_px}});
  }
  void show_picture(const std::string& camera, hal::LabTime at, std::span<const std::byte> jpeg) override {
    server_.show_picture(number_, at.count(), camera, jpeg);
  }
  // Before the run there is no table.
  void audit_refused(std::string_view command, std::string_view why) {
    if (!lab_.has_run()) return;
    if (!audit_) audit_.emplace(lab_.command_audit());
    audit_->note({}, command, why);
  }
  void tell(std::string_view text) { server_.tell(number_, now_us(), text); }
  json series() const { return history_.series(lab_.name()); }
  bool has_emulator() const { return near_ || far_; }
  // As EmulatorLink::ask, of an emulated testbed in this process or elsewhere.
  void ask_emulator(const std::string& line, EmulatorLink::Heard heard) {
    if (near_) return heard(near_->fault(line));
    if (far_) return far_->ask(line, std::move(heard));
    heard(fmt::format("error: {} has no emulated testbed (arena.use = \"emulated\", or view.emulator)", lab_.name()));
  }
  void show_status() {
    if (!lab_.has_run()) return;
    lab_status_t status = lab::status_of(lab_.runner());
    status.speed = speed_now();
    std::vector<std::byte> bytes(static_cast<std::size_t>(status.getEncodedSize()));
    status.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    server_.show(number_, now_us(), hal::channel::status, bytes);
  }

 private:
  std::int64_t now_us() const { return lab_.arena().clock().now().count(); }
  // Lab time in a second of wall time, lately or since it was asked last: labs in one process know steps only.
  double speed_now() {
    const hal::TimePoint now = hal::TimePoint::clock::now();
    const double wall_s = std::chrono::duration<double>(now - speed_since_).count();
    if (wall_s < 0.4) return speed_;
    speed_since_ = now;
    return speed_ = static_cast<double>(now_us() - std::exchange(speed_from_us_, now_us())) * 1e-6 / wall_s;
  }

  view::Server& server_;
  const int number_;
  ConfiguredLab& lab_;
  hal::FaultPort* const near_;
  std::optional<EmulatorLink> far_;
  hal::TimePoint speed_since_ = hal::TimePoint::clock::now();
  std::int64_t speed_from_us_ = 0;
  double speed_ = 0;
  StatusNews news_;
  CountHistory history_;
  std::optional<lab::CommandAudit> audit_;  // with a limit of its own: strangers leave room for what the lab refuses
  std::unique_ptr<hal::Bus::Subscription> heard_;
};

std::unique_ptr<LiveView> LiveView::make(hal::EventLoop& loop, const std::vector<ConfiguredLab*>& labs,
                                         std::string run) {
  const ConfiguredLab& first = *labs.front();
  const view::ViewConfig& config = first.view();
  if (!config.use) return nullptr;
  view::ServerOptions options{.address = config.address,
                              .port = config.port,
                              .hosts = config.hosts,
                              .per_s = config.per_s,
                              .max_viewers = config.viewers};
  if (!view::is_loopback(config.address)) options.identity = view_identity(first.name(), certified(config));
  try {
    return std::unique_ptr<LiveView>(new LiveView(loop, config, std::move(options), labs, std::move(run)));
  } catch (const std::runtime_error& error) {
    spdlog::warn("there is no page for browsers: {}", error.what());
    return nullptr;
  }
}

LiveView::LiveView(hal::EventLoop& loop, const view::ViewConfig& config, view::ServerOptions options,
                   const std::vector<ConfiguredLab*>& labs, std::string run)
    : labs_(labs), run_(std::move(run)), control_(config.control), server_(loop, std::move(options), *this) {
  if (server_.port() != config.port)
    spdlog::info("TCP port {} is taken; the page is at {}", config.port, server_.port());
  for (std::size_t i = 0; i < labs_.size(); ++i)
    eyes_.push_back(std::make_unique<Eye>(loop, server_, static_cast<int>(i), *labs_[i]));
  // People know beforehand whom STOP of all labs passes by.
  statuses_ = labs_.front()->bus().subscribe("[^/]+/status", [this](std::string_view channel, auto bytes) {
    const std::string lab(channel.substr(0, channel.find('/'))), &own = labs_.front()->name();
    lab_status_t status;
    if (!is_elsewhere(lab) || !hal::read_message(bytes, status).empty()) return;
    const bool obeys = std::ranges::count(status.obeys, own) > 0;
    if (std::exchange(obeys_.try_emplace(lab, true).first->second, obeys) == obeys) return;
    eyes_.front()->tell(obeys ? fmt::format("{} now accepts commands from {}'s operator", lab, own)
                              : "STOP of all labs does not reach every lab: " + lab::not_obeyed(lab, own));
  });
}

LiveView::~LiveView() {
  if (labs_.front()->has_run()) labs_.front()->runner().count_page(nullptr);
}

void LiveView::count() {
  labs_.front()->runner().count_page(this);
}

std::string LiveView::url() const {
  return control_ ? server_.url_with_token() : server_.url();
}

void LiveView::finish(hal::LoopTime& time) {
  // Others have yet to hear, and to answer, what this lab may have ended by.
  for (const auto until = time.now() + others_answer_within; !told_.empty() && time.now() < until; hear_others())
    time.wait_for_anything(time.now() + 20ms);
  refresh();
  server_.sample();
  for (const auto until = time.now() + last_words_within; server_.sending() && time.now() < until;)
    time.wait_for_anything(until);
}

json LiveView::about() {
  json names = json::array(), emulators = json::array();
  for (const ConfiguredLab* const lab : labs_) names.push_back(lab->name());
  for (const auto& eye : eyes_) emulators.push_back(eye->has_emulator());
  json about = {{"mode", "live"}, {"labs", names},  {"control", control_},
                {"run", run_},    {"folder", run_}, {"emulator", emulators}};
  for (const std::string& lab : labs_.front()->config().absent)
    about["notes"].push_back(fmt::format("{} of shared.labs does not take part", lab));
  return about;
}

void LiveView::request(const json& what, view::Answer& answer) {
  if (what.contains("series")) {
    json all = json::array();
    for (const auto& eye : eyes_)
      for (json& one : eye->series()) all.push_back(std::move(one));
    if (!answer.done({{"series", all}})) answer.refuse("the curves cannot be sent now; try again later");
    return;
  }
  answer.refuse("This lab is running; to see earlier moments, open its run folder: arkmesh view FOLDER.");
}

// One of the shared world that another process runs.
bool LiveView::is_elsewhere(const std::string& lab) const {
  const lab::RunConfig& config = labs_.front()->config();
  return std::ranges::count(config.labs, lab) > 0 && std::ranges::count(config.absent, lab) == 0 &&
         std::ranges::find(labs_, lab, &ConfiguredLab::name) == labs_.end();
}

void LiveView::tell_others(std::string_view word) {
  const ConfiguredLab& own = *labs_.front();
  for (const std::string& lab : own.config().labs) {
    if (!is_elsewhere(lab) || told_.size() >= max_told) continue;
    try {
      told_.emplace_back(
          hal::ChildStart{.command = {hal::this_program().string(), std::string(word), "--at", lab, own.file(), "--set",
                                      "bus.url=" + json(own.bus_config().url).dump(), "--set",
                                      "gateway.keys=" + json(own.gateway().keys.string()).dump()},
                          .last_signal = SIGTERM});
    } catch (const std::runtime_error& error) {
      eyes_.front()->tell(fmt::format("not sent to {}: {}", lab, error.what()));
    }
  }
}

void LiveView::hear_others() {
  std::erase_if(told_, [this](Told& each) {
    const bool ended = each.process.end().has_value();
    each.process.read(each.said);
    if (!ended) return false;
    std::istringstream lines(each.said);
    for (std::string line; std::getline(lines, line);) eyes_.front()->tell(hal::printable(line, max_said_bytes));
    return true;
  });
}

void LiveView::refresh() {
  hear_others();
  for (const auto& eye : eyes_) eye->show_status();
}

void LiveView::command(const json& what, view::Answer& answer) try {
  if (!control_)
    return refuse(what, "no_control", "This lab takes no commands from its page: view.control is false.", answer);
  if (!what.contains("command")) return to_emulator(what, answer);
  const json& command = wish_in(what, "command");
  const auto name = command.find("name");
  for (const lab::OperatorWord& word : lab::operator_words) {
    if (name == command.end() || !name->is_string() || name->get_ref<const std::string&>() != word.name) continue;
    if (const std::string why = perform(command, word); !why.empty()) return answer.refuse(why);
    answer.done();
    return;
  }
  refuse(what, "unknown", "Unknown command; commands are stop, pause, resume, reset, arm and disarm.", answer);
} catch (const std::runtime_error&) {
  refused(what, "unknown", {});
  throw;
}

void LiveView::refused(const json& what, std::string_view why, const std::string& from) {
  std::size_t lab = 0;
  for (const char* const member : {"command", "fault", "move"})
    if (what.contains(member) && what[member].is_object() && what[member].contains("lab"))
      if (const json& number = what[member]["lab"]; number.is_number_unsigned() && number < labs_.size())
        lab = number.get<std::size_t>();
  eyes_[lab]->audit_refused(word_of(what), from.empty() ? std::string(why) : fmt::format("{} from {}", why, from));
}

void LiveView::refuse(const json& what, std::string_view reason, std::string_view why, view::Answer& answer) {
  refused(what, reason, {});
  answer.refuse(why);
}

// Of labs_ and eyes_.
std::size_t LiveView::lab_of(const json& what) const {
  const auto number = what.find("lab");
  if (number == what.end() && labs_.size() == 1) return 0;
  if (number == what.end() || !number->is_number_unsigned() || *number >= labs_.size())
    throw std::runtime_error("Unknown lab; 'lab' is its number in the list of labs, from 0.");
  return number->get<std::size_t>();
}

// Without a lab it is for all. Returns why it was refused.
std::string LiveView::perform(const json& what, const lab::OperatorWord& word) {
  std::string refused;
  if (!what.contains("lab") && word.at_others) tell_others(word.name);
  for (std::size_t i = 0; i < labs_.size(); ++i) {
    if (what.contains("lab") && lab_of(what) != i) continue;
    const std::string why =
        labs_[i]->has_run() ? labs_[i]->runner().perform(word.command) : "the lab has not started yet";
    eyes_[i]->tell(fmt::format("on the page: {}{}", word.name, why.empty() ? "" : ", refused: " + why));
    if (!why.empty()) refused += (refused.empty() ? "" : "; ") + labs_[i]->name() + ": " + why;
  }
  return refused;
}

void LiveView::to_emulator(const json& what, view::Answer& answer) {
  const bool moves = what.contains("move");
  const json& wish = wish_in(what, moves ? "move" : "fault");
  Eye& eye = *eyes_[lab_of(wish)];
  const std::string line = moves ? line_of_move(wish) : line_of_fault(wish);
  eye.ask_emulator(line, [&eye, line, answer](const std::string& heard) mutable {
    const std::string said = hal::printable(heard, max_said_bytes);
    eye.tell(fmt::format("at the emulator: {}: {}", line, said));
    if (said.starts_with("error: ")) return answer.refuse(said.substr(7));
    answer.done({{"text", said}});
  });
}

}  // namespace arkmesh::app
