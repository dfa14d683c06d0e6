// Pixels and the arena: lenses against OpenCV's, height, files of ours and of ARK, chessboards, and what is refused.
#include "tracker/camera/calibration.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <stdexcept>

#include "hal/platforms/kilobot/body.hpp"
#include "tests/support/processes/temporary_directory.hpp"
#include "tracker/camera/arena_corners.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/camera_fit.hpp"

using namespace arkmesh::tracker;

namespace {

// A camera 1.4 m above the arena, off its middle and a little tilted.
CameraData tilted(LensModel model, std::vector<double> distortion) {
  CameraData data;
  data.lens = {model, 1920, 1080, {1300, 0, 970, 0, 1310, 530, 0, 0, 1}, std::move(distortion)};
  const cv::Matx33d down(1, 0, 0, 0, -1, 0, 0, 0, -1);
  cv::Matx33d tilt;
  cv::Rodrigues(cv::Vec3d(0.15, -0.1, 0.3), tilt);
  const cv::Matx33d rotation = tilt * down;
  std::copy(rotation.val, rotation.val + 9, data.rotation.begin());
  const cv::Vec3d translation = -(rotation * cv::Vec3d(0.1, -0.15, 1.4));
  data.translation_m = {translation[0], translation[1], translation[2]};
  return data;
}

const std::vector<std::pair<LensModel, std::vector<double>>> lenses = {
    {LensModel::pinhole, {}},
    {LensModel::pinhole, {-0.25, 0.06, 0.001, -0.002}},
    {LensModel::pinhole, {-0.3, 0.1, 0.001, 0.0005, -0.01}},
    {LensModel::pinhole, {0.5, 0.1, 0.0005, -0.0003, 0.02, 0.7, 0.2, 0.03}},
    {LensModel::fisheye, {-0.02, 0.01, -0.005, 0.001}},
};

std::string refusal(const auto& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("every lens maps as OpenCV's does") {
  // Proves that points of the arena land on the pixels that calib3d gives, for each number of coefficients.
  for (const auto& [model, distortion] : lenses) {
    const CameraData data = tilted(model, distortion);
    const Calibration calibration(data);
    cv::Mat rotation(3, 3, CV_64F, const_cast<double*>(data.rotation.data())), rodrigues;
    cv::Rodrigues(rotation, rodrigues);
    const cv::Mat k(3, 3, CV_64F, const_cast<double*>(data.lens.matrix.data()));
    for (const double x : {-0.5, -0.1, 0.45})
      for (const double y : {-0.35, 0.0, 0.4})
        for (const double z : {0.0, 0.03}) {
          std::vector<cv::Point2d> expected;
          const std::vector<cv::Point3d> points = {{x, y, z}};
          const cv::Vec3d t(data.translation_m.data());
          if (model == LensModel::fisheye)
            cv::fisheye::projectPoints(points, expected, cv::Vec3d(rodrigues), t, k, distortion);
          else
            cv::projectPoints(points, rodrigues, t, k, distortion, expected);
          const auto pixel = calibration.to_pixel({x, y}, z);
          REQUIRE(pixel.has_value());
          CHECK(pixel->x == doctest::Approx(expected[0].x).epsilon(1e-9));
          CHECK(pixel->y == doctest::Approx(expected[0].y).epsilon(1e-9));
        }
  }
}

TEST_CASE("there and back is the same place, at every height") {
  // Proves that to_arena undoes to_pixel to a micrometre, lens distortion included.
  for (const auto& [model, distortion] : lenses) {
    const Calibration calibration(tilted(model, distortion));
    for (double x_px = 20; x_px < 1920; x_px += 190)
      for (double y_px = 15; y_px < 1080; y_px += 150)
        for (const double z : {0.0, hal::kilobot::board_height_m}) {
          const auto place = calibration.to_arena({x_px, y_px}, z);
          REQUIRE(place.has_value());
          const auto pixel = calibration.to_pixel(*place, z);
          REQUIRE(pixel.has_value());
          CHECK(std::hypot(pixel->x - x_px, pixel->y - y_px) < 1e-5);
        }
  }
}

TEST_CASE("a robot's height is corrected") {
  // Proves the size of the parallax: at 1.4 m above, a board 22 mm high half a metre off seems 8 mm farther out.
  CameraData data;
  data.lens = {LensModel::pinhole, 1000, 1000, {900, 0, 499.5, 0, 900, 499.5, 0, 0, 1}, {}};
  data.translation_m = {0, 0, 1.4};
  const Calibration calibration(data);
  const auto pixel = calibration.to_pixel({0.5, 0}, 0.022);
  REQUIRE(pixel.has_value());
  CHECK(calibration.to_arena(*pixel, 0.022)->x == doctest::Approx(0.5));
  CHECK(calibration.to_arena(*pixel, 0)->x == doctest::Approx(0.5 * 1.4 / (1.4 - 0.022)));
  CHECK(calibration.scale({0.2, 0.1}, 0.022)->largest == doctest::Approx(900 / (1.4 - 0.022)));
  CHECK(calibration.scale({0.2, 0.1}, 0.022)->smallest == doctest::Approx(900 / (1.4 - 0.022)));
}

TEST_CASE("pictures of which nothing is known are seen from straight above") {
  // Proves the mapping without calibration: metres are pixels times the scale, north up, the middle is the origin,
  // height does not matter.
  const Calibration flat = Calibration::overhead(801, 601, 0.001);
  const auto place = flat.to_arena({500, 200}, 0.0217);
  REQUIRE(place.has_value());
  CHECK(place->x == doctest::Approx(0.1));
  CHECK(place->y == doctest::Approx(0.1));
  CHECK(flat.inside_px({500, 200}) == doctest::Approx(200));
  CHECK(flat.inside_px({-3, 200}) == doctest::Approx(-3));
}

TEST_CASE("where a camera cannot look there is nothing") {
  // Proves that points behind the camera, sights above the horizon and radii where the lens folds over are no places.
  CameraData level = tilted(LensModel::pinhole, {});
  level.rotation = {1, 0, 0, 0, 0, -1, 0, 1, 0};  // looks north along the arena
  level.translation_m = {0, 0.5, 0};              // from 0.5 m above the origin
  const Calibration calibration(level);
  CHECK_FALSE(calibration.to_pixel({0, -1}, 0).has_value());
  CHECK(calibration.to_pixel({0, 3}, 0).has_value());
  CHECK_FALSE(calibration.to_arena({900, 100}, 0).has_value());
  CHECK(calibration.to_arena({900, 900}, 0).has_value());
  const Calibration folding(tilted(LensModel::pinhole, {-0.4, 0, 0, 0}));
  CHECK_FALSE(folding.to_pixel({2.5, 0}, 0).has_value());
}

TEST_CASE("impossible cameras are refused") {
  // Proves one sentence for each thing that a camera cannot be.
  const auto reason = [](const auto& change) {
    return refusal([&] {
      CameraData data = tilted(LensModel::pinhole, {});
      change(data);
      Calibration{data};
    });
  };
  CHECK(contains(reason([](auto& d) { d.lens.distortion = {1, 2, 3}; }), "3 distortion coefficients"));
  CHECK(contains(reason([](auto& d) { d.lens.matrix[0] = -5; }), "camera matrix"));
  CHECK(contains(reason([](auto& d) { d.rotation[0] = 2; }), "rotation"));
  CHECK(contains(reason([](auto& d) { d.translation_m[2] = -1; }), "below the arena"));
  CHECK(contains(reason([](auto& d) { d.lens.width_px = 0; }), "picture size"));
  CHECK(contains(reason([](auto& d) { d.arena_width_m = 0; }), "arena"));
  CHECK(contains(reason([](auto& d) { d.translation_m[0] = std::nan(""); }), "not a number"));
  CHECK(contains(reason([](auto& d) { d.lens.distortion = {-1e6, 0, 0, 0}; }), "folds"));
}

TEST_CASE("a file keeps calibrations, and others are refused by name") {
  // Proves that what is written is read again, and that each wrong file is one sentence with the file's name.
  const arkmesh::tests::TemporaryDirectory folder;
  const auto file = folder.path() / "arena.yaml";
  std::vector<NamedCamera> cameras;
  for (const auto& [model, distortion] : lenses) {
    cameras.push_back({"camera" + std::to_string(cameras.size()), tilted(model, distortion)});
    cameras.back().data.error_mm = 0.4;
    cameras.back().landmarks.push_back(
        {.x_px = 30,
         .y_px = 40 + static_cast<int>(cameras.size()),
         .grey = std::vector<std::uint8_t>(Landmark::side * Landmark::side, 200),
         .rough = std::vector<std::uint8_t>(Landmark::rough_side * Landmark::rough_side, 7)});
  }
  write_calibrations(file, cameras);
  CHECK(read_calibrations(file).size() == cameras.size());
  for (const auto& [name, data, landmarks] : cameras) {
    const CameraData again = read_calibration(file, name).data;
    CHECK(again.lens.model == data.lens.model);
    CHECK(again.lens.matrix == data.lens.matrix);
    CHECK(again.lens.distortion == data.lens.distortion);
    CHECK(again.rotation == data.rotation);
    CHECK(again.translation_m == data.translation_m);
    CHECK(again.error_mm == data.error_mm);
    const std::vector<Landmark> kept = read_calibration(file, name).landmarks;
    REQUIRE(kept.size() == 1);
    CHECK(kept[0].y_px == landmarks[0].y_px);
    CHECK(kept[0].grey == landmarks[0].grey);
    CHECK(kept[0].rough == landmarks[0].rough);
  }
  CHECK(contains(refusal([&] { read_calibration(file); }), "name one: camera0, camera1"));
  CHECK(contains(refusal([&] { read_calibration(file, "north"); }), "no camera north"));
  CHECK(contains(refusal([&] { read_calibration(folder.path() / "none.yaml"); }), "no such"));
  CHECK(contains(refusal([&] { write_calibrations(folder.path() / "no" / "folder.yaml", cameras); }),
                 "cannot be written"));
  const auto reason = [&](const std::string& text) {
    std::ofstream(file) << text;
    return refusal([&] { read_calibration(file); });
  };
  const std::string head = "%YAML:1.0\n---\n";
  CHECK(contains(reason(""), file.string()));
  CHECK(contains(reason(head + "K: 3\n"), "contains no cameras"));
  CHECK(contains(reason(head + "cameras: [ 1, 2 ]\n"), "something else"));
  CHECK(contains(reason(head + "cameras:\n  - { name: a, lens: mirror }\n"), "lens"));
  CHECK(contains(reason(head + "cameras:\n  - { name: a, image_width: -4 }\n"), "image_width"));
  CHECK(
      contains(reason(head + "cameras:\n  - { name: a, image_width: 10, image_height: 10, camera_matrix: [ 1, 2 ] }\n"),
               "camera a: camera_matrix should hold 9"));
  const std::string whole =
      head +
      "cameras:\n  - { name: a, image_width: 10, image_height: 10, camera_matrix: [ 9, 0, 5, 0, 9, 5, 0, 0, 1 ], "
      "distortion_coefficients: [], rotation: [ 1, 0, 0, 0, -1, 0, 0, 0, -1 ], translation: [ 0, 0, 1 ]";
  CHECK(reason(whole + " }\n").empty());
  CHECK(contains(reason(whole + ", landmarks: 3 }\n"), "landmarks should be a list"));
  CHECK(contains(reason(whole + ", landmarks: [ 3 ] }\n"), "a landmark is not a map"));
  CHECK(
      contains(reason(whole + ", landmarks: [ { x_px: 3, y_px: 4, grey: \"0g\" } ] }\n"), "grey should be 529 bytes"));
  CHECK(contains(reason("\x7f"
                        "ELF {{{ ["),
                 file.string()));
}

TEST_CASE("a lens is taken from calibrations of OpenCV and ROS") {
  // Proves that both say the same, whatever their first line, and that what is none is refused for what it is.
  const arkmesh::tests::TemporaryDirectory folder;
  const auto lens_in = [&](const std::string& text) { return read_intrinsics(folder.write("lens.yaml", text)); };
  const auto reason = [&](const std::string& text) { return refusal([&] { lens_in(text); }); };
  const std::string size = "image_width: 1920\nimage_height: 1080\n",
                    numbers = "[ 1500., 0., 960., 0., 1490., 540., 0., 0., 1. ]";
  const Lens opencv = lens_in("%YAML:1.0\n---\n" + size +
                              "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: " + numbers +
                              "\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n" +
                              "   data: [ 0.05, -0.1, 0., 0., 0.01 ]\n");
  const std::string ros_head = size + "camera_name: overhead\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: " + numbers;
  const std::string coefficients =
      "\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.05, -0.1, 0, 0, 0.01]\n";
  for (const std::string& first : {"", "---\n", "# of the north camera\n"}) {
    const Lens ros = lens_in(first + ros_head + "\ndistortion_model: plumb_bob" + coefficients);
    CHECK(ros.matrix == opencv.matrix);
    CHECK(ros.distortion == opencv.distortion);
    CHECK(ros.width_px == 1920);
    CHECK(ros.height_px == 1080);
    CHECK(ros.model == LensModel::pinhole);
  }
  CHECK(opencv.matrix[4] == 1490);
  CHECK(
      lens_in(ros_head + "\ndistortion_model: equidistant\ndistortion_coefficients:\n  data: [0.1, 0, 0, 0]\n").model ==
      LensModel::fisheye);
  CHECK(contains(reason(""), "is empty"));
  CHECK(contains(reason("% Intrinsic\nfc = [ 1500.0 ; 1500.0 ];\n"), "is no"));
  CHECK(contains(reason("words: 3\n"), "no camera_matrix"));
  CHECK(contains(reason(ros_head + "\ndistortion_model: mirror" + coefficients), "mirror"));
  CHECK(contains(reason(ros_head + "\n"), "distortion_coefficients should hold"));
  const auto file = folder.write("lens.yaml", ros_head + coefficients);
  CHECK(contains(refusal([&] { read_calibrations(file); }), "describes only a lens"));
}

TEST_CASE("pictures of a chessboard from which no focal length follows are refused, and doubts are said") {
  // Proves that copies of a picture count once, that boards of one slant are none, and that a corner of the view
  // covered only is a doubt.
  CameraData truth = tilted(LensModel::pinhole, {});
  const Lens& lens = truth.lens;
  // A board 0.6 m before the lens, turned about the camera's x and y, degrees.
  const auto board = [&](double about_x, double about_y, double x_m, double y_m) {
    cv::Mat picture(lens.height_px, lens.width_px, CV_8UC3, cv::Scalar::all(255));
    cv::Matx33d turned;
    cv::Rodrigues(cv::Vec3d(about_x, about_y, 0) * (CV_PI / 180), turned);
    const auto pixel = [&](int column, int row) {
      const cv::Vec3d at = turned * cv::Vec3d((column - 4) * 0.03, (row - 3.5) * 0.03, 0) + cv::Vec3d(x_m, y_m, 0.6);
      return cv::Point(static_cast<int>(std::lround(16 * (lens.matrix[0] * at[0] / at[2] + lens.matrix[2]))),
                       static_cast<int>(std::lround(16 * (lens.matrix[4] * at[1] / at[2] + lens.matrix[5]))));
    };
    for (int row = 0; row < 7; ++row)
      for (int column = 0; column < 8; ++column)
        if ((row + column) % 2 == 0) {
          const cv::Point square[] = {pixel(column, row), pixel(column + 1, row), pixel(column + 1, row + 1),
                                      pixel(column, row + 1)};
          cv::fillConvexPoly(picture, square, 4, cv::Scalar::all(0), cv::LINE_AA, 4);
        }
    return picture;
  };
  const auto fit = [&](const std::vector<cv::Mat>& pictures) {
    LensFit all(ChessboardSize{7, 6, 30});
    for (const cv::Mat& picture : pictures) REQUIRE(all.add(picture));
    return all.fit();
  };
  const cv::Mat one = board(25, 0, 0, 0);
  CHECK(contains(refusal([&] { fit({one, one, one, one}); }), "as others do, which leaves 1 different"));
  CHECK(contains(refusal([&] {
                   fit({board(25, 0, 0, 0), board(25, 0, 0.05, 0), board(25, 0, 0, 0.05)});
                 }),
                 "the same slant"));
  const FittedLens narrow = fit({board(30, 0, 0, 0), board(-30, 0, 0, 0), board(0, 30, 0, 0), board(0, -30, 0, 0)});
  CHECK(narrow.lens.matrix[0] == doctest::Approx(lens.matrix[0]).epsilon(0.02));
  CHECK(std::ranges::any_of(narrow.doubts, [](const std::string& doubt) { return contains(doubt, "boards cover"); }));
}

TEST_CASE("a calibration of ARK is taken over") {
  // Proves that each camera maps the arena as ARK's own path does: plane of K and R, overview, corners.
  const arkmesh::tests::TemporaryDirectory folder;
  const auto file = folder.path() / "ark.yaml";
  std::vector<cv::Mat> ks, rs;
  for (int i = 0; i < 4; ++i) {
    ks.push_back(
        (cv::Mat_<double>(3, 3) << 6000 + 100 * i, 0, i % 2 ? -900 : 2900, 0, 5800, i < 2 ? 1950 : -420, 0, 0, 1));
    cv::Mat r;
    cv::Rodrigues(cv::Vec3d(0.02 * i, -0.015 * i, 0.01 * i), r);
    rs.push_back(r);
  }
  const std::vector<cv::Point2f> corners = {{202, 71}, {1341, 81}, {138, 1464}, {1367, 1512}};
  {
    cv::FileStorage out(file.string(), cv::FileStorage::WRITE);
    for (int i = 0; i < 4; ++i) out << "corner" + std::to_string(i + 1) << corners[i];
    out << "R" << rs << "K" << ks;
  }
  const std::vector<CameraData> cameras = import_ark_calibration(file, {});
  REQUIRE(cameras.size() == 4);

  // ARK's path by hand: the overview is stretched over all pictures' projections.
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  std::vector<cv::Matx33d> onto_plane;
  for (int i = 0; i < 4; ++i) {
    onto_plane.push_back(cv::Matx33d(cv::Mat(rs[i] * ks[i].inv())));
    for (const cv::Vec3d& p :
         {cv::Vec3d(0, 0, 1), cv::Vec3d(2047, 0, 1), cv::Vec3d(0, 1535, 1), cv::Vec3d(2047, 1535, 1)}) {
      const cv::Vec3d at = onto_plane[i] * p;
      left = std::min(left, at[0] / at[2]), right = std::max(right, at[0] / at[2]);
      top = std::min(top, at[1] / at[2]), bottom = std::max(bottom, at[1] / at[2]);
    }
  }
  for (int i = 0; i < 4; ++i) {
    const Calibration camera(cameras[i]);
    for (int c = 0; c < 4; ++c) {
      const cv::Vec3d plane(left + corners[c].x / 1536 * (right - left), top + corners[c].y / 1536 * (bottom - top), 1);
      const cv::Vec3d pixel = onto_plane[i].inv() * plane;
      const Point arena{c % 2 ? 1.0 : -1.0, c < 2 ? 1.0 : -1.0};
      const auto mine = camera.to_pixel(arena, 0);
      REQUIRE(mine.has_value());
      CHECK(mine->x == doctest::Approx(pixel[0] / pixel[2]).epsilon(1e-3));
      CHECK(mine->y == doctest::Approx(pixel[1] / pixel[2]).epsilon(1e-3));
    }
    // Robots are higher than the arena: they seem farther from the middle of the picture.
    const auto low = camera.to_arena({1900, 1400}, 0), high = camera.to_arena({1900, 1400}, 0.03);
    const auto middle = camera.to_arena({1023.5, 767.5}, 0);
    REQUIRE(low.has_value());
    REQUIRE(high.has_value());
    CHECK(std::hypot(high->x - middle->x, high->y - middle->y) ==
          doctest::Approx(std::hypot(low->x - middle->x, low->y - middle->y) * (1 - 0.03 / 1.6)).epsilon(1e-3));
  }
  // Corners in another order, the same four times, on one line: no arena.
  const std::vector<std::vector<cv::Point2f>> wrong_corners = {{{1341, 81}, {202, 71}, {138, 1464}, {1367, 1512}},
                                                               {{202, 71}, {202, 71}, {202, 71}, {202, 71}},
                                                               {{100, 100}, {1400, 100}, {400, 100}, {900, 100}}};
  for (const auto& wrong : wrong_corners) {
    {
      cv::FileStorage out(file.string(), cv::FileStorage::WRITE);
      for (int i = 0; i < 4; ++i) out << "corner" + std::to_string(i + 1) << wrong[i];
      out << "R" << rs << "K" << ks;
    }
    CHECK(contains(refusal([&] { import_ark_calibration(file, {}); }), "are not an arena's"));
  }
  std::ofstream(file) << "%YAML:1.0\n---\nK: 3\n";
  CHECK(contains(refusal([&] { import_ark_calibration(file, {}); }), "0 K, 0 R and 0 corners"));
}

TEST_CASE("real chessboard pictures of a strong fisheye give a fisheye") {
  // Proves that a pinhole, whose distortion folds over within the picture, is not taken although it fits the boards in
  // the middle as well.
  std::vector<cv::Mat> pictures;
  for (const char* name : {"checker_01.jpg", "checker_02.jpg", "checker_09.jpg", "checker_11.jpg", "checker_13.jpg"})
    pictures.push_back(cv::imread(std::string(ARKMESH_TEST_DATA) + "/kilobot-images/checkerboards/" + name));
  LensFit fit(ChessboardSize{7, 6, 25});
  for (const cv::Mat& picture : pictures) CHECK(fit.add(picture));
  const FittedLens lens = fit.fit();
  CHECK(lens.lens.model == LensModel::fisheye);
  CHECK(lens.pictures == 5);
  CHECK(lens.error_px < 1);
  CHECK(lens.error_mm < 0.6);
  CHECK_FALSE(fit.add(cv::Mat(1000, 748, CV_8UC3, cv::Scalar(90, 90, 90))));
  CHECK(contains(refusal([&] { fit.add(cv::Mat(748, 1000, CV_8UC3)); }), "1000 x 748"));
  CHECK(contains(refusal([] { LensFit(ChessboardSize{7, 6, 25}).fit(); }), "found in 0 pictures"));
}

TEST_CASE("a camera's place follows from the arena's corners") {
  // Proves that four corners, seen through a known lens, give the place back, and the error of one that is wrong in
  // millimetres.
  const CameraData truth = tilted(LensModel::fisheye, {-0.02, 0.01, -0.005, 0.001});
  const Calibration camera(truth);
  std::vector<Point> corners;
  for (const Point& at : {Point{-0.5, 0.5}, Point{0.5, 0.5}, Point{0.5, -0.5}, Point{-0.5, -0.5}})
    corners.push_back(*camera.to_pixel(at, 0));
  const CameraData placed = place_camera(truth.lens, corners, 1, 1);
  for (int i = 0; i < 3; ++i) CHECK(placed.translation_m[i] == doctest::Approx(truth.translation_m[i]).epsilon(1e-4));
  CHECK(placed.error_mm < 0.01);
  std::vector<Point> off = corners;
  off[0].x += 20;
  CHECK(place_camera(truth.lens, off, 1, 1).error_mm > 1);
  std::swap(corners[0], corners[1]);
  CHECK(contains(refusal([&] { place_camera(truth.lens, corners, 1, 1); }), "clockwise"));
  CHECK(contains(refusal([&] { place_camera(truth.lens, {{1, 1}}, 1, 1); }), "four"));
}

TEST_CASE("an arena that stands out shows its corners") {
  // Proves that a turned, pale arena with robots on it is found to a pixel, the order of the corners, and that a plain
  // floor has none.
  cv::Mat picture(600, 800, CV_8UC3, cv::Scalar(60, 70, 65));
  const std::vector<cv::Point> arena = {{150, 80}, {660, 120}, {620, 520}, {110, 470}};
  cv::fillConvexPoly(picture, arena, cv::Scalar(215, 220, 210), cv::LINE_AA);
  for (int i = 0; i < 8; ++i)
    cv::circle(picture, {200 + 50 * i, 200 + 30 * i}, 12, cv::Scalar(40, 30, 30), cv::FILLED, cv::LINE_AA);
  const std::vector<Point> found = find_arena_corners(picture);
  REQUIRE(found.size() == 4);
  for (int i = 0; i < 4; ++i) CHECK(std::hypot(found[i].x - arena[i].x, found[i].y - arena[i].y) < 2.5);
  CHECK(find_arena_corners(cv::Mat(600, 800, CV_8UC3, cv::Scalar(60, 70, 65))).empty());
}

TEST_CASE("a pale arena under a lamp that blows out one corner and leaves another dim shows its corners") {
  // Proves it where no level of brightness parts the arena from what is round it, and light is no plane up to white.
  cv::Mat picture(720, 960, CV_8UC3, cv::Scalar(105, 125, 140));
  const std::vector<cv::Point> arena = {{176, 35}, {805, 56}, {783, 685}, {155, 663}};
  cv::fillConvexPoly(picture, arena, cv::Scalar(215, 216, 214), cv::LINE_AA);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const double light = 1.4 - 0.00045 * x - 0.0005 * y;
      for (int c = 0; c < 3; ++c)
        picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(picture.at<cv::Vec3b>(y, x)[c] * light);
    }
  const std::vector<Point> found = find_arena_corners(picture);
  REQUIRE(found.size() == 4);
  for (int i = 0; i < 4; ++i) CHECK(std::hypot(found[i].x - arena[i].x, found[i].y - arena[i].y) < 1);
}

TEST_CASE("what the picture's border cuts is no arena") {
  // Proves that an arena is found whose surroundings are darker on two sides of it, and that these have no corners.
  cv::Mat picture(720, 960, CV_8UC3, cv::Scalar(190, 200, 205));
  const std::vector<cv::Point> dark = {{0, 0}, {700, 0}, {700, 719}, {0, 719}};
  cv::fillConvexPoly(picture, dark, cv::Scalar(40, 60, 75));
  CHECK(find_arena_corners(picture).empty());
  const std::vector<cv::Point> arena = {{142, 31}, {688, 31}, {688, 579}, {142, 579}};
  cv::fillConvexPoly(picture, arena, cv::Scalar(150, 152, 148));
  const std::vector<Point> found = find_arena_corners(picture);
  REQUIRE(found.size() == 4);
  for (int i = 0; i < 4; ++i) CHECK(std::hypot(found[i].x - arena[i].x, found[i].y - arena[i].y) < 2.5);
}

TEST_CASE("an arena as bright as what is around it shows its corners by its colour") {
  // Proves it with robots, a sheet of paper beside it, and light that falls from one side.
  cv::Mat picture(720, 960, CV_8UC3, cv::Scalar(105, 150, 190));
  const std::vector<cv::Point> arena = {{150, 60}, {800, 90}, {790, 680}, {130, 650}};
  cv::fillConvexPoly(picture, arena, cv::Scalar(158, 160, 156), cv::LINE_AA);
  cv::rectangle(picture, cv::Rect(0, 250, 110, 160), cv::Scalar::all(250), cv::FILLED);
  for (int i = 0; i < 9; ++i)
    cv::circle(picture, cv::Point(250 + 200 * (i % 3), 180 + 180 * (i / 3)), 26, cv::Scalar::all(40), cv::FILLED,
               cv::LINE_AA);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) picture.at<cv::Vec3b>(y, x) *= 0.9 + 0.15 * x / picture.cols;
  const std::vector<Point> found = find_arena_corners(picture);
  REQUIRE(found.size() == 4);
  for (int i = 0; i < 4; ++i) CHECK(std::hypot(found[i].x - arena[i].x, found[i].y - arena[i].y) < 2.5);
}

