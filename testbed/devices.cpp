#include "testbed/devices.hpp"

#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"
#include "hal/time/loop_time.hpp"
#include "testbed/aseba_row.hpp"
#include "testbed/kilobot_settings.hpp"
#include "tracker/camera/live_camera.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::testbed {
namespace {

namespace fs = std::filesystem;
using hal::Finding;
using namespace std::chrono_literals;

constexpr std::chrono::seconds answers_within = 8s;
constexpr std::chrono::milliseconds settle_pause = 10ms;

// Until the device has answered, or had its time.
void wait_until(const std::function<bool()>& answered) {
  hal::EventLoop loop;
  hal::LoopTime time(loop);
  for (const hal::TimePoint end = time.now() + answers_within; !answered() && time.now() < end;)
    time.wait_until(time.now() + settle_pause);
}

Finding controller(const std::string& port) {
  Finding finding{"overhead controller " + port, "",
                  "try arkmesh ohc PORT lamp; arkmesh doctor lists the serial ports"};
  try {
    const std::unique_ptr<hal::kilobot::ByteStream> stream = hal::kilobot::claim_byte_stream(port, "arkmesh doctor");
    stream->open();
    auto state = hal::kilobot::ByteStream::State::opening;
    wait_until([&] { return (state = stream->check()) != hal::kilobot::ByteStream::State::opening; });
    if (state == hal::kilobot::ByteStream::State::open) return finding;
    finding.problem =
        stream->error().empty() ? fmt::format("no answer for {} s", answers_within.count()) : stream->error();
  } catch (const std::exception& wrong) {
    finding.problem = wrong.what();
  }
  return finding;
}

// Whether messages in the lab's layout can name all of its robots.
Finding ids(const hal::Section& arena) {
  Finding finding{"ids of the robots", "", "correct the lab's file"};
  try {
    const hal::kilobot::WordLayout layout = hal::kilobot::read_layout(arena);
    finding.what += ", in layout " + name_of(layout);
    hal::kilobot::read_robot_ids(arena, layout);
  } catch (const hal::ConfigError& wrong) {
    finding.problem = wrong.what();
  }
  return finding;
}

}  // namespace

Finding find_camera(const CameraSettings& settings, std::size_t number, std::size_t all) {
  const std::string& source = settings.source;
  const fs::path& calibration = settings.calibration;
  Finding finding{"camera " + source, "", "look at it with: arkmesh track " + source + " --serve 8095"};
  try {
    if (tracker::source_kind(source) == tracker::SourceKind::recording)
      throw std::runtime_error("is not a camera's number, device or URL");
    tracker::Lens lens;  // 0 x 0 pixels: any
    std::string no_calibration = calibration.empty() ? "has no calibration in the lab's file" : "";
    try {
      if (!calibration.empty()) lens = read_calibration_of(settings, number, all).data.lens;
    } catch (const std::runtime_error& wrong) {
      no_calibration = wrong.what();
    }
    const auto feed = tracker::open_camera({source, lens.width_px, lens.height_px, settings.controls});
    cv::Mat picture;
    wait_until([&] { return !(picture = feed->newest()).empty(); });
    if (picture.empty()) throw std::runtime_error(feed->error());
    finding.what += fmt::format(", {} x {} pixels", picture.cols, picture.rows);
    finding.remedy = "calibrate it with: arkmesh calibrate";
    if (!no_calibration.empty()) throw std::runtime_error(no_calibration);
    if (lens.width_px != picture.cols || lens.height_px != picture.rows)
      finding.problem = fmt::format("its calibration {} is for pictures of {} x {} pixels", calibration.string(),
                                    lens.width_px, lens.height_px);
  } catch (const std::exception& wrong) {
    finding.problem = wrong.what();
  }
  return finding;
}

std::vector<hal::Finding> find_devices(const hal::Section& arena) {
  if (arena.get("use", std::string()) == "aseba") return find_nodes(arena);
  const hal::Section kilobot = arena.section("kilobot");
  std::vector<Finding> findings{ids(arena), controller(kilobot.get("port", std::string(), {.required = true}))};
  const std::vector<CameraSettings> all = read_cameras(kilobot);
  for (std::size_t i = 0; i < all.size(); ++i) findings.push_back(find_camera(all[i], i, all.size()));
  return findings;
}

}  // namespace arkmesh::testbed
