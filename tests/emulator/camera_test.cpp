// Where the renderer puts things, against OpenCV's own projection, and what colours it gives them.
#include "emulator/camera.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;
using namespace arkmesh::emulator;
using Seen = arkmesh::sim_ode::SimulatedArena::Seen;

namespace {

constexpr double radius_m = hal::kilobot::body_radius_m;

// A testbed without a spot, light without shadows: what differs is the robot.
Scene plain_scene() {
  Scene scene;
  scene.width_m = 1;
  scene.height_m = 0.6;
  scene.texture = scene.shadow = scene.light_slope = 0;
  scene.arena_grey = 200;
  return scene;
}

CameraSettings tilted_camera() {
  CameraSettings camera;
  camera.name = "tilted";
  camera.pose = {.x_m = 0.2, .y_m = -0.3, .z_m = 1.1, .look_x_m = 0.02, .look_y_m = 0.05, .roll_rad = 0.3};
  camera.distortion = {-0.2, 0.06, 0.001, -0.002, 0.01};
  camera.centre_x_px = 12;
  camera.centre_y_px = -7;
  camera.noise = camera.vignetting = 0;
  return camera;
}

cv::Point2d by_opencv(const CameraModel& model, double x, double y, double z) {
  cv::Vec3d turn;
  cv::Rodrigues(model.rotation(), turn);
  std::vector<cv::Point2d> out;
  cv::projectPoints(std::vector<cv::Point3d>{{x, y, z}}, turn, model.translation(), cv::Mat(model.matrix()),
                    std::vector<double>(model.distortion().begin(), model.distortion().end()), out);
  return out[0];
}

// Centre of the outline of everything that differs by more than `least` in some channel.
cv::Point2d outline_centre(const cv::Mat& with, const cv::Mat& without, int least) {
  cv::Mat difference, channels[3];
  cv::absdiff(with, without, difference);
  cv::split(difference, channels);
  cv::Mat mask = cv::max(cv::max(channels[0], channels[1]), channels[2]) > least;
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  REQUIRE_FALSE(outlines.empty());
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8U);
  cv::drawContours(filled, outlines, -1, 255, cv::FILLED);
  const cv::Moments moments = cv::moments(filled, true);
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

}  // namespace

TEST_CASE("the camera's projection is OpenCV's") {
  // Tilted, rolled, distorted, its lens off the middle; and back from pixels to the arena.
  const Camera camera(tilted_camera(), plain_scene());
  const CameraModel& model = camera.model();
  for (double x = -0.5; x <= 0.5; x += 0.125)
    for (double y = -0.3; y <= 0.3; y += 0.1)
      for (double z : {0.0, 0.03}) {
        const auto ours = model.project(x, y, z);
        REQUIRE(ours);
        CHECK(cv::norm(*ours - by_opencv(model, x, y, z)) < 1e-6);
        const auto back = model.meets_plane(model.ideal(*ours), z);
        REQUIRE(back);
        CHECK(cv::norm(*back - cv::Point2d(x, y)) < 1e-7);
      }
  CHECK_FALSE(model.project(0, 0, 5));
}

TEST_CASE("a robot's board is centred where its centre is projected to, at its height, within a tenth of a pixel" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // Mean over 24 headings, so that tab and parts even out; several places of the picture and two cameras.
  CameraSettings above = tilted_camera();
  above.pose = {.z_m = 1.2};
  above.distortion = {};
  for (const CameraSettings& settings : {tilted_camera(), above}) {
    const Scene scene = plain_scene();
    const Camera camera(settings, scene);
    cv::Mat without, with;
    camera.picture({}, {}, 0, without);
    for (const auto& place : {std::pair{0.0, 0.0}, {0.312, 0.137}, {-0.405, -0.213}, {0.101, -0.2507}}) {
      const auto& [x, y] = place;
      CAPTURE(place.first);
      cv::Point2d sum(0, 0);
      for (int k = 0; k < 24; ++k) {
        const Seen robot{.pose = {x, y, k * std::numbers::pi / 12}};
        camera.picture({&robot, 1}, {}, 0, with);
        sum += outline_centre(with, without, 80);
      }
      CHECK(cv::norm(sum / 24 - by_opencv(camera.model(), x, y, scene.robot_height_m)) < 0.1);
    }
  }
}

