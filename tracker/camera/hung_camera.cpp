#include "tracker/camera/hung_camera.hpp"

#include <algorithm>
#include <cstring>

namespace arkmesh::tracker {
namespace {

bool equal(const cv::Mat& a, const cv::Mat& b) {
  const std::size_t row_bytes = static_cast<std::size_t>(a.cols) * a.elemSize();
  for (int row = 0; row < a.rows; ++row)
    if (std::memcmp(a.ptr(row), b.ptr(row), row_bytes) != 0) return false;
  return true;
}

// Whether more than half of the pixels differ, in every eighth row.
bool differ_everywhere(const cv::Mat& a, const cv::Mat& b) {
  int differ = 0, looked_at = 0;
  for (int y = 0; y < a.rows; y += 8) {
    const auto *const one = a.ptr<cv::Vec3b>(y), *const other = b.ptr<cv::Vec3b>(y);
    for (int x = 0; x < a.cols; ++x) differ += one[x] != other[x];
    looked_at += a.cols;
  }
  return 2 * differ > looked_at;
}

}  // namespace

HungCamera::Verdict HungCamera::look(hal::LabTime now, const cv::Mat& bgr, bool changes) {
  if (changes && !changes_) changes_since_ = now;
  changes_ = changes;
  const bool comparable = bgr.size() == last_.size() && bgr.type() == last_.type();
  if (!comparable || !equal(bgr, last_)) {
    noisy_ = comparable && differ_everywhere(bgr, last_) ? noisy_ + 1 : 0;
    last_ = bgr;
    changed_at_ = now;
    hung_ = false;
    return Verdict::changed;
  }
  hung_ = hung_ || (noisy_ >= noisy_pictures && now - changed_at_ >= noisy_hangs_after) ||
          (changes_ && now - std::max(changed_at_, changes_since_) >= quiet_hangs_after);
  return hung_ ? Verdict::hung : Verdict::same;
}

}  // namespace arkmesh::tracker
