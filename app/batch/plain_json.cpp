#include "app/batch/plain_json.hpp"

#include "hal/files/whole_file.hpp"

namespace arkmesh::app {
namespace {

constexpr std::uintmax_t max_bytes = 64 << 20;

// Null when there is no such member.
const nlohmann::json* member(const nlohmann::json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? &*found : nullptr;
}

}  // namespace

nlohmann::json read_json(const std::filesystem::path& file) {
  const auto text = hal::whole_file(file, max_bytes);
  nlohmann::json out = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
  return out.is_discarded() ? nlohmann::json() : out;
}

std::string text_in(const nlohmann::json& object, const char* key, const std::string& otherwise) {
  const nlohmann::json* const found = member(object, key);
  return found && found->is_string() ? found->get<std::string>() : otherwise;
}

const nlohmann::json& object_in(const nlohmann::json& object, const char* key) {
  static const nlohmann::json none = nlohmann::json::object();
  const nlohmann::json* const found = member(object, key);
  return found && found->is_object() ? *found : none;
}

}  // namespace arkmesh::app
