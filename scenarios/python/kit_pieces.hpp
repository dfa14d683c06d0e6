// The pieces of the kit that a scenario in Python has asked for in begin(): the lab computes them, and the scenario
// gets arrays with each frame.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/lab.hpp"

namespace arkmesh::scenarios::python {

class KitPieces {
 public:
  using Said = nlohmann::ordered_json;

  KitPieces();
  ~KitPieces();

  // What kit.py asks for, in begin(). Throws std::exception with one sentence for settings that make no sense.
  void add(lab::Lab& lab, const Said& asked);
  // What the robots of a frame sense: for each piece [columns, rows x columns numbers], rows as the frame has robots.
  std::string sense(const lab::Lab& lab, const hal::PoseFrame& frame);
  // What is known of pieces themselves since the last boundary: for each [numbers, numbers].
  std::string world() const;
  // What the scenario did with a piece, in answer to the newest frame that was sensed.
  void act(lab::Lab& lab, const Said& done);
  // Once for each answer to a frame, after what was done; and at each boundary, before the scenario is asked.
  void end_frame(lab::Lab& lab);
  void on_period(lab::Lab& lab);

 private:
  struct Piece;
  struct Eyes;
  struct Crowd;
  struct Trail;
  struct Zone;
  struct Tiles;
  struct Towards;
  struct Gps;
  struct Talk;
  struct Shine;
  std::vector<std::unique_ptr<Piece>> pieces_;
  hal::PoseFrame frame_;  // that was sensed last
};

}  // namespace arkmesh::scenarios::python
