// Records from anywhere: what is damaged is named, what is cut ends there, and nothing takes much memory.
#include "testbed/raw_folder.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <sstream>
#include <string>
#include <vector>

using namespace arkmesh;

namespace {

// What is said of lines behind the right head; empty: they can be read.
template <class Lines>
std::string complaint_of(const std::string& text) {
  std::istringstream in(text);
  try {
    for (Lines lines(in, "file.txt"); lines.next();) {
    }
  } catch (const testbed::RecordError& wrong) {
    return wrong.what();
  }
  return {};
}

struct WrongText {
  std::string text, said;
};

}  // namespace

TEST_CASE("record: lines that no record has are refused with their number") {
  // Proves that whatever stands in serial.txt and looks.txt is read, or refused with the line and what is wrong there;
  // a last line that was cut when the lab was killed is left out.
  const std::string serial = "# arkmesh serial line 1\n", looks = "# arkmesh looks 1\n";
  for (const WrongText& wrong : std::vector<WrongText>{
           {"", "does not begin with"},
           {"hello\n", "does not begin with"},
           {"# arkmesh serial line 1", "does not begin with"},
           {serial + "wrote 55\n", "file.txt:2: this line does not begin with a time"},
           {serial + "-1 open\n", "file.txt:2: this line does not begin with a time"},
           {serial + "604800000001 open\n", "file.txt:2: this line does not begin with a time"},
           {serial + "5 open\n4 end\n", "file.txt:3: this line has an earlier time"},
           {serial + "5 burst 55\n", "file.txt:2: this line is not an entry of a serial line"},
           {serial + "5 wrote 5\n", "file.txt:2: this line does not contain whole bytes"},
           {serial + "5 wrote 5g\n", "file.txt:2: this line does not contain whole bytes"},
           {serial + "5 wrote \n", "file.txt:2: this line does not contain whole bytes"},
           {serial + "5 wrote " + std::string(70'000, '5') + "\n", "file.txt:2: this line is longer than any line"}}) {
    const std::string why = complaint_of<testbed::SerialLines>(wrong.text);
    CAPTURE(why);
    CHECK(why.find(wrong.said) != std::string::npos);
  }
  CHECK(complaint_of<testbed::SerialLines>(serial + "5 open port\n7 heard 00ff\n7 closed\n9 wro").empty());

  for (const WrongText& wrong : std::vector<WrongText>{
           {serial, "does not begin with"},
           {looks + "1 2 3\n", "file.txt:2: this line is neither a look nor a frame"},
           {looks + "look 1\n", "is neither a look nor a frame"},
           {looks + "frame 1 2 3\n", "is neither a look nor a frame"},
           {looks + "frame 4294967296 2\n", "is neither a look nor a frame"},
           {looks + "look 1 1\n", "has another number of cameras"},
           {looks + "look 1 1 - - - - -\n", "has more than 4 cameras"},
           {looks + "look 1 1 -\nlook 2 2 - -\n", "file.txt:3: this line has another number of cameras"},
           {looks + "look 2 2 -\nlook 1 2 -\n", "has an earlier time"},
           {looks + "look 1 1 ../../etc/passwd@1\n", "names no picture in the form of a record"},
           {looks + "look 1 1 00/../1.png@1\n", "names no picture in the form of a record"},
           {looks + "look 1 1 000001.png\n", "names no picture in the form of a record"},
           {looks + "look 1 1 .png@1\n", "names no picture in the form of a record"}}) {
    const std::string why = complaint_of<testbed::LookLines>(wrong.text);
    CAPTURE(why);
    CHECK(why.find(wrong.said) != std::string::npos);
  }
  CHECK(
      complaint_of<testbed::LookLines>(looks + "look 1 2 000000.jpg@1 lost\nframe 0 0\nlook 2 2 - -\nlook 3").empty());
}

TEST_CASE("record: a picture's size by its head") {
  // Proves that width and height are read from what OpenCV writes, and from nothing that is cut.
  for (const char* kind : {".png", ".jpg"}) {
    CAPTURE(kind);
    std::vector<std::uint8_t> bytes;
    cv::imencode(kind, cv::Mat(50, 70, CV_8UC3, cv::Scalar(1, 2, 3)), bytes);
    CHECK(testbed::picture_size(bytes) == std::pair(70, 50));
    CHECK_FALSE(testbed::picture_size(std::span(bytes).first(20)).has_value());
  }
  CHECK_FALSE(testbed::picture_size(std::vector<std::uint8_t>(100, 0xFF)).has_value());
  CHECK_FALSE(testbed::picture_size({}).has_value());
}
