// `arkmesh track` on pictures: what it prints, draws, and says of bad input.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/support/pictures/robot_pictures.hpp"
#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {
namespace {

using namespace std::chrono_literals;

struct Ran {
  int code = -1;
  std::string output;
};

Ran track(const std::vector<std::string>& arguments) {
  TemporaryFolder folder;
  std::vector<std::string> all = {"track"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  Process process(ARKMESH_PROGRAM, all, folder.path() / "out.txt");
  const auto code = process.wait(300s);
  return {code.value_or(-1), process.output()};
}

// Progress may stand before it.
nlohmann::json printed_list(const std::string& output) {
  return nlohmann::json::parse(output.substr(std::min(output.find('['), output.size())));
}

const std::string pictures = std::string(ARKMESH_TEST_DATA) + "/kilobot-images/";

TEST_CASE("track prints a picture's robots as JSON") {
  // Proves: the list has every robot with its keys, null where an unlit LED leaves something unknown, and headings
  // turned by the offset.
  const Ran ran = track({pictures + "table_6robots.png", "--json", "--led-offset", "90"});
  REQUIRE(ran.code == 0);
  const nlohmann::json list = printed_list(ran.output);
  REQUIRE(list.size() == 6);
  int unlit = 0;
  for (const nlohmann::json& robot : list) {
    for (const char* key : {"x_px", "y_px", "r_px", "led", "led_x_px", "led_y_px", "heading_rad", "led_heading_rad"})
      CHECK(robot.contains(key));
    CHECK(robot.size() == 8);
    if (robot["led"] == "off") {
      ++unlit;
      for (const char* key : {"led_x_px", "led_y_px", "heading_rad", "led_heading_rad"}) CHECK(robot[key].is_null());
      continue;
    }
    const double led_heading = std::atan2(robot["y_px"].get<double>() - robot["led_y_px"].get<double>(),
                                          robot["led_x_px"].get<double>() - robot["x_px"].get<double>());
    CHECK(robot["led_heading_rad"].get<double>() == doctest::Approx(led_heading).epsilon(0.01));
    const double turned = robot["heading_rad"].get<double>() - robot["led_heading_rad"].get<double>();
    CHECK(std::abs(std::remainder(turned - M_PI / 2, 2 * M_PI)) < 1e-4);
  }
  CHECK(unlit == 1);
}

TEST_CASE("track explains one picture, and says when it cannot") {
  // Proves: the picture is drawn, also where nothing is found; folders and videos are refused in one sentence; a grey
  // picture's LEDs are "unknown", without a heading.
  TemporaryFolder folder;
  const std::string explained = (folder.path() / "explained.png").string(),
                    empty = (folder.path() / "empty.png").string(), grey = (folder.path() / "grey.png").string();
  REQUIRE(track({pictures + "table_6robots.png", "--explain", explained}).code == 0);
  const cv::Mat before = cv::imread(pictures + "table_6robots.png"), drawn = cv::imread(explained);
  REQUIRE(drawn.size() == before.size());
  CHECK(cv::norm(drawn, before, cv::NORM_L1) > 0);
  cv::imwrite(empty, cv::Mat(120, 160, CV_8UC3, cv::Scalar(90, 90, 90)));
  REQUIRE(track({empty, "--explain", explained}).code == 0);
  CHECK(cv::imread(explained).cols > 160);
  const Ran refused = track({folder.path().string(), "--explain", explained});
  CHECK(refused.code != 0);
  CHECK(refused.output.find("--explain needs one picture") != std::string::npos);
  cv::imwrite(grey, cv::imread(pictures + "table_6robots.png", cv::IMREAD_GRAYSCALE));
  const Ran ran = track({grey, "--json"});
  for (const nlohmann::json& robot : printed_list(ran.output)) {
    CHECK(robot["led"] == "unknown");
    CHECK(robot["heading_rad"].is_null());
  }
}

TEST_CASE("track goes through a folder of pictures and draws") {
  // Proves: each picture gets its results under its name, and a drawn picture of the same size that differs from the
  // original.
  TemporaryFolder folder;
  for (const char* name : {"bodyguard_f003.png", "bodyguard_f010.png"})
    std::filesystem::copy_file(pictures + name, folder.path() / name);
  std::filesystem::create_directory(folder.path() / "drawn");
  const Ran ran = track({folder.path().string(), "--json", "--png", (folder.path() / "drawn").string()});
  REQUIRE(ran.code == 0);
  const nlohmann::json list = printed_list(ran.output);
  REQUIRE(list.size() == 2);
  CHECK(list[0]["picture"] == "bodyguard_f003.png");
  CHECK(list[0]["robots"].size() == 28);
  CHECK(list[1]["robots"].size() == 28);
  const cv::Mat before = cv::imread(pictures + "bodyguard_f010.png"),
                after = cv::imread((folder.path() / "drawn/bodyguard_f010.png").string());
  REQUIRE(after.size() == before.size());
  CHECK(cv::norm(before, after, cv::NORM_INF) > 50);
}

TEST_CASE("a damaged picture in a folder is named and left out, and the others are not lost") {
  // Proves it for single pictures and for a folder that is followed as a clip: results of the rest, one sentence, exit
  // code 1.
  TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "clip");
  for (const char* name : {"bodyguard_f003.png", "bodyguard_f010.png"})
    std::filesystem::copy_file(pictures + name, folder.path() / "clip" / name);
  std::ofstream(folder.path() / "clip/bodyguard_f005.png") << "these are no pixels";
  const Ran single = track({(folder.path() / "clip").string()});
  CAPTURE(single.output);
  CHECK(single.code == 1);
  CHECK(single.output.find("bodyguard_f005.png is damaged or not a picture") != std::string::npos);
  CHECK(single.output.find("bodyguard_f010.png:\n28 robots") != std::string::npos);
  const std::string csv = (folder.path() / "rows.csv").string();
  const Ran clip = track({(folder.path() / "clip").string(), "--csv", csv});
  CAPTURE(clip.output);
  CHECK(clip.code == 1);
  CHECK(clip.output.find("bodyguard_f005.png is damaged or not a picture") != std::string::npos);
  std::ifstream rows(csv);
  const std::string text(std::istreambuf_iterator<char>(rows), {});
  CHECK(std::count(text.begin(), text.end(), '\n') == 1 + 2 * 28);
}

TEST_CASE("who opens the page of track --serve sees the robots") {
  // Proves, with a real process and OpenCV in a browser's place, that pictures come though nobody watched when it
  // began, and that robots are drawn on them.
  TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "clip");
  for (int i = 0; i < 300; ++i)
    std::filesystem::create_symlink(pictures + "bodyguard_f010.png",
                                    folder.path() / "clip" / (std::to_string(i) + ".png"));
  Process process(ARKMESH_PROGRAM, {"track", (folder.path() / "clip").string(), "--serve", "0"},
                  folder.path() / "out.txt");
  const std::string says = "/arena shows the robots";
  REQUIRE(eventually(300s, [&] { return process.output().find(says) != std::string::npos; }));
  const std::string output = process.output();
  const std::size_t begin = output.find("http://");
  cv::VideoCapture capture(output.substr(begin, output.find(" shows", begin) - begin), cv::CAP_FFMPEG);
  cv::Mat seen;
  REQUIRE(capture.isOpened());
  REQUIRE(capture.read(seen));
  const cv::Mat original = cv::imread(pictures + "bodyguard_f010.png");
  REQUIRE(seen.size() == original.size());
  CHECK(cv::norm(original, seen, cv::NORM_INF) > 80);
  process.signal(SIGINT);
  CHECK(process.wait(300s) == 0);
}

