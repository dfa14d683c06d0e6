#include "tracker/camera/calibration_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/algorithm/hex.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "hal/files/replace_file.hpp"

namespace arkmesh::tracker {
namespace {

constexpr std::size_t max_cameras = 16, max_landmarks_read = 1000;
constexpr std::uintmax_t max_file_bytes = 16u << 20;
constexpr const char* make_anew = "create the file again with arkmesh calibrate";

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& sentence) {
  throw std::runtime_error(fmt::format("{}: {}", file.string(), sentence));
}

// YAML without its first line, as ROS writes it, is YAML, too.
cv::FileStorage open_file(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > max_file_bytes) refuse(file, "is not a calibration: it cannot be read, or is too large");
  std::ifstream in(file, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) refuse(file, "is empty");
  if (!text.starts_with("%YAML") && text[first] != '<' && text[first] != '{')
    text = "%YAML:1.0\n" + std::string(text.compare(first, 3, "---") == 0 ? "" : "---\n") + text;
  return {text, cv::FileStorage::READ | cv::FileStorage::MEMORY};
}

// Reads one camera's keys; every error names file, camera and key.
class CameraNode {
 public:
  CameraNode(cv::FileNode node, const std::filesystem::path& file, const std::string& camera)
      : node_(node), file_(file), camera_(camera.empty() ? "" : fmt::format("camera {}: ", camera)) {}

  std::vector<double> numbers(const char* key, std::size_t least, std::size_t most) const {
    const cv::FileNode node = node_[key];
    std::vector<double> list;
    if (node.isSeq() && node.size() <= 16) {
      for (const cv::FileNode& element : node)
        if (element.isReal() || element.isInt()) list.push_back(static_cast<double>(element));
    } else if (node.isMap() && node["data"].isSeq() && node["data"].size() <= 16) {  // a matrix of OpenCV or ROS
      for (const cv::FileNode& element : node["data"])
        if (element.isReal() || element.isInt()) list.push_back(static_cast<double>(element));
    }
    if (list.size() >= least && list.size() <= most) return list;
    refuse(file_, fmt::format("{}{} should hold {} numbers; {}", camera_, key,
                              least == most ? std::to_string(least) : fmt::format("{} to {}", least, most), make_anew));
  }

  double number(const char* key) const {
    const cv::FileNode node = node_[key];
    if (node.isReal() || node.isInt()) return static_cast<double>(node);
    refuse(file_, fmt::format("{}{} is missing or no number; {}", camera_, key, make_anew));
  }
  double number(const char* key, double otherwise) const { return node_[key].empty() ? otherwise : number(key); }

