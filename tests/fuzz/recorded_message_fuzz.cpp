// Arbitrary bytes as a message of each of our types, and as of the type that they name. Nothing may crash, hang or take
// much memory.
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/layout/message.hpp"

namespace {

using namespace arkmesh::hal::layout;

class Sum : public Visitor {
 public:
  void value(const Field&, const Value& value) override {
    sum += static_cast<std::size_t>(value.integer) + value.text.size();
  }
  void bytes(const Field&, std::span<const std::byte> bytes) override { sum += bytes.size(); }
  void begin_list(const Field&, std::size_t count) override { sum += count; }
  void end_list(const Field&) override {}
  void begin_record(const Field&, std::size_t place) override { sum += place; }
  void end_record(const Field&) override {}

  std::size_t sum = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  Sum sum;
  // the first byte chooses the type, and its own fingerprint is put before the rest
  if (size > 0) {
    const Type& type = *types().all()[data[0] % types().all().size()];
    std::vector<std::byte> message;
    for (int shift = 56; shift >= 0; shift -= 8) message.push_back(static_cast<std::byte>(type.fingerprint >> shift));
    message.insert(message.end(), bytes.begin() + 1, bytes.end());
    if (check(type, message).empty()) visit(type, message, sum);
  }
  if (const Type* type = type_of(bytes, types())) visit(*type, bytes, sum);
  return 0;
}
