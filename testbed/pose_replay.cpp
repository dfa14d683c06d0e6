#include "testbed/pose_replay.hpp"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "hal/counted.hpp"
#include "testbed/arena_monitor.hpp"
#include "tracker/camera/jpeg_stream.hpp"

namespace arkmesh::testbed {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t largest_file = 64u << 20;
constexpr std::int64_t most_pixels = 64ll << 20;

// Empty when it is no picture, or one of a size that no camera has.
cv::Mat recorded_picture(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error || bytes == 0 || bytes > largest_file) return {};
  std::vector<std::uint8_t> all(bytes);
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(all.data()), static_cast<std::streamsize>(bytes))) return {};
  const auto size = picture_size(all);
  if (!size || std::int64_t{size->first} * size->second > most_pixels) return {};
  if (file.extension() == ".jpg") return tracker::decode_jpeg(all);
  try {
    return cv::imdecode(all, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace

// What each camera shows at this look.
struct PoseReplay::Pictures {
  std::vector<cv::Mat> newest;
  std::vector<hal::LabTime> age;

  class Feed final : public tracker::CameraFeed {
   public:
    Feed(Pictures& pictures, std::size_t camera) : pictures_(pictures), camera_(camera) {}
    cv::Mat newest() override { return std::exchange(pictures_.newest[camera_], cv::Mat()); }
    tracker::Arrival arrival() const override { return {.age = pictures_.age[camera_], .jpeg = {}}; }
    std::string error() const override { return {}; }
    hal::Counters counters() const override { return {}; }

   private:
    Pictures& pictures_;
    std::size_t camera_;
  };
};

PoseReplay::PoseReplay(fs::path folder, const KilobotSettings& settings)
    : folder_(std::move(folder)),
      file_(folder_ / looks_file),
      lines_(file_, (folder_ / looks_file).string()),
      pictures_(std::make_unique<Pictures>()) {
  pictures_->newest.resize(settings.cameras.size());
  pictures_->age.resize(settings.cameras.size());
  const auto open = [this, next = std::size_t{0}](const tracker::CameraRequest&) mutable {
    return std::make_unique<Pictures::Feed>(*pictures_, next++);
  };
  eyes_ = make_arena_monitor(settings, {}, open);
}

PoseReplay::~PoseReplay() = default;

std::optional<PoseReplay::Seen> PoseReplay::next() {
  if (!ended_by_.empty()) return {};
  std::optional<LookLine> look = std::exchange(ahead_, std::nullopt);
  std::optional<FrameLine> taken;
  while (auto line = lines_.next()) {
    if (auto* const frame = std::get_if<FrameLine>(&*line)) {
      if (look && !taken) taken = *frame;
      continue;
    }
    if (look) {
      ahead_ = std::move(std::get<LookLine>(*line));
      break;
    }
    look = std::move(std::get<LookLine>(*line));
  }
  if (!look || !show(*look)) return {};
  eyes_->look(look->now);
  return Seen{look->now, taken, eyes_->latest()};
}

bool PoseReplay::show(const LookLine& look) {
  if (look.camera.size() != pictures_->newest.size())
    throw RecordError(fmt::format("{} is of {}, but the lab's file names {}", (folder_ / looks_file).string(),
                                  hal::counted(look.camera.size(), "camera"), pictures_->newest.size()));
  for (std::size_t i = 0; i < look.camera.size(); ++i) {
    const LookedAt& seen = look.camera[i];
    if (seen.what == LookedAt::What::nothing) continue;
    const fs::path file = folder_ / camera_folder(i) / seen.file;
    if (seen.what == LookedAt::What::picture) pictures_->newest[i] = recorded_picture(file);
    pictures_->age[i] = hal::LabTime{look.time_us - seen.arrived_us};
    if (!pictures_->newest[i].empty()) continue;
    ended_by_ = seen.what == LookedAt::What::lost ? fmt::format("a picture of camera {} was not recorded", i)
                                                  : fmt::format("{} is missing or damaged", file.string());
    ended_by_ += fmt::format(", {:.1f} s after the arena was made", std::chrono::duration<double>(look.now).count());
    return false;
  }
  return true;
}

}  // namespace arkmesh::testbed