  int pixels(const char* key) const {
    const double value = number(key);
    if (value >= 1 && value <= 100'000) return static_cast<int>(value);
    refuse(file_, fmt::format("{}{} must be 1 to 100000 pixels; {}", camera_, key, make_anew));
  }

  // Grey levels as pairs of hexadecimal digits.
  std::vector<std::uint8_t> bytes(const char* key, int count) const {
    const cv::FileNode node = node_[key];
    std::vector<std::uint8_t> out;
    try {
      if (node.isString()) boost::algorithm::unhex(static_cast<std::string>(node), std::back_inserter(out));
    } catch (const boost::algorithm::hex_decode_error&) {
      out.clear();
    }
    if (std::ssize(out) == count) return out;
    refuse(file_, fmt::format("{}a landmark's {} should be {} bytes in hexadecimal digits; {}", camera_, key, count,
                              make_anew));
  }

 private:
  cv::FileNode node_;
  const std::filesystem::path& file_;
  std::string camera_;
};

template <std::size_t n>
void copy(const std::vector<double>& from, std::array<double, n>& to) {
  std::copy(from.begin(), from.end(), to.begin());
}

std::string in_hex(const std::vector<std::uint8_t>& bytes) {
  std::string out;
  boost::algorithm::hex_lower(bytes, std::back_inserter(out));
  return out;
}

std::vector<Landmark> read_landmarks(const cv::FileNode& camera, const std::filesystem::path& file,
                                     const std::string& name) {
  const cv::FileNode nodes = camera["landmarks"];
  if (!nodes.empty() && (!nodes.isSeq() || nodes.size() > max_landmarks_read))
    refuse(file, fmt::format("camera {}: landmarks should be a list; {}", name, make_anew));
  std::vector<Landmark> out;
  for (const cv::FileNode& node : nodes) {
    if (!node.isMap()) refuse(file, fmt::format("camera {}: a landmark is not a map; {}", name, make_anew));
    const CameraNode keys(node, file, name);
    out.push_back({.x_px = keys.pixels("x_px"),
                   .y_px = keys.pixels("y_px"),
                   .grey = keys.bytes("grey", Landmark::side * Landmark::side),
                   .rough = keys.bytes("rough", Landmark::rough_side * Landmark::rough_side)});
  }
  return out;
}

NamedCamera read_camera(const cv::FileNode& node, const std::filesystem::path& file, std::size_t number) {
  NamedCamera camera;
  camera.name = node["name"].isString() ? static_cast<std::string>(node["name"]) : fmt::format("{}", number);
  const CameraNode keys(node, file, camera.name);
  CameraData& data = camera.data;
  const std::string lens = node["lens"].empty()      ? "pinhole"
                           : node["lens"].isString() ? static_cast<std::string>(node["lens"])
                                                     : "";
  if (lens != "pinhole" && lens != "fisheye")
    refuse(file, fmt::format("camera {}: lens must be \"pinhole\" or \"fisheye\"", camera.name));
  data.lens.model = lens == "fisheye" ? LensModel::fisheye : LensModel::pinhole;
  data.lens.width_px = keys.pixels("image_width");
  data.lens.height_px = keys.pixels("image_height");
  copy(keys.numbers("camera_matrix", 9, 9), data.lens.matrix);
  data.lens.distortion = keys.numbers("distortion_coefficients", 0, 8);
  copy(keys.numbers("rotation", 9, 9), data.rotation);
  copy(keys.numbers("translation", 3, 3), data.translation_m);
  data.arena_width_m = keys.number("arena_width_m", 1);
  data.arena_height_m = keys.number("arena_height_m", 1);
  data.error_px = keys.number("error_px", 0);
  data.error_mm = keys.number("error_mm", 0);
  try {
    const Calibration possible(data);
  } catch (const std::invalid_argument& wrong) {
    refuse(file, fmt::format("camera {}: {}", camera.name, wrong.what()));
  }
  camera.landmarks = read_landmarks(node, file, camera.name);
  return camera;
}

}  // namespace

std::vector<NamedCamera> read_calibrations(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    refuse(file, "there is no such calibration file; create one with arkmesh calibrate");
  try {
    const cv::FileStorage in = open_file(file);
    const cv::FileNode cameras = in.isOpened() ? in["cameras"] : cv::FileNode();
    if (cameras.empty() && in.isOpened() && !in["camera_matrix"].empty())
      refuse(file, "describes only a lens, not the camera's pose; add the pose with arkmesh calibrate --intrinsics");
    if (!cameras.isSeq() || cameras.size() == 0)
      refuse(file,
             "contains no cameras; create a calibration with arkmesh calibrate (from an ARK calibration: with "
             "--import-ark)");
    if (cameras.size() > max_cameras)
      refuse(file, fmt::format("contains {} cameras; the limit is {}", cameras.size(), max_cameras));
    std::vector<NamedCamera> read;
    for (const cv::FileNode& node : cameras) {
      if (!node.isMap()) refuse(file, fmt::format("its list of cameras contains something else; {}", make_anew));
      read.push_back(read_camera(node, file, read.size()));
    }
    return read;
  } catch (const cv::Exception&) {
    refuse(file, fmt::format("is damaged or not a YAML file as OpenCV writes it; {}", make_anew));
  }
}