TEST_CASE("the LED shines 44 degrees to the right of ahead, near the rim") {
  // The bright core's centre against the place projected; with all colours, at the radius of this kind of robot. Also
  // of a robot that carries it elsewhere.
  const Scene scene = plain_scene();
  CameraSettings settings = tilted_camera();
  settings.led_brightness = 0.05;  // so that the core is not cut off by saturation
  const Camera camera(settings, scene);
  const RobotLook look = make_robot_look(0, 15, 0.7, 0.715);
  CHECK(look.led_radius >= 0.84);
  CHECK(look.led_radius <= 0.9);
  for (double heading : {0.0, 1.0, 2.5, -2.0}) {
    const double bearing = (heading == 1 ? 20 : -44) * std::numbers::pi / 180, angle = heading + bearing,
                 far = look.led_radius * radius_m;
    const cv::Point2d expected = by_opencv(camera.model(), 0.1 + far * std::cos(angle), -0.1 + far * std::sin(angle),
                                           scene.robot_height_m + 0.001);
    Seen robot{.pose = {0.1, -0.1, heading}};
    if (heading == 1) robot.led_bearing_rad = bearing;
    cv::Mat off, on;
    camera.picture({&robot, 1}, {}, 0, off);
    robot.red = robot.green = robot.blue = 1;
    camera.picture({&robot, 1}, {}, 0, on);
    CHECK(cv::norm(outline_centre(on, off, 30) - expected) < 0.25);
  }
}

TEST_CASE("where colour filters overlap, a green LED's light is bluish") {
  const Scene scene = plain_scene();
  CameraSettings settings = tilted_camera();
  settings.led_brightness = 0.05;
  for (const double overlap : {0.0, 0.4}) {
    settings.overlap = overlap;
    const Camera camera(settings, scene);
    Seen robot{.pose = {0.1, -0.1, 0}};
    cv::Mat off, on;
    camera.picture({&robot, 1}, {}, 0, off);
    robot.green = 1;
    camera.picture({&robot, 1}, {}, 0, on);
    const cv::Scalar added = cv::sum(on) - cv::sum(off);
    CHECK(added[1] > 2 * added[2]);
    CHECK((added[0] > 1.5 * added[2]) == (overlap > 0));
  }
}

TEST_CASE("an LED's core is white and its halo coloured, for each of the eight colours" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // As in pictures of real robots: the colour must be read from the light around the core.
  const Scene scene = plain_scene();
  const Camera camera(tilted_camera(), scene);
  for (int colour = 1; colour < 8; ++colour) {
    CAPTURE(colour);
    Seen robot{.pose = {0, 0, 0}};
    cv::Mat off, on, added;
    camera.picture({&robot, 1}, {}, 0, off);
    robot.red = static_cast<float>(colour & 1);
    robot.green = static_cast<float>(colour >> 1 & 1);
    robot.blue = static_cast<float>(colour >> 2 & 1);
    camera.picture({&robot, 1}, {}, 0, on);
    cv::absdiff(on, off, added);
    const double angle = -44 * std::numbers::pi / 180, far = 0.87 * radius_m;
    const cv::Point2d led =
        by_opencv(camera.model(), far * std::cos(angle), far * std::sin(angle), scene.robot_height_m);
    const auto core = on.at<cv::Vec3b>(static_cast<int>(std::lround(led.y)), static_cast<int>(std::lround(led.x)));
    CHECK(*std::min_element(core.val, core.val + 3) > 150);
    // a ring around the core
    cv::Mat ring = cv::Mat::zeros(on.size(), CV_8U);
    cv::circle(ring, led, 9, 255, 3);
    const cv::Scalar halo = cv::mean(added, ring);
    const double strongest = std::max({halo[0], halo[1], halo[2]});
    CHECK(strongest > 5);
    for (int c : {0, 1, 2}) {
      const bool shines = colour >> (2 - c) & 1;
      CHECK((halo[c] > 0.5 * strongest) == shines);
    }
  }
}

TEST_CASE("pictures repeat to the bit, and noise is new in each") {
  // The same number gives the same picture; the noise has the strength that was asked for.
  CameraSettings settings = tilted_camera();
  settings.noise = 3;
  const Camera camera(settings, plain_scene()), twin(settings, plain_scene());
  const Seen robot{.pose = {0.1, 0.1, 1}, .red = 1};
  cv::Mat a, b, c;
  camera.picture({&robot, 1}, {}, 7, a);
  twin.picture({&robot, 1}, {}, 7, b);
  camera.picture({&robot, 1}, {}, 8, c);
  CHECK(cv::norm(a, b, cv::NORM_INF) == 0);
  cv::Mat difference;
  cv::subtract(a, c, difference, cv::noArray(), CV_32F);
  cv::Scalar mean, sd;
  cv::meanStdDev(difference, mean, sd);
  CHECK(std::abs(mean[0]) < 0.1);
  CHECK(std::abs(sd[0] - 3 * std::sqrt(2)) < 0.4);
}

