#include "tracker/calibration_file.hpp"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <stdexcept>

namespace arkmesh::tracker {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& sentence) {
  throw std::runtime_error(fmt::format("{}: {}", file.string(), sentence));
}

std::vector<double> numbers(const cv::FileStorage& in, const std::filesystem::path& file, const char* key, int least, int most) {
  const cv::FileNode node = in[key];
  cv::Mat matrix;
  std::vector<double> list;
  if (node.isSeq()) node >> list;
  else if (node.isMap()) {
    node >> matrix;
    if (matrix.channels() == 1 && !matrix.empty() && matrix.total() <= 16) {
      matrix.convertTo(matrix, CV_64F);
      list.assign(matrix.begin<double>(), matrix.end<double>());
    }
  }
  const int n = static_cast<int>(list.size());
  if (n < least || n > most) refuse(file, fmt::format("{} should hold {} numbers; make the file anew with arkmesh calibrate", key,
                                                      least == most ? std::to_string(least) : fmt::format("{} to {}", least, most)));
  return list;
}

double number(const cv::FileStorage& in, const std::filesystem::path& file, const char* key) {
  const cv::FileNode node = in[key];
  if (!node.isReal() && !node.isInt()) refuse(file, fmt::format("{} is missing or no number; make the file anew with arkmesh calibrate", key));
  return static_cast<double>(node);
}

}  // namespace

Calibration read_calibration(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) refuse(file, "there is no such calibration file; make one with arkmesh calibrate");
  try {
    const cv::FileStorage in(file.string(), cv::FileStorage::READ);
    if (!in.isOpened() || in["arkmesh_calibration"].empty())
      refuse(file, "is no calibration of arkmesh; make one with arkmesh calibrate (an ARK calibration: with its --import-ark)");
    if (number(in, file, "arkmesh_calibration") != 1) refuse(file, "was written by a newer arkmesh; use that, or make it anew");
    CameraData data;
    const cv::FileNode lens = in["lens"];
    const std::string name = lens.isString() ? static_cast<std::string>(lens) : "";
    if (name != "pinhole" && name != "fisheye") refuse(file, "lens must be \"pinhole\" or \"fisheye\"");
    data.lens.model = name == "fisheye" ? LensModel::fisheye : LensModel::pinhole;
    data.lens.width_px = static_cast<int>(number(in, file, "width_px"));
    data.lens.height_px = static_cast<int>(number(in, file, "height_px"));
    const auto copy = [](const std::vector<double>& from, auto& to) { std::copy(from.begin(), from.end(), to.begin()); };
    copy(numbers(in, file, "K", 9, 9), data.lens.matrix);
    data.lens.distortion = numbers(in, file, "distortion", 0, 8);
    copy(numbers(in, file, "R", 9, 9), data.rotation);
    copy(numbers(in, file, "t_m", 3, 3), data.translation_m);
    data.arena_width_m = number(in, file, "arena_width_m");
    data.arena_height_m = number(in, file, "arena_height_m");
    data.error_px = in["error_px"].empty() ? 0 : number(in, file, "error_px");
    data.error_mm = in["error_mm"].empty() ? 0 : number(in, file, "error_mm");
    return Calibration(std::move(data));
  } catch (const std::invalid_argument& wrong) {
    refuse(file, wrong.what());
  } catch (const cv::Exception&) {
    refuse(file, "is damaged or no YAML file as OpenCV writes it; make it anew with arkmesh calibrate");
  }
}

void write_calibration(const std::filesystem::path& file, const CameraData& data) {
  try {
    cv::FileStorage out(file.string(), cv::FileStorage::WRITE | cv::FileStorage::FORMAT_YAML);
    if (!out.isOpened()) refuse(file, "cannot be written");
    const auto matrix = [](const auto& values, int rows) { return cv::Mat(rows, static_cast<int>(values.size()) / rows, CV_64F, const_cast<double*>(values.data())); };
    out << "arkmesh_calibration" << 1;
    out << "lens" << (data.lens.model == LensModel::fisheye ? "fisheye" : "pinhole");
    out << "width_px" << data.lens.width_px << "height_px" << data.lens.height_px;
    out << "K" << matrix(data.lens.matrix, 3);
    out << "distortion" << data.lens.distortion;
    out << "R" << matrix(data.rotation, 3);
    out << "t_m" << matrix(data.translation_m, 3);
    out << "arena_width_m" << data.arena_width_m << "arena_height_m" << data.arena_height_m;
    out << "error_px" << data.error_px << "error_mm" << data.error_mm;
  } catch (const cv::Exception&) {
    refuse(file, "cannot be written");
  }
}

}  // namespace arkmesh::tracker
