// Whether a camera that repeats its picture hangs, or sees robots that stand still.
#include "tracker/camera/hung_camera.hpp"

#include <doctest/doctest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tracker/camera/source.hpp"

using namespace arkmesh;
using tracker::HungCamera;
using Still = HungCamera::Verdict;

namespace {

// A lab's looks, ten a second.
struct Looks {
  HungCamera camera;
  hal::LabTime now{0};
  Still look(const cv::Mat& picture, bool changes = false) {
    now += hal::LabTime{100'000};
    return camera.look(now, picture.clone(), changes);
  }
  // So many looks at one picture; what the last said.
  Still repeat(const cv::Mat& picture, int times, bool changes = false) {
    Still last = look(picture, changes);
    for (int i = 1; i < times; ++i) last = look(picture, changes);
    return last;
  }
};

// An arena on which something has gone `step` pixels.
cv::Mat scene(int step) {
  cv::Mat out(240, 320, CV_8UC3, cv::Scalar(150, 152, 149));
  cv::circle(out, {60 + step, 120}, 12, cv::Scalar(40, 45, 40), cv::FILLED, cv::LINE_AA);
  return out;
}
cv::Mat noisy(int step, double sigma = 2) {
  cv::Mat out, grain(240, 320, CV_16SC3), wide;
  cv::RNG(static_cast<std::uint64_t>(step) + 1).fill(grain, cv::RNG::NORMAL, 0, sigma);
  scene(step).convertTo(wide, CV_16SC3);
  cv::Mat(wide + grain).convertTo(out, CV_8UC3);
  return out;
}
cv::Mat compressed(const cv::Mat& picture, int quality) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(jpeg, cv::IMREAD_COLOR);
}

}  // namespace

TEST_CASE("hung camera: pictures without noise are the same for as long as nothing need change") {
  // An hour of one picture is fresh while robots stand. It hangs after 10 s in which robots run or answer, counted from
  // when they began to, and is believed again from the first picture that differs; a pause in between makes it no
  // better.
  Looks quiet;
  for (int step = 0; step < 40; ++step) CHECK(quiet.look(scene(step), true) == Still::changed);
  CHECK(quiet.repeat(scene(39), 36'000) == Still::same);
  CHECK(quiet.repeat(scene(39), 100, true) == Still::same);
  CHECK(quiet.repeat(scene(39), 1, true) == Still::hung);
  CHECK(quiet.repeat(scene(39), 100) == Still::hung);
  CHECK(quiet.look(scene(40)) == Still::changed);
  CHECK(quiet.repeat(scene(40), 90, true) == Still::same);
  CHECK(quiet.repeat(scene(40), 1) == Still::same);
  CHECK(quiet.repeat(scene(40), 90, true) == Still::same);
  CHECK(quiet.look(cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(0)), true) == Still::changed);
}

TEST_CASE("hung camera: one that is noisy hangs after half a second, whatever robots do") {
  // As they come from the sensor, and as motion JPEG of two qualities; a slow stream that repeats each of them four
  // times does not hang, and neither does a quiet one that somebody has just carried about.
  for (const int quality : {0, 95, 80}) {
    CAPTURE(quality);
    const auto picture = [&](int step) { return quality > 0 ? compressed(noisy(step), quality) : noisy(step); };
    Looks camera;
    for (int step = 0; step <= HungCamera::noisy_pictures; ++step) CHECK(camera.look(picture(step)) == Still::changed);
    CHECK(camera.repeat(picture(HungCamera::noisy_pictures), 4) == Still::same);
    CHECK(camera.repeat(picture(HungCamera::noisy_pictures), 1) == Still::hung);
    CHECK(camera.look(picture(1)) == Still::changed);
    for (int step = 2; step < 40; ++step) CHECK(camera.repeat(picture(step), 5) == Still::same);
  }
  Looks carried;
  for (int step = 0; step < 20; ++step) carried.look(noisy(step));
  CHECK(carried.repeat(noisy(19), 100) == Still::same);
}

TEST_CASE("hung camera: a real clip") {
  // Proves that no picture of a compressed video of walking robots is taken for a repeated one.
  const auto clip = tracker::open_recording(std::string(ARKMESH_TEST_DATA) + "/kilobot-images/bodyguard_clip.mp4");
  Looks camera;
  int pictures = 0, changed = 0;
  while (const auto picture = clip->next()) ++pictures, changed += camera.look(picture->bgr, true) == Still::changed;
  CHECK(pictures == 242);
  CHECK(changed == pictures);
}