TEST_CASE("track says what is wrong with its source") {
  // Proves: no file, no picture, an empty folder, a place that cannot be written: one sentence each that names it, and
  // exit code 1.
  TemporaryFolder folder;
  std::ofstream(folder.path() / "words.png") << "these are no pixels";
  std::filesystem::create_directory(folder.path() / "empty");
  const std::string words = (folder.path() / "words.png").string(), empty = (folder.path() / "empty").string();
  for (const auto& [arguments, named] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{(folder.path() / "none.png").string()}, "none.png"},
           {{words}, "words.png"},
           {{empty}, "empty"},
           {{"ftp://camera/1"}, "not at ftp"},
           {{"http://127.0.0.1:1/camera"}, "nothing listens at http://127.0.0.1:1/camera"},
           {{"http://127.0.0.1:1/camera", "--seconds", "1"}, "http://127.0.0.1:1/camera"},
           {{pictures + "bodyguard_f003.png", "--png", empty + "/no/folder.png"}, "folder.png"}}) {
    const Ran ran = track(arguments);
    CAPTURE(ran.output);
    CHECK(ran.code == 1);
    CHECK(ran.output.find("arkmesh: ") != std::string::npos);
    CHECK(ran.output.find(named) != std::string::npos);
  }
  CHECK(track({}).code == 2);
  CHECK(track({pictures + "bodyguard_f003.png", "--diameter", "-3"}).code == 2);
  CHECK(track({pictures + "bodyguard_f003.png", "--camera", "north"}).code == 2);
}

}  // namespace
}  // namespace arkmesh::tests
