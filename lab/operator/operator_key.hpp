// The key of operators: a file of the user who runs labs on this machine, that no other user can read. Who has it may
// command those labs. 32 random bytes as 64 hexadecimal digits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace arkmesh::lab {

class OperatorKey {
 public:
  // Empty: operator.key in $XDG_CONFIG_HOME/arkmesh or ~/.config/arkmesh.
  explicit OperatorKey(std::filesystem::path file = {});

  const std::filesystem::path& file() const { return file_; }
  // Unless it is there; says whether it was not. Throws hal::ConfigError when there is no place for it,
  // std::runtime_error when the disk refuses.
  bool make() const;
  // Throws hal::ConfigError, in one sentence, when there is no key, when others can read it, or when it is damaged;
  // std::runtime_error when the machine cannot read it at the moment.
  void read();
  // As long as that of an operator_command_t, by the key that was read last; nothing before.
  std::optional<std::vector<std::uint8_t>> prove(std::span<const std::uint8_t> bytes) const;
  // In a time that does not depend on where the proof is wrong.
  bool proves(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> proof) const;

 private:
  std::filesystem::path file_;
  std::vector<std::uint8_t> key_;
};

}  // namespace arkmesh::lab
