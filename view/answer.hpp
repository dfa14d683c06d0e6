// What a viewer gets for something that it said.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace arkmesh::view {

class Connection;

// JSON as viewers get it; what is no UTF-8 is replaced.
std::string text_of(const nlohmann::json& value);

// What one viewer gets for something that it said, in the order of calls. A copy answers later; when the viewer has
// left meanwhile, nothing happens.
class Answer {
 public:
  // `request`: the number that the viewer gave; null: it gave none.
  Answer(std::weak_ptr<Connection> viewer, nlohmann::json request)
      : viewer_(std::move(viewer)), request_(std::move(request)) {}

  // One recorded message (kind 1) or picture (kind 2). `t_us` is lab time from the run's start, in microseconds; `lab`
  // an index of about()'s labs. False: more waits for that viewer than the server holds
  // (ViewerOutbox::max_answer_bytes), and the message was not taken; refuse() then, so that the viewer asks for less.
  bool message(int lab, std::int64_t t_us, std::string_view channel, std::span<const std::byte> data);
  bool picture(int lab, std::int64_t t_us, std::string_view camera, std::span<const std::byte> jpeg);
  // {"done": {"request": n, ...}} with the members of `what`, an object. False as message().
  bool done(nlohmann::json what = nlohmann::json::object());
  // {"refused": {"request": n, "why": "one sentence"}}
  void refuse(std::string_view why);

 private:
  bool add(int kind, int lab, std::int64_t t_us, std::string_view channel, std::span<const std::byte> data);

  std::weak_ptr<Connection> viewer_;
  nlohmann::json request_;
};

}  // namespace arkmesh::view
