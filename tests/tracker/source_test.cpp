// Pictures from folders, files and cameras that are not there.
#include "tracker/camera/source.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <thread>

#include "tests/support/processes/temporary_directory.hpp"
#include "tracker/camera/live_camera.hpp"

using namespace arkmesh;
using namespace arkmesh::tracker;
using arkmesh::tests::TemporaryDirectory;

namespace {

std::string refusal(const std::string& source) {
  try {
    if (source_kind(source) == SourceKind::recording) open_recording(source);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

cv::Mat grey(int level) {
  return cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(level));
}

}  // namespace

TEST_CASE("a source's kind follows from its spelling") {
  // Proves what is a camera, a URL and a path.
  CHECK(source_kind("0") == SourceKind::camera);
  CHECK(source_kind("/dev/video2") == SourceKind::camera);
  CHECK(source_kind("http://127.0.0.1:8090/camera0") == SourceKind::url);
  CHECK(source_kind("rtsp://table/1") == SourceKind::url);
  CHECK(source_kind("HTTP://table/1") == SourceKind::url);
  CHECK(source_kind("clip.mp4") == SourceKind::recording);
  CHECK(source_kind("2026") == SourceKind::recording);
}

TEST_CASE("a folder gives its pictures in the order of their numbers") {
  // Proves natural order, stamps of ten a second, and that other files are passed over.
  const TemporaryDirectory folder;
  folder.write("notes.txt", "not a picture");
  for (const int number : {10, 9, 2, 100})
    cv::imwrite((folder.path() / ("frame" + std::to_string(number) + ".png")).string(), grey(number));
  auto recording = open_recording(folder.path().string());
  CHECK(recording->pictures() == 4);
  std::uint32_t count = 0;
  for (const int level : {2, 9, 10, 100}) {
    const auto picture = recording->next();
    REQUIRE(picture.has_value());
    CHECK(picture->bgr.at<cv::Vec3b>(0, 0)[0] == level);
    CHECK(picture->number == count);
    CHECK(picture->stamp == hal::LabTime(count * 100'000));
    ++count;
  }
  CHECK_FALSE(recording->next().has_value());
}

TEST_CASE("a damaged picture of a folder is empty, and those after it keep their times") {
  // Proves that one bad file costs one picture.
  const TemporaryDirectory folder;
  for (const int number : {1, 3})
    cv::imwrite((folder.path() / ("frame" + std::to_string(number) + ".png")).string(), grey(number));
  folder.write("frame2.png", "words");
  auto recording = open_recording(folder.path().string());
  CHECK(recording->next()->bgr.at<cv::Vec3b>(0, 0)[0] == 1);
  const auto damaged = recording->next();
  REQUIRE(damaged.has_value());
  CHECK(damaged->bgr.empty());
  CHECK(damaged->name == "frame2.png");
  const auto last = recording->next();
  CHECK(last->bgr.at<cv::Vec3b>(0, 0)[0] == 3);
  CHECK(last->stamp == hal::LabTime(200'000));
}

TEST_CASE("a video gives all its pictures") {
  // Proves count, rate and stamps.
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "clip.avi").string();
  {
    cv::VideoWriter video(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 20, cv::Size(64, 48));
    REQUIRE(video.isOpened());
    for (int i = 0; i < 7; ++i) video.write(grey(30 * i));
  }
  auto recording = open_recording(file);
  CHECK(recording->pictures_per_s() == doctest::Approx(20));
  int count = 0;
  while (const auto picture = recording->next()) {
    CHECK(picture->stamp == hal::LabTime(count * 50'000));
    CHECK(std::abs(picture->bgr.at<cv::Vec3b>(20, 20)[0] - 30 * count) < 6);
    ++count;
  }
  CHECK(count == 7);
}

TEST_CASE("what is no source is refused in a sentence that names it") {
  // Proves each way in which a path can be wrong.
  quieten_libraries();
  const TemporaryDirectory folder;
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  CHECK(has(refusal((folder.path() / "none.mp4").string()), "there is no"));
  CHECK(has(refusal(folder.path().string()), "holds no picture"));
  CHECK(has(refusal(folder.write("text.mp4", "words").string()), "is not a readable video or picture"));
  CHECK(has(refusal("ftp://camera/1"), "not at ftp"));
}

TEST_CASE("a camera that is not there says so and does not block") {
  // Proves that reading never waits, that the reason is a sentence, that it is counted, and that the thread ends when
  // the feed does.
  for (const std::string source : {"/dev/video987", "http://127.0.0.1:1/none"}) {
    const auto feed = open_camera({.source = source});
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(300);
    while (feed->error().find("no picture has arrived yet") != std::string::npos &&
           std::chrono::steady_clock::now() < limit)
      std::this_thread::yield();
    CHECK(feed->error().find(source) != std::string::npos);
    CHECK(feed->newest().empty());
  }
}
