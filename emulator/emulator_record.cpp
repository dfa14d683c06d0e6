#include "emulator/emulator_record.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/jpeg_video.hpp"
#include "tracker/camera/landmarks.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::emulator {
namespace {

constexpr const char* led_names[] = {"off", "red", "green", "yellow", "blue", "magenta", "cyan", "white"};

// "out.mp4" for one camera, "out-NAME.mp4" for several.
std::string name_for(const Emulator& emulator, std::size_t camera, const std::string& file) {
  if (emulator.cameras() == 1) return file;
  const std::filesystem::path path(file);
  return (path.parent_path() /
          (path.stem().string() + "-" + emulator.camera(camera).settings().name + path.extension().string()))
      .string();
}

}  // namespace

struct EmulatorRecord::Video {
  std::optional<tracker::JpegVideo> jpegs;  // of .avi
  cv::VideoWriter mp4;                      // of all others
};

EmulatorRecord::EmulatorRecord(const Emulator& emulator, const std::string& truth, const std::string& video)
    : truth_name_(truth) {
  if (!truth.empty()) {
    truth_.open(truth);
    truth_ << "time_s,robot,id,x_m,y_m,heading_rad,led,in_arena\n";
    if (!truth_.flush())
      throw std::runtime_error(fmt::format(
          "cannot write the truth to {}; does the folder exist, and does the disk have free space?", truth));
  }
  if (video.empty()) return;
  const std::string kind = std::filesystem::path(video).extension().string();
  if (kind != ".avi" && kind != ".mp4")
    throw std::runtime_error(fmt::format("{}: a video's name must end in .avi or .mp4", video));
  const double frames_per_s = 1e6 / static_cast<double>(emulator.config().frame_period.count());
  for (std::size_t k = 0; k < emulator.cameras(); ++k) {
    const CameraSettings& camera = emulator.camera(k).settings();
    const std::string name = name_for(emulator, k, video);
    const cv::Size size(camera.width_px, camera.height_px);
    Video& made = *videos_.emplace_back(std::make_unique<Video>());
    if (kind == ".avi")
      made.jpegs.emplace(name, size, frames_per_s);
    else if (!made.mp4.open(name, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), frames_per_s, size))
      throw std::runtime_error(
          fmt::format("cannot write the video {}; does the folder exist, and does the disk have free space?", name));
    last_.emplace_back(camera.height_px, camera.width_px, CV_8UC3, cv::Scalar::all(0));
  }
}

EmulatorRecord::~EmulatorRecord() = default;

void EmulatorRecord::add_truth(const Emulator& emulator) {
  if (truth_name_.empty()) return;
  const double time_s = static_cast<double>(emulator.now().count()) * 1e-6;
  std::string rows;
  for (const Emulator::Truth& robot : emulator.truth())
    rows += fmt::format("{:.6f},{},{},{:.6f},{:.6f},{:.5f},{},{}\n", time_s, robot.robot, robot.id, robot.seen.pose.x_m,
                        robot.seen.pose.y_m, robot.seen.pose.heading_rad,
                        led_names[static_cast<std::size_t>(robot.led)], robot.seen.in_arena ? 1 : 0);
  if (!(truth_ << rows).flush())
    throw std::runtime_error(fmt::format("cannot continue to write {}; is the disk full?", truth_name_));
}

void EmulatorRecord::add_picture(std::size_t number, const cv::Mat& picture) {
  if (videos_.empty()) return;
  if (!picture.empty()) picture.copyTo(last_[number]);
  Video& video = *videos_[number];
  if (video.jpegs)
    video.jpegs->write(last_[number]);
  else
    video.mp4.write(last_[number]);
}

void EmulatorRecord::add(Emulator& emulator) {
  add_truth(emulator);
  cv::Mat picture;
  for (std::size_t k = 0; k < videos_.size(); ++k) add_picture(k, emulator.picture(k, picture) ? picture : cv::Mat());
}

void write_calibration(const Emulator& emulator, const std::string& file) {
  // asked first: OpenCV complains by itself
  if (!std::ofstream(file, std::ios::app))
    throw std::runtime_error(
        fmt::format("cannot write the calibration to {}; does the folder exist, and is it writable?", file));
  std::vector<tracker::NamedCamera> cameras;
  for (std::size_t k = 0; k < emulator.cameras(); ++k) {
    const Camera as_at_first(emulator.camera(k).settings(), emulator.config().scene);
    const CameraModel& model = as_at_first.model_at_first();
    tracker::CameraData data;
    data.lens.width_px = model.width_px();
    data.lens.height_px = model.height_px();
    std::copy_n(model.matrix().val, 9, data.lens.matrix.begin());
    data.lens.distortion.assign(model.distortion().begin(), model.distortion().end());
    std::copy_n(model.rotation().val, 9, data.rotation.begin());
    std::copy_n(model.translation().val, 3, data.translation_m.begin());
    data.arena_width_m = emulator.config().scene.width_m;
    data.arena_height_m = emulator.config().scene.height_m;
    cv::Mat empty_arena;
    as_at_first.picture({}, {}, 0, empty_arena);
    std::vector<tracker::Landmark> landmarks = tracker::find_landmarks(empty_arena, {}, tracker::Calibration(data));
    cameras.push_back({as_at_first.settings().name, std::move(data), std::move(landmarks)});
  }
  tracker::write_calibrations(file, cameras);
}

void write_chessboards(const Emulator& emulator, int pictures, const std::string& folder) {
  constexpr int columns = 9, rows = 6;
  constexpr double square_m = 0.025;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (std::size_t k = 0; k < emulator.cameras(); ++k)
    for (int n = 0; n < pictures; ++n) {
      const Camera& camera = emulator.camera(k);
      cv::Mat picture = draw_chessboard(camera.model_at_first(), columns, rows, square_m, static_cast<std::uint64_t>(n),
                                        emulator.config().seed);
      if (camera.settings().blur_px > 0) cv::GaussianBlur(picture, picture, {}, camera.settings().blur_px);
      camera.add_noise(static_cast<std::uint64_t>(n), picture);
      const std::string name = fmt::format("{}/{}-{:02}.png", folder, camera.settings().name, n);
      tracker::write_picture(name, picture);
    }
}

}  // namespace arkmesh::emulator
