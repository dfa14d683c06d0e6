#include "tracker/camera/live_camera.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <thread>
#include <utility>

#include "hal/without_secrets.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::tracker {
namespace {

using namespace std::chrono_literals;

constexpr int open_limit_ms = 4000, read_limit_ms = 3000;
constexpr std::chrono::milliseconds first_retry = 500ms, longest_retry = 8s;

// A row of undecoded bytes in place of a picture.
bool is_undecoded(const cv::Mat& picture) {
  return picture.rows == 1 && picture.type() == CV_8UC1;
}

class LiveCamera final : public CameraFeed {
 public:
  LiveCamera(std::string source, int width_px, int height_px, bool keep_bytes)
      : source_(std::move(source)),
        shown_(hal::without_secrets(source_)),
        width_px_(width_px),
        height_px_(height_px),
        keep_bytes_(keep_bytes),
        thread_([this] { run(); }) {}

  ~LiveCamera() override {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }

  cv::Mat newest() override {
    const std::lock_guard lock(mutex_);
    given_ = std::move(arrived_);
    return std::exchange(newest_, cv::Mat());
  }
  Arrival arrival() const override {
    const std::lock_guard lock(mutex_);
    return given_;
  }
  std::string error() const override {
    const std::lock_guard lock(mutex_);
    return error_;
  }
  hal::Counters counters() const override {
    const std::lock_guard lock(mutex_);
    return counters_;
  }

 private:
  bool stopping() const {
    const std::lock_guard lock(mutex_);
    return stopping_;
  }

  // The thread: opens, reads until nothing comes, pauses, opens again.
  void run() {
    std::chrono::milliseconds pause = first_retry;
    while (!stopping()) {
      std::string why;
      bool any = false;
      try {
        cv::VideoCapture camera;
        if (open(camera, why)) any = read_all(camera);
        if (any) why = fmt::format("the camera {} gives no pictures any more", shown_);
      } catch (const cv::Exception&) {
        why = fmt::format("the camera {} failed", shown_);
      }
      if (any) pause = first_retry;
      std::unique_lock lock(mutex_);
      if (error_.empty()) counters_.add("camera.gone");
      error_ = why;
      wake_.wait_for(lock, pause, [this] { return stopping_; });
      pause = std::min(2 * pause, longest_retry);
    }
  }

  bool open(cv::VideoCapture& camera, std::string& why) const {
    if (source_kind(source_) == SourceKind::url) {
      why = fmt::format("the camera {0} gives no pictures; this says what comes from there: ffprobe '{0}'", shown_);
      // FFmpeg knows kinds of URLs in small letters only
      std::string url = source_;
      std::transform(url.begin(), url.begin() + static_cast<long>(url.find(':')), url.begin(),
                     [](unsigned char c) { return std::tolower(c); });
      return camera.open(
          url, cv::CAP_FFMPEG,
          {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, open_limit_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, read_limit_ms});
    }
    const std::string device = source_.starts_with('/') ? source_ : "/dev/video" + source_;
    if (::access(device.c_str(), F_OK) != 0)
      why = fmt::format("there is no camera {}; is it plugged in?", device);
    else if (::access(device.c_str(), R_OK | W_OK) != 0)
      why = fmt::format(
          "{} may not be opened; add yourself to the group video (sudo usermod -aG video $USER) and log in again",
          device);
    else
      why = fmt::format("{} is no camera, or another program has it", device);
    if (!camera.open(device, cv::CAP_V4L2)) return false;
    camera.set(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'));
    if (width_px_ > 0 && height_px_ > 0) {
      camera.set(cv::CAP_PROP_FRAME_WIDTH, width_px_);
      camera.set(cv::CAP_PROP_FRAME_HEIGHT, height_px_);
    }
    camera.set(cv::CAP_PROP_BUFFERSIZE, 1);
    if (keep_bytes_ && camera.get(cv::CAP_PROP_FOURCC) == cv::VideoWriter::fourcc('M', 'J', 'P', 'G'))
      camera.set(cv::CAP_PROP_CONVERT_RGB, 0);
    return true;
  }

  // Until no picture comes or the end is wanted. Whether there was one.
  bool read_all(cv::VideoCapture& camera) {
    bool any = false;
    while (!stopping()) {
      cv::Mat picture;  // a new one each time: the last was handed over
      if (!camera.read(picture) || picture.empty()) break;
      Arrival arrived{.at = std::chrono::steady_clock::now(), .jpeg = {}};
      if (is_undecoded(picture)) {
        arrived.jpeg.assign(picture.data, picture.data + picture.total());
        picture = cv::imdecode(arrived.jpeg, cv::IMREAD_COLOR);
        if (picture.empty()) {  // cut on its way; the next one will be whole
          const std::lock_guard lock(mutex_);
          counters_.add("camera.refused.damaged");
          continue;
        }
      }
      if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
      if (picture.type() != CV_8UC3) break;
      any = true;
      const std::lock_guard lock(mutex_);
      error_.clear();
      if (!newest_.empty()) counters_.add("camera.skipped");
      newest_ = std::move(picture);
      arrived_ = std::move(arrived);
    }
    return any;
  }

  const std::string source_, shown_;
  const int width_px_, height_px_;
  const bool keep_bytes_;
  mutable std::mutex mutex_;  // guards all below but the thread
  std::condition_variable wake_;
  bool stopping_ = false;
  cv::Mat newest_;
  Arrival arrived_, given_;  // of newest_, and of the picture that newest() gave last
  std::string error_ = fmt::format("no picture has come yet from {}", shown_);
  hal::Counters counters_;
  std::thread thread_;  // last: begins when all else is there
};

}  // namespace

std::unique_ptr<CameraFeed> open_camera(const std::string& source, int width_px, int height_px) {
  quieten_libraries();
  return std::make_unique<LiveCamera>(source, width_px, height_px, false);
}

std::unique_ptr<CameraFeed> open_camera_with_bytes(const std::string& source, int width_px, int height_px) {
  quieten_libraries();
  return std::make_unique<LiveCamera>(source, width_px, height_px, true);
}

}  // namespace arkmesh::tracker