TEST_CASE("a camera that sees no corner of the arena gets its place from marks") {
  // Proves that points anywhere on the arena do instead of corners, that more of them average clicks that are a little
  // off, and what is refused.
  const CameraData truth = tilted(LensModel::pinhole, {-0.25, 0.06, 0.001, -0.002});
  const Calibration camera(truth);
  std::vector<Mark> marks;
  for (const Point& at :
       {Point{-0.2, 0.3}, Point{0.1, 0.3}, Point{0.3, 0.1}, Point{0.25, -0.2}, Point{-0.1, -0.3}, Point{-0.3, -0.1}})
    marks.push_back({*camera.to_pixel(at, 0), at});
  const CameraData placed = place_camera(truth.lens, marks, 3, 2);
  for (int i = 0; i < 3; ++i) CHECK(placed.translation_m[i] == doctest::Approx(truth.translation_m[i]).epsilon(1e-4));
  CHECK(placed.error_mm < 0.01);
  CHECK(placed.arena_width_m == 3);
  for (std::size_t i = 0; i < marks.size(); ++i) marks[i].in_pixels.x += i % 2 ? 0.5 : -0.5;
  const Calibration nearly(place_camera(truth.lens, marks, 3, 2));
  const auto middle =
      nearly.to_arena(*camera.to_pixel({0, 0}, hal::kilobot::board_height_m), hal::kilobot::board_height_m);
  CHECK(std::hypot(middle->x, middle->y) < 0.0008);
  CHECK(contains(refusal([&] { place_camera(truth.lens, std::span(marks).first(3), 3, 2); }), "four"));
  const std::vector<Mark> line = {{*camera.to_pixel({-0.3, 0}, 0), {-0.3, 0}},
                                  {*camera.to_pixel({-0.1, 0}, 0), {-0.1, 0}},
                                  {*camera.to_pixel({0.1, 0}, 0), {0.1, 0}},
                                  {*camera.to_pixel({0.3, 0}, 0), {0.3, 0}}};
  CHECK(contains(refusal([&] { place_camera(truth.lens, line, 3, 2); }), "one line"));
}
