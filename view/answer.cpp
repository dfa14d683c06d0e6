#include "view/answer.hpp"

#include "view/connection.hpp"
#include "view/viewer_outbox.hpp"

namespace arkmesh::view {

using nlohmann::json;

std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

bool Answer::add(int kind, int lab, std::int64_t t_us, std::string_view channel, std::span<const std::byte> data) {
  const auto number = request_.is_number_unsigned() ? request_.get<std::uint32_t>() : 0;
  const auto viewer = viewer_.lock();
  return viewer && viewer->outbox().answer(frame(static_cast<Kind>(kind), lab, number, t_us, channel, data), false);
}
bool Answer::message(int lab, std::int64_t t_us, std::string_view channel, std::span<const std::byte> data) {
  return add(static_cast<int>(Kind::message), lab, t_us, channel, data);
}
bool Answer::picture(int lab, std::int64_t t_us, std::string_view camera, std::span<const std::byte> jpeg) {
  return add(static_cast<int>(Kind::picture), lab, t_us, camera, jpeg);
}
bool Answer::done(json what) {
  what["request"] = request_;
  const auto viewer = viewer_.lock();
  const bool taken = viewer && viewer->outbox().answer(text_of({{"done", std::move(what)}}), true);
  if (taken) viewer->send();
  return taken;
}
// In its place among the answers; ahead of them when they leave no room.
void Answer::refuse(std::string_view why) {
  const auto viewer = viewer_.lock();
  if (!viewer) return;
  const std::string words = text_of({{"refused", {{"request", request_}, {"why", why}}}});
  if (!viewer->outbox().answer(words, true)) viewer->outbox().say(words);
  viewer->send();
}

}  // namespace arkmesh::view
