// See picture_changes.hpp.
#include "tests/support/pictures/picture_changes.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/support/pictures/photo_effects.hpp"

namespace arkmesh::tests {
namespace {

PictureChange pixels(std::string name, const std::function<void(cv::Mat&)>& change, bool keeps_colours = true) {
  return {std::move(name), [change](const Scene& scene) { return changed(scene, change); }, keeps_colours};
}

PictureChange moved(std::string name, const std::function<std::pair<cv::Matx33d, cv::Size>(cv::Size)>& move) {
  return {std::move(name), [move](const Scene& scene) {
            const auto [matrix, size] = move(scene.bgr.size());
            return warped(scene, matrix, size);
          }};
}

}  // namespace

std::vector<PictureChange> picture_changes() {
  std::vector<PictureChange> list;
  list.push_back(pixels("as it is", [](cv::Mat&) {}));
  list.push_back(moved("turned 90 deg", [](cv::Size s) {
    return std::pair(cv::Matx33d(0, -1, s.height - 1, 1, 0, 0, 0, 0, 1), cv::Size(s.height, s.width));
  }));
  list.push_back(moved("turned 33 deg", [](cv::Size s) {
    const double c = std::cos(0.576), d = std::sin(0.576), big = std::hypot(s.width, s.height);
    return std::pair(cv::Matx33d(c, -d, big / 2 - c * s.width / 2 + d * s.height / 2, d, c,
                                 big / 2 - d * s.width / 2 - c * s.height / 2, 0, 0, 1),
                     cv::Size(static_cast<int>(big), static_cast<int>(big)));
  }));
  list.push_back(
      moved("mirrored", [](cv::Size s) { return std::pair(cv::Matx33d(-1, 0, s.width - 1, 0, 1, 0, 0, 0, 1), s); }));
  list.push_back(pixels("gamma 0.6", [](cv::Mat& m) { apply_gamma(m, 0.6); }));
  list.push_back(pixels("gamma 1.6", [](cv::Mat& m) { apply_gamma(m, 1.6); }));
  list.push_back(pixels("brightness 0.3", [](cv::Mat& m) { m.convertTo(m, -1, 0.3, 0); }));
  list.push_back(pixels("brightness 0.6", [](cv::Mat& m) { m.convertTo(m, -1, 0.6, 0); }));
  list.push_back(pixels("brightness 1.4", [](cv::Mat& m) { m.convertTo(m, -1, 1.4, 0); }));
  list.push_back(pixels("light 0.4..1.3 across", [](cv::Mat& m) {
    multiply_by(m, [](double x, double y) { return 0.4 + 0.9 * (0.7 * x + 0.3 * y); });
  }));
  list.push_back(pixels("vignette", [](cv::Mat& m) {
    multiply_by(m, [](double x, double y) { return 1.15 - 1.4 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5)); });
  }));
  list.push_back(pixels("noise 8", [](cv::Mat& m) { add_noise(m, 8, 1); }));
  list.push_back(pixels("noise 16", [](cv::Mat& m) { add_noise(m, 16, 2); }));
  list.push_back(pixels("blur 1.5 px", [](cv::Mat& m) { cv::GaussianBlur(m, m, {}, 1.5); }));
  list.push_back(pixels("blur 3 px", [](cv::Mat& m) { cv::GaussianBlur(m, m, {}, 3); }));
  list.push_back(pixels("motion blur 7 px", [](cv::Mat& m) { cv::blur(m, m, {7, 1}); }));
  list.push_back(pixels("sharpened", [](cv::Mat& m) {
    cv::Mat soft;
    cv::GaussianBlur(m, soft, {}, 1.5);
    cv::addWeighted(m, 2.2, soft, -1.2, 0, m);
  }));
  list.push_back(pixels("JPEG 60", [](cv::Mat& m) { compress(m, 60); }));
  list.push_back(pixels("JPEG 25", [](cv::Mat& m) { compress(m, 25); }));
  list.push_back(pixels("warm light", [](cv::Mat& m) { cv::multiply(m, cv::Scalar(0.75, 0.95, 1.1), m); }));
  list.push_back(pixels(
      "hue +25 deg", [](cv::Mat& m) { turn_hue(m, 12); }, false));
  list.push_back(pixels(
      "grey", [](cv::Mat& m) { cv::cvtColor(m, m, cv::COLOR_BGR2GRAY), cv::cvtColor(m, m, cv::COLOR_GRAY2BGR); },
      false));
  list.push_back(pixels(
      "negative", [](cv::Mat& m) { cv::bitwise_not(m, m); }, false));
  list.push_back(moved("seen at an angle", [](cv::Size s) {
    return std::pair(cv::Matx33d(1, 0, 0, 0, 1, 0, 0.12 / s.width, 0.08 / s.height, 1), s);
  }));
  list.push_back({"d 34, noise 8, JPEG 60, dim", [](const Scene& scene) {
                    Scene out = with_diameter(scene, 34);
                    out.bgr.convertTo(out.bgr, -1, 0.7, 0), add_noise(out.bgr, 8, 3), compress(out.bgr, 60);
                    return out;
                  }});
  list.push_back({"d 20, noise 4, blur 0.7", [](const Scene& scene) {
                    Scene out = with_diameter(scene, 20);
                    cv::GaussianBlur(out.bgr, out.bgr, {}, 0.7), add_noise(out.bgr, 4, 4);
                    return out;
                  }});
  return list;
}

}  // namespace arkmesh::tests
