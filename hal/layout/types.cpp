#include "hal/layout/types.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace arkmesh::hal::layout {
namespace {

constexpr std::pair<std::string_view, Kind> primitives[] = {
    {"int8_t", Kind::int8},     {"int16_t", Kind::int16}, {"int32_t", Kind::int32},
    {"int64_t", Kind::int64},   {"float", Kind::float32}, {"double", Kind::float64},
    {"boolean", Kind::boolean}, {"byte", Kind::byte},     {"string", Kind::text}};

// Sizes of a type whose members' types are known.
void measure(Type& type) {
  type.is_fixed = true;
  for (const Field& field : type.fields) {
    std::size_t count = 1;
    for (const Dimension& size : field.sizes) {
      if (size.slot >= 0) type.is_fixed = false;
      count *= size.slot >= 0 ? 0 : static_cast<std::size_t>(size.fixed);
    }
    if (field.kind == Kind::text || (field.type && !field.type->is_fixed)) type.is_fixed = false;
    type.least_bytes += count * least_bytes_of(field);
  }
}

}  // namespace

std::size_t least_bytes_of(const Field& field) {
  switch (field.kind) {
    case Kind::int8:
    case Kind::boolean:
    case Kind::byte:
      return 1;
    case Kind::int16:
      return 2;
    case Kind::int32:
    case Kind::float32:
      return 4;
    case Kind::int64:
    case Kind::float64:
      return 8;
    case Kind::text:
      return 5;
    case Kind::record:
      return field.type->least_bytes;
  }
  return 1;
}

std::string unit_of(std::string_view name) {
  constexpr std::string_view units[] = {"m", "um", "rad", "urad", "us", "ms", "s", "kg", "ppm", "hz", "bytes"};
  const std::size_t last = name.rfind('_');
  if (last == std::string_view::npos) return {};
  const auto found = std::ranges::find(units, name.substr(last + 1));
  return found == std::end(units) ? std::string() : *found == "hz" ? "Hz" : std::string(*found);
}

Types::Types(std::string_view json) {
  const nlohmann::json all = nlohmann::json::parse(json, nullptr, false);
  try {
    for (const auto& [name, told] : all.at("types").items()) {
      Type& type = *types_.emplace_back(std::make_unique<Type>());
      type.name = name;
      type.comment = told.at("comment");
      type.fingerprint = std::stoull(told.at("fingerprint").get<std::string>(), nullptr, 16);
      by_name_[name] = by_fingerprint_[type.fingerprint] = &type;
    }
    for (const auto& type : types_) {
      int slots = 0;
      for (const nlohmann::json& told : all["types"][type->name].at("fields")) {
        Field field;
        field.name = told.at("name");
        field.comment = told.at("comment");
        field.unit = unit_of(field.name);
        const std::string kind = told.at("type");
        const auto primitive = std::ranges::find(primitives, kind, &std::pair<std::string_view, Kind>::first);
        field.kind = primitive == std::end(primitives) ? Kind::record : primitive->second;
        if (field.kind == Kind::record) field.type = by_name_.at(kind);
        for (const nlohmann::json& size : told.at("dims")) {
          if (size.is_number()) {
            field.sizes.push_back({size.get<std::int32_t>(), -1});
            continue;
          }
          const auto teller = std::ranges::find(type->fields, size.get<std::string>(), &Field::name);
          if (teller == type->fields.end()) throw std::out_of_range("size");
          if (teller->slot < 0) teller->slot = slots++;
          if (slots > Type::max_slots) throw std::out_of_range("slots");
          field.sizes.push_back({0, teller->slot});
        }
        type->fields.push_back(std::move(field));
      }
    }
    for (const auto& [channel, name] : all.at("channels").items()) by_channel_[channel] = by_name_.at(name);
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("the list of message types is damaged: {}", error.what()));
  }
  // members before what they are members of
  std::vector<const Type*> done;
  const auto is_done = [&](const Type* type) { return std::ranges::find(done, type) != done.end(); };
  while (done.size() < types_.size()) {
    const std::size_t before = done.size();
    for (const auto& type : types_)
      if (!is_done(type.get()) &&
          std::ranges::all_of(type->fields, [&](const Field& f) { return !f.type || is_done(f.type); })) {
        measure(*type);
        done.push_back(type.get());
      }
    if (done.size() == before) throw std::runtime_error("the list of message types is damaged: a type contains itself");
  }
}

const Type* Types::find(std::string_view name) const {
  const auto found = by_name_.find(name);
  return found == by_name_.end() ? nullptr : found->second;
}

const Type* Types::find(std::uint64_t fingerprint) const {
  const auto found = by_fingerprint_.find(fingerprint);
  return found == by_fingerprint_.end() ? nullptr : found->second;
}

const Type* Types::of_channel(std::string_view channel) const {
  const auto found = by_channel_.find(channel.substr(channel.rfind('/') + 1));  // npos + 1 is 0
  return found == by_channel_.end() ? nullptr : found->second;
}

const Types& types() {
  static const Types known(types_json());
  return known;
}

}  // namespace arkmesh::hal::layout