Lens read_intrinsics(const std::filesystem::path& file) try {
  const cv::FileStorage in = open_file(file);
  const cv::FileNode root = in.root();
  // as older versions of OpenCV wrote it
  const bool older = root["camera_matrix"].empty() && !root["Camera_Matrix"].empty();
  if (!older && root["camera_matrix"].empty())
    refuse(file, "is not a calibration of OpenCV or ROS: it has no camera_matrix");
  const CameraNode keys(root, file, "");
  Lens lens;
  lens.width_px = keys.pixels(older ? "image_Width" : "image_width");
  lens.height_px = keys.pixels(older ? "image_Height" : "image_height");
  copy(keys.numbers(older ? "Camera_Matrix" : "camera_matrix", 9, 9), lens.matrix);
  lens.distortion = keys.numbers(older ? "Distortion_Coefficients" : "distortion_coefficients", 4, 8);
  const std::string model =
      root["distortion_model"].isString() ? static_cast<std::string>(root["distortion_model"]) : "plumb_bob";
  const bool fisheye = model == "equidistant" || model == "fisheye" || static_cast<int>(root["fisheye_model"]) == 1;
  if (!fisheye && model != "plumb_bob" && model != "rational_polynomial")
    refuse(file, fmt::format("its distortion_model {} is unknown; arkmesh knows plumb_bob, rational_polynomial, "
                             "equidistant",
                             model));
  lens.model = fisheye ? LensModel::fisheye : LensModel::pinhole;
  CameraData data;
  data.lens = lens;
  try {
    const Calibration possible(data);
  } catch (const std::invalid_argument& wrong) {
    refuse(file, wrong.what());
  }
  return lens;
} catch (const cv::Exception&) {
  refuse(file, "is not YAML or XML as OpenCV or ROS write calibrations");
}

NamedCamera read_calibration(const std::filesystem::path& file, const std::string& name) {
  const std::vector<NamedCamera> cameras = read_calibrations(file);
  if (name.empty() && cameras.size() == 1) return cameras[0];
  std::string names;
  for (const NamedCamera& camera : cameras) {
    if (camera.name == name) return camera;
    names += (names.empty() ? "" : ", ") + camera.name;
  }
  refuse(file, name.empty() ? fmt::format("contains several cameras; name one: {}", names)
                            : fmt::format("contains no camera {}; it has {}", name, names));
}

void write_calibrations(const std::filesystem::path& file, const std::vector<NamedCamera>& cameras) {
  try {
    cv::FileStorage out(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    const auto matrix = [](const auto& values, int rows) {
      return cv::Mat(rows, static_cast<int>(values.size()) / rows, CV_64F, const_cast<double*>(values.data())).clone();
    };
    out << "cameras"
        << "[";
    for (const NamedCamera& camera : cameras) {
      const CameraData& data = camera.data;
      out << "{"
          << "name" << camera.name << "lens" << (data.lens.model == LensModel::fisheye ? "fisheye" : "pinhole");
      out << "image_width" << data.lens.width_px << "image_height" << data.lens.height_px;
      out << "camera_matrix" << matrix(data.lens.matrix, 3) << "distortion_coefficients" << data.lens.distortion;
      out << "rotation" << matrix(data.rotation, 3) << "translation" << matrix(data.translation_m, 3);
      out << "arena_width_m" << data.arena_width_m << "arena_height_m" << data.arena_height_m;
      out << "error_px" << data.error_px << "error_mm" << data.error_mm;
      if (!camera.landmarks.empty())
        out << "landmarks"
            << "[";
      for (const Landmark& landmark : camera.landmarks)
        out << "{"
            << "x_px" << landmark.x_px << "y_px" << landmark.y_px << "grey" << in_hex(landmark.grey) << "rough"
            << in_hex(landmark.rough) << "}";
      if (!camera.landmarks.empty()) out << "]";
      out << "}";
    }
    out << "]";
    hal::must_replace_file(file, out.releaseAndGetString());
  } catch (const cv::Exception& error) {
    refuse(file, fmt::format("cannot be written: {}", error.err));
  }
}

}  // namespace arkmesh::tracker
