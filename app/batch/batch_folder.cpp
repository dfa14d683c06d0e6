#include "app/batch/batch_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <utility>

#include "app/batch/batch_manifest.hpp"
#include "app/batch/plain_json.hpp"
#include "hal/config/config.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// Runs of a batch that was killed a moment ago are about to end.
constexpr auto patience = 3s;

bool holds_nothing(const fs::path& directory) {
  for (const auto& entry : fs::directory_iterator(directory))
    if (const std::string name = entry.path().filename().string();
        name != "lock" && name != "runs.lock" && !name.starts_with("manifest.json."))
      return false;
  return true;
}

}  // namespace

fs::path BatchFolder::run_folder(const fs::path& batch, std::size_t number) {
  return batch / "runs" / fmt::format("{:05}", number);
}

void BatchFolder::take(Use use) {
  std::error_code error;
  fs::create_directories(directory_, error);
  lock_ = error ? -1 : ::open((directory_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0)
    throw std::runtime_error(fmt::format("cannot write in {}: {}; choose another folder with --out",
                                         directory_.string(), error ? error.message() : std::strerror(errno)));
  if (use == Use::looking) return;
  const int kind = (use == Use::alone ? LOCK_EX : LOCK_SH) | LOCK_NB;
  const auto until = std::chrono::steady_clock::now() + patience;
  while (::flock(lock_, kind) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return;  // a file system without locks
    if (std::chrono::steady_clock::now() > until)
      throw hal::ConfigError(
          fmt::format("another arkmesh is using {}; wait until it ends, or stop it", directory_.string()));
    std::this_thread::sleep_for(20ms);
  }
}

BatchFolder::BatchFolder(fs::path directory, const nlohmann::json& manifest, Use use)
    : directory_(std::move(directory)) {
  const fs::path file = directory_ / "manifest.json";
  std::error_code error;
  if (fs::is_directory(directory_, error) && !fs::exists(file, error) && !holds_nothing(directory_))
    throw hal::ConfigError(
        fmt::format("{} is not the folder of a batch; give another one with --out", directory_.string()));
  if (use == Use::looking && !fs::exists(file, error))
    throw hal::ConfigError(
        fmt::format("{} holds no batch; give its folder with --out, or run it first", directory_.string()));
  take(use);
  if (fs::exists(file, error)) {
    const std::string why = difference(read_json(file), manifest, use == Use::looking);
    if (!why.empty())
      throw hal::ConfigError(fmt::format("{}: {}; give another folder with --out", directory_.string(), why));
  } else if (const int failed = hal::replace_json(file, manifest); failed != 0 && !fs::exists(file, error)) {
    throw std::runtime_error(fmt::format("{} cannot be written: {}", file.string(), std::strerror(failed)));
  }
}

bool BatchFolder::take_run(std::size_t number) {
  // A file of its own: where the disk is another machine's, both kinds of locks are one.
  if (runs_lock_ < 0) runs_lock_ = ::open((directory_ / "runs.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  struct flock byte {};
  byte.l_type = F_WRLCK;
  byte.l_whence = SEEK_SET;
  byte.l_start = static_cast<off_t>(number);
  byte.l_len = 1;
  return runs_lock_ < 0 || ::fcntl(runs_lock_, F_OFD_SETLK, &byte) == 0 || (errno != EAGAIN && errno != EACCES);
}

BatchFolder::~BatchFolder() {
  if (runs_lock_ >= 0) ::close(runs_lock_);
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace arkmesh::app
