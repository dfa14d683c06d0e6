#include "recording/export/proto.hpp"

#include <google/protobuf/descriptor.pb.h>

#include <nlohmann/json.hpp>
#include <set>
#include <vector>

namespace arkmesh::recording {
namespace {

using namespace hal::layout;
namespace pb = google::protobuf;

pb::FieldDescriptorProto::Type type_of_kind(const Field& field) {
  switch (field.kind) {
    case Kind::float32:
      return pb::FieldDescriptorProto::TYPE_FLOAT;
    case Kind::float64:
      return pb::FieldDescriptorProto::TYPE_DOUBLE;
    case Kind::boolean:
      return pb::FieldDescriptorProto::TYPE_BOOL;
    case Kind::text:
      return pb::FieldDescriptorProto::TYPE_STRING;
    case Kind::record:
      return pb::FieldDescriptorProto::TYPE_MESSAGE;
    case Kind::byte:
      return field.sizes.empty() ? pb::FieldDescriptorProto::TYPE_UINT32 : pb::FieldDescriptorProto::TYPE_BYTES;
    default:
      return pb::FieldDescriptorProto::TYPE_SINT64;
  }
}

class ProtoWriter : public Visitor {
 public:
  explicit ProtoWriter(pb::Message& to) : at_{&to} {}

  void value(const Field& field, const Value& value) override {
    const auto [message, reflection, to] = where(field);
    const bool adds = to->is_repeated();
    switch (to->cpp_type()) {
      case pb::FieldDescriptor::CPPTYPE_STRING:
        adds ? reflection->AddString(message, to, utf8(value.text))
             : reflection->SetString(message, to, utf8(value.text));
        break;
      case pb::FieldDescriptor::CPPTYPE_BOOL:
        adds ? reflection->AddBool(message, to, value.integer != 0)
             : reflection->SetBool(message, to, value.integer != 0);
        break;
      case pb::FieldDescriptor::CPPTYPE_FLOAT:
        adds ? reflection->AddFloat(message, to, static_cast<float>(value.real))
             : reflection->SetFloat(message, to, static_cast<float>(value.real));
        break;
      case pb::FieldDescriptor::CPPTYPE_DOUBLE:
        adds ? reflection->AddDouble(message, to, value.real) : reflection->SetDouble(message, to, value.real);
        break;
      case pb::FieldDescriptor::CPPTYPE_UINT32:
        reflection->SetUInt32(message, to, static_cast<std::uint32_t>(value.integer));
        break;
      default:
        adds ? reflection->AddInt64(message, to, value.integer) : reflection->SetInt64(message, to, value.integer);
        break;
    }
  }
  void bytes(const Field& field, std::span<const std::byte> bytes) override {
    const auto [message, reflection, to] = where(field);
    reflection->SetString(message, to, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  void begin_list(const Field&, std::size_t) override {}
  void end_list(const Field&) override {}
  void begin_record(const Field& field, std::size_t) override {
    const auto [message, reflection, to] = where(field);
    at_.push_back(to->is_repeated() ? reflection->AddMessage(message, to) : reflection->MutableMessage(message, to));
  }
  void end_record(const Field&) override { at_.pop_back(); }

 private:
  struct Where {
    pb::Message* message;
    const pb::Reflection* reflection;
    const pb::FieldDescriptor* to;
  };
  Where where(const Field& field) const {
    return {at_.back(), at_.back()->GetReflection(), at_.back()->GetDescriptor()->FindFieldByName(field.name)};
  }
  std::vector<pb::Message*> at_;
};

void add_with_dependencies(pb::FileDescriptorSet& to, const pb::FileDescriptor& file, std::set<std::string>& added) {
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_with_dependencies(to, *file.dependency(i), added);
  file.CopyTo(to.add_file());
}

}  // namespace

std::string utf8(std::string_view text) {
  if (std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; })) return std::string(text);
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

std::string proto_schema(const pb::Descriptor& type) {
  pb::FileDescriptorSet set;
  std::set<std::string> added;
  add_with_dependencies(set, *type.file(), added);
  return set.SerializeAsString();
}

ProtoTypes::ProtoTypes() : factory_(&pool_) {
  pb::FileDescriptorProto file;
  file.set_name("arkmesh.proto");
  file.set_package("arkmesh");
  file.set_syntax("proto3");
  for (const auto& type : types().all()) {
    pb::DescriptorProto& message = *file.add_message_type();
    message.set_name(type->name);
    for (const Field& field : type->fields) {
      pb::FieldDescriptorProto& one = *message.add_field();
      one.set_name(field.name);
      one.set_number(message.field_size());
      one.set_type(type_of_kind(field));
      if (field.type) one.set_type_name(".arkmesh." + field.type->name);
      one.set_label(field.sizes.empty() || field.kind == Kind::byte ? pb::FieldDescriptorProto::LABEL_OPTIONAL
                                                                    : pb::FieldDescriptorProto::LABEL_REPEATED);
    }
  }
  pool_.BuildFile(file);
}

const pb::Descriptor& ProtoTypes::of(const Type& type) const {
  return *pool_.FindMessageTypeByName("arkmesh." + type.name);
}

void ProtoTypes::encode(std::string& to, const Type& type, std::span<const std::byte> message) {
  const std::unique_ptr<pb::Message> out(factory_.GetPrototype(&of(type))->New());
  ProtoWriter writer(*out);
  visit(type, message, writer);
  out->SerializeToString(&to);
}

}  // namespace arkmesh::recording