TEST_CASE("robots at and beyond the picture's edge are cut off, not drawn elsewhere") {
  // A narrow view of a wide arena: whatever lies outside leaves the picture as it is.
  CameraSettings settings = tilted_camera();
  settings.width_px = 480;
  settings.height_px = 270;
  settings.focal_px = 1500;
  const Camera camera(settings, plain_scene());
  cv::Mat empty, full;
  camera.picture({}, {}, 0, empty);
  std::vector<Seen> outside, all;
  const double apart_m = arkmesh::tests::thorough() ? 0.04 : 0.08;
  for (double x = -0.5; x <= 0.5; x += apart_m)
    for (double y = -0.3; y <= 0.3; y += apart_m) {
      const Seen robot{.pose = {x, y, x * 7}, .red = 1, .blue = 1};
      all.push_back(robot);
      const cv::Point2d at = *camera.model().project(x, y, 0.02);
      if (at.x < -100 || at.y < -100 || at.x > 580 || at.y > 370) outside.push_back(robot);
    }
  REQUIRE(outside.size() > 50);
  camera.picture(outside, {}, 0, full);
  CHECK(cv::norm(empty, full, cv::NORM_INF) == 0);
  camera.picture(all, {}, 0, full);
  CHECK(cv::norm(empty, full, cv::NORM_INF) > 100);
}

TEST_CASE("a chessboard's corners are found and give the camera back" * doctest::skip(!arkmesh::tests::thorough())) {
  // Twelve pictures through OpenCV's own calibration: focal length within 0.3 %, centre within 3 px, small residual.
  CameraSettings settings = tilted_camera();
  settings.width_px = 960;
  settings.height_px = 720;
  settings.distortion = {-0.15, 0.05, 0.0005, -0.0005, 0};
  const Camera camera(settings, plain_scene());
  std::vector<cv::Point3f> board;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 9; ++column)
      board.emplace_back(static_cast<float>(column) * 0.025F, static_cast<float>(row) * 0.025F, 0.0F);
  std::vector<std::vector<cv::Point2f>> corners;
  for (std::uint64_t k = 0; k < 12; ++k) {
    cv::Mat picture = draw_chessboard(camera.model(), 9, 6, 0.025, k, 1), grey;
    cv::GaussianBlur(picture, picture, {}, 0.7);
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    std::vector<cv::Point2f> found;
    REQUIRE(cv::findChessboardCorners(grey, {9, 6}, found));
    cv::cornerSubPix(grey, found, {5, 5}, {-1, -1}, {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 40, 0.001});
    corners.push_back(found);
  }
  cv::Mat matrix, distortion;
  std::vector<cv::Mat> turns, places;
  const double residual = cv::calibrateCamera(std::vector<std::vector<cv::Point3f>>(corners.size(), board), corners,
                                              {960, 720}, matrix, distortion, turns, places, cv::CALIB_FIX_K3);
  CHECK(residual < 0.15);
  CHECK(matrix.at<double>(0, 0) == doctest::Approx(camera.model().matrix()(0, 0)).epsilon(0.003));
  CHECK(std::abs(matrix.at<double>(0, 2) - camera.model().matrix()(0, 2)) < 3);
  CHECK(std::abs(matrix.at<double>(1, 2) - camera.model().matrix()(1, 2)) < 3);
}

TEST_CASE("cameras that cannot be are refused with a sentence") {
  // Each reason has its own words.
  const auto error = [](auto change) {
    CameraSettings settings = tilted_camera();
    change(settings);
    try {
      const Camera camera(settings, plain_scene());
    } catch (const std::invalid_argument& why) {
      return std::string(why.what());
    }
    return std::string();
  };
  CHECK(error([](CameraSettings& s) { s.distortion = {-3, 0, 0, 0, 0}; }).find("folds") != std::string::npos);
  CHECK(error([](CameraSettings& s) { s.pose.z_m = -1; }).find("above the arena") != std::string::npos);
  CHECK(error([](CameraSettings& s) { s.focal_px = 90000; }).find("pixels") != std::string::npos);
  CHECK(error([](CameraSettings& s) { s.pose.z_m = 0.05; }).find("whole arena") != std::string::npos);
}
