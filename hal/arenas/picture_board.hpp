// Where an arena shows what its cameras see, for who watches a lab from afar. Nobody watches unless somebody is
// attached, so that pictures are made only when they are wanted.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "hal/types.hpp"

namespace arkmesh::hal {

// Where an arena lies on a camera's pictures.
struct PictureFrame {
  std::string camera;
  int width_px = 0, height_px = 0;
  // Row by row: (x, y, 1) in metres of the arena frame to pixels, x right, y down, from the picture's upper left corner
  // (so the middle of the first pixel is at 0.5, 0.5).
  std::array<double, 9> arena_to_px{};
};

class PictureWatcher {
 public:
  virtual ~PictureWatcher() = default;
  virtual bool wants_pictures() const = 0;
  virtual void set_frame(const PictureFrame& frame) = 0;
  // `at`: lab time when it was taken.
  virtual void show_picture(const std::string& camera, LabTime at, std::span<const std::byte> jpeg) = 0;
};

class PictureBoard {
 public:
  // Null: nobody. Who is attached outlives the board, or takes itself off.
  void attach(PictureWatcher* watcher) { watcher_ = watcher; }
  // Null while nobody wants pictures.
  PictureWatcher* watcher() const { return watcher_ && watcher_->wants_pictures() ? watcher_ : nullptr; }

 private:
  PictureWatcher* watcher_ = nullptr;
};

}  // namespace arkmesh::hal
