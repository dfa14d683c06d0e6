// Messages of any of our types as protocol buffers, and schemas as MCAP's readers want them.
#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/dynamic_message.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hal/layout/message.hpp"

namespace arkmesh::recording {

// A text as protocol buffers take it: bytes that are not UTF-8 become U+FFFD.
std::string utf8(std::string_view text);
// The file of a type and all that it takes from others, google.protobuf's among them, as a FileDescriptorSet.
std::string proto_schema(const google::protobuf::Descriptor& type);

// The types of lcmtypes/ as arkmesh.NAME, fields numbered from 1 in their order: lists are repeated, lists of bytes
// bytes.
class ProtoTypes {
 public:
  ProtoTypes();
  const google::protobuf::Descriptor& of(const hal::layout::Type& type) const;
  // Replaces `to` by a message that check() has passed.
  void encode(std::string& to, const hal::layout::Type& type, std::span<const std::byte> message);

 private:
  google::protobuf::DescriptorPool pool_;
  google::protobuf::DynamicMessageFactory factory_;
};

}  // namespace arkmesh::recording
