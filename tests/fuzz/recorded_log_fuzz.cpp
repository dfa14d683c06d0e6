// Arbitrary bytes as a log, as a compressed one, inside one, and as the index of a good log with a right check sum.
// Nothing may crash, hang or take much memory, and no index may show a message that its log does not have.
#include <unistd.h>
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hal/record/recorder.hpp"
#include "recording/log.hpp"

namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
}

// Folders of this process: a log of anything, and a good one.
struct Folders {
  fs::path any = fs::temp_directory_path() / ("arkmesh-fuzz-" + std::to_string(::getpid())), good = any / "good";
  Folders() {
    arkmesh::hal::Recorder recorder(good, 1'700'000'000'000'000, {});
    for (int i = 0; i < 3; ++i)
      recorder.record(arkmesh::hal::LabTime{i * 1000}, i == 1 ? "poses" : "status", std::vector<std::byte>(20));
  }
  ~Folders() {
    std::error_code error;
    fs::remove_all(any, error);
  }
};

void use(const fs::path& file) {
  try {
    const arkmesh::recording::Log log(file);
    for (std::size_t i = 0; i < log.channels().size(); ++i)
      if (const auto newest = log.newest(i, log.length_us())) (void)log.read(log.entries()[*newest]);
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folders folders;
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::error_code error;
  fs::remove(folders.any / "log.index", error);
  write(folders.any / "log.lcm", std::string("\xED\xA1\xDA\x01", 4) + text);
  use(folders.any / "log.lcm");
  write(folders.any / "packed.lcm.zst", std::string("\x28\xB5\x2F\xFD", 4) + text);
  use(folders.any / "packed.lcm.zst");
  arkmesh::hal::FramePacker packer;
  const std::string plain = std::string("\xED\xA1\xDA\x01", 4) + text;
  const auto frame = packer.pack(std::as_bytes(std::span(plain)));
  fs::remove(folders.any / "packed.index", error);
  write(folders.any / "packed.lcm.zst", {reinterpret_cast<const char*>(frame.data()), frame.size()});
  use(folders.any / "packed.lcm.zst");

  std::string index = "ARKIDX01" + text;
  auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(index.data()), index.size()));
  for (int i = 0; i < 4; ++i, sum >>= 8) index += static_cast<char>(sum);
  write(folders.good / "log.index", index);
  use(folders.good / "log.lcm");
  return 0;
}
