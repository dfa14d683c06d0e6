#include "tracker/camera/live_camera.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <thread>
#include <utility>

#include "hal/config/without_secrets.hpp"
#include "hal/handle.hpp"
#include "tracker/camera/jpeg_stream.hpp"
#include "tracker/camera/picture_child.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::tracker {
namespace {

using namespace std::chrono_literals;

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds first_retry = 500ms, longest_retry = 8s;
constexpr std::size_t most_faults = 8;  // until somebody asks
constexpr int no_picture_limit = 30;    // of a camera at this machine: damaged ones in a row, then it is opened anew

// A row of undecoded bytes in place of a picture.
bool is_undecoded(const cv::Mat& picture) {
  return picture.rows == 1 && picture.type() == CV_8UC1;
}

// When the driver had the picture: by the steady clock, as Linux's drivers stamp. One that does not is not believed.
Clock::time_point stamped(double ms, Clock::time_point now) {
  if (!(ms > 0 && ms < 1e15)) return now;
  const Clock::time_point at{
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(ms))};
  return at <= now && now - at < 2s ? at : now;
}

class LiveCamera final : public CameraFeed {
 public:
  explicit LiveCamera(const CameraRequest& camera)
      : source_(camera.source),
        shown_(hal::without_secrets(source_)),
        wanted_(camera.width_px, camera.height_px),
        controls_(camera.controls),
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
    if (!newest_.empty()) given_.age = std::chrono::duration_cast<hal::LabTime>(Clock::now() - at_);
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
  std::vector<std::string> faults() override {
    const std::lock_guard lock(mutex_);
    return std::exchange(faults_, {});
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
      any_ = false;
      try {
        why = source_kind(source_) == SourceKind::url ? read_stream() : read_device();
      } catch (const cv::Exception&) {
        why = fmt::format("the camera {} failed", shown_);
      } catch (const std::exception& error) {
        why = fmt::format("the camera {} cannot be read: {}", shown_, error.what());
      }
      if (any_) pause = first_retry;
      std::unique_lock lock(mutex_);
      fail(std::move(why));
      wake_.wait_for(lock, pause, [this] { return stopping_; });
      pause = std::min(2 * pause, longest_retry);
    }
  }

  // Both return why it gives no more.
  std::string read_stream() {
    // by itself it says within 8 s that nothing comes
    PictureChild child({.path = source_, .shown = shown_, .live = true, .patience = 15s});
    while (true) {
      PictureChild::Event event = child.next([this] { return stopping(); });
      const PictureRecord& record = event.record;
      if (record.kind == PictureRecord::Kind::failed) return event.error;
      if (record.kind == PictureRecord::Kind::damaged) refuse_damaged(static_cast<std::uint64_t>(record.count));
      if (record.kind == PictureRecord::Kind::jpeg || record.kind == PictureRecord::Kind::bgr)
        take(std::move(event.bgr), Clock::time_point(std::chrono::microseconds(record.time_us)), std::move(event.jpeg));
    }
  }

  std::string read_device() {
    const std::string device = source_.starts_with('/') ? source_ : "/dev/video" + source_;
    if (::access(device.c_str(), F_OK) != 0) return fmt::format("there is no camera {}; is it plugged in?", device);
    if (::access(device.c_str(), R_OK | W_OK) != 0)
      return fmt::format(
          "no permission to open {}; add yourself to the group video (sudo usermod -aG video $USER) and log in again",
          device);
    cv::VideoCapture camera;
    if (!camera.open(device, cv::CAP_V4L2))
      return fmt::format("{} is not a camera, or another program uses it", device);
    const int mjpg = cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
    camera.set(cv::CAP_PROP_FOURCC, mjpg);
    if (!wanted_.empty()) {
      camera.set(cv::CAP_PROP_FRAME_WIDTH, wanted_.width);
      camera.set(cv::CAP_PROP_FRAME_HEIGHT, wanted_.height);
    }
    camera.set(cv::CAP_PROP_BUFFERSIZE, 1);
    if (camera.get(cv::CAP_PROP_FOURCC) == mjpg) camera.set(cv::CAP_PROP_CONVERT_RGB, 0);
    const hal::Handle own(::open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    std::string refusal = set_controls(controls_, shown_, [&own](unsigned long request, void* argument) {
      return ::ioctl(own.get(), request, argument);
    });
    if (!refusal.empty()) return refusal;
    for (int in_vain = 0; !stopping() && in_vain < no_picture_limit;) {
      cv::Mat picture;  // a new one each time: the last was handed over
      if (!camera.read(picture) || picture.empty()) break;
      const Clock::time_point at = stamped(camera.get(cv::CAP_PROP_POS_MSEC), Clock::now());
      std::vector<std::uint8_t> jpeg;
      if (is_undecoded(picture)) {
        JpegStream stream;  // cut on its way: none
        stream.add({picture.data, picture.total()});
        jpeg = stream.next().value_or(std::vector<std::uint8_t>());
        picture = decode_jpeg(jpeg);
      }
      if (picture.channels() == 1 && !picture.empty()) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
      in_vain = take(std::move(picture), at, std::move(jpeg)) ? 0 : in_vain + 1;
    }
    return fmt::format("the camera {} no longer sends pictures", shown_);
  }

  // With the mutex.
  void fail(std::string why) {
    if (error_.empty()) counters_.add("camera.gone");
    if (error_ != why && faults_.size() < most_faults) faults_.push_back(why);
    error_ = std::move(why);
  }

  void refuse_damaged(std::uint64_t count) {
    const std::lock_guard lock(mutex_);
    counters_.add("camera.refused.damaged", count);
    if (error_ == none_yet_)
      error_ = fmt::format(
          "the camera {} sends pictures, but none could be decoded so far (arithmetic coding is not supported)",
          shown_);
  }

  // A picture has come. False: it cannot be used.
  bool take(cv::Mat picture, Clock::time_point at, std::vector<std::uint8_t> jpeg) {
    if (picture.empty() || picture.type() != CV_8UC3) return refuse_damaged(1), false;
    const std::lock_guard lock(mutex_);
    // What is known of places in the pictures is known for one size. One that was asked for may come late.
    if (size_.empty() || picture.size() == wanted_) size_ = picture.size();
    if (picture.size() != size_) {
      counters_.add("camera.refused.changed");
      refused_at_ = Clock::now();
      fail(
          fmt::format("the camera {} now sends pictures of {} x {} pixels instead of {} x {}: they are not used; set "
                      "it back, or calibrate it at this resolution and restart",
                      shown_, picture.cols, picture.rows, size_.width, size_.height));
      return false;
    }
    any_ = true;
    if (Clock::now() - refused_at_ > 2s) error_.clear();  // sizes may alternate
    if (!newest_.empty()) counters_.add("camera.skipped");
    newest_ = std::move(picture);
    arrived_ = {.age = {}, .jpeg = std::move(jpeg)};
    at_ = at;
    return true;
  }

  const std::string source_, shown_;
  const cv::Size wanted_;  // empty: any
  const CameraControls controls_;
  bool any_ = false;          // the thread's: a picture since it was opened last
  mutable std::mutex mutex_;  // guards all below but the thread
  std::condition_variable wake_;
  bool stopping_ = false;
  cv::Mat newest_;
  cv::Size size_;                   // of all pictures
  Clock::time_point refused_at_{};  // one of another size
  Clock::time_point at_;            // of newest_
  Arrival arrived_, given_;         // of newest_, and of the picture that newest() gave last
  const std::string none_yet_ = fmt::format("no picture has arrived yet from {}", shown_);
  std::string error_ = none_yet_;
  std::vector<std::string> faults_;
  hal::Counters counters_;
  std::thread thread_;  // last: begins when all else is there
};

}  // namespace

std::unique_ptr<CameraFeed> open_camera(const CameraRequest& camera) {
  quieten_libraries();
  return std::make_unique<LiveCamera>(camera);
}

}  // namespace arkmesh::tracker
